//! The generic quadrotor (thesis 3.3.3): the components appear, each as simple as possible. A motor with its
//! speed controller is a first-order lag to a speed that is a straight line of the command; a rotor gives lift
//! `R_l w^2` and reaction torque `R_t w^2` (thesis C.5, C.6).

use super::RotorState;
use crate::document::{ModelError, Section, Table, admissible};

/// Speed by a first-order lag; lift and reaction torque by its square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GenericRotor {
    /// Target speed at command 0 if the line went on, rad/s.
    pub speed_offset_rad_s: f64,
    /// Target speed per unit of command, rad/s.
    pub speed_slope_rad_s: f64,
    /// Time constant of the lag, s.
    pub time_constant_s: f64,
    /// Lift coefficient R_l, N s²/rad².
    pub lift_n_s2: f64,
    /// Reaction torque coefficient R_t, N m s²/rad².
    pub reaction_torque_nm_s2: f64,
}

impl GenericRotor {
    pub(super) fn target_speed_rad_s(&self, command: f64) -> f64 {
        (self.speed_offset_rad_s + self.speed_slope_rad_s * command).max(0.0)
    }

    #[inline]
    pub(crate) fn lift_n(&self, speed_rad_s: f64) -> f64 {
        self.lift_n_s2 * speed_rad_s * speed_rad_s
    }

    /// `T dw/dt = target - w`
    #[inline]
    pub(crate) fn derivative(&self, target_rad_s: &[f64; 4], rotors: &RotorState) -> RotorState {
        let mut change = [0.0; 8];
        for motor in 0..4 {
            change[motor] = self.derivative_of_motor(target_rad_s[motor], rotors[motor]);
        }
        change
    }

    /// Rate of change of a motor's speed (rad/s).
    #[inline]
    pub(super) fn derivative_of_motor(&self, target_rad_s: f64, speed: f64) -> f64 {
        (target_rad_s - speed) * (1.0 / self.time_constant_s)
    }

    pub(super) fn read(section: &Section<'_>) -> Result<Self, ModelError> {
        let offset = admissible(-5e3, 5e3, "the speed line's value at command 0 in rad/s");
        let slope = admissible(1.0, 1e4, "the speed per unit of command in rad/s");
        let lag = admissible(1e-4, 1.0, "the motor's time constant in seconds");
        Ok(Self {
            speed_offset_rad_s: section.number("speed_offset_rad_s", offset)?,
            speed_slope_rad_s: section.number("speed_slope_rad_s", slope)?,
            time_constant_s: section.number("time_constant_s", lag)?,
            lift_n_s2: section.number("lift_n_s2", super::LIFT)?,
            reaction_torque_nm_s2: section.number("reaction_torque_nm_s2", super::TORQUE)?,
        })
    }

    pub(super) fn write(&self, table: &mut Table) {
        table.number("speed_offset_rad_s", self.speed_offset_rad_s);
        table.number("speed_slope_rad_s", self.speed_slope_rad_s);
        table.number("time_constant_s", self.time_constant_s);
        table.number("lift_n_s2", self.lift_n_s2);
        table.number("reaction_torque_nm_s2", self.reaction_torque_nm_s2);
    }
}
