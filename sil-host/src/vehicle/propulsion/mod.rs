//! From a motor's command to its lift, in three levels of detail: the thesis' three continuous-time models
//! (section 3.3). Each level is one file: its parameters, its static curve, its dynamics.
//!
//! | level | thesis | states of a motor |
//! |---|---|---|
//! | [`FlyingBox`] | 3.3.2, conceptual | none: lift follows the command at once |
//! | [`GenericRotor`] | 3.3.3, generic components | speed, first-order lag |
//! | [`DevicePropulsion`] | 3.3.4 and appendix C, specific device | speed and winding current |
//!
//! Lift and reaction torque are proportional to each other on every level (both go with the speed's square).

mod device;
mod flying_box;
mod four_arms;
mod generic;
mod look_up_table;

use super::{NetSpin, spin_sum};
use crate::document::{Admissible, ModelError, Section, Table, admissible};

pub use device::{DevicePropulsion, Esc};
pub use flying_box::FlyingBox;
pub(crate) use four_arms::FourArms;
pub use generic::GenericRotor;
pub use look_up_table::{LookUpTable, POINTS_MAX};

/// Speeds (rad/s) of motors 1 to 4, then their winding currents (A). A level without one of them holds it still.
pub type RotorState = [f64; 8];

const LIFT: Admissible = admissible(1e-9, 1e-2, "the lift coefficient in N s^2/rad^2");
const TORQUE: Admissible = admissible(0.0, 1e-4, "the reaction torque coefficient in N m s^2/rad^2");

/// How much detail a propulsion model has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Lift straight from the command.
    Box,
    /// Rotor speed with a first-order lag.
    Generic,
    /// Speed controller, motor and rotor.
    Device,
}

impl Level {
    /// Names in model files.
    pub const NAMES: [(&'static str, Level); 3] =
        [("box", Level::Box), ("generic", Level::Generic), ("device", Level::Device)];

    /// Its name in model files.
    pub fn name(self) -> &'static str {
        match self {
            Level::Box => "box",
            Level::Generic => "generic",
            Level::Device => "device",
        }
    }
}

/// The propulsion of one arm; in a model all four are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a table lies in the model itself, so that models stay plain values; they are few and passed by reference"
)]
pub enum Propulsion {
    /// Conceptual model.
    Box(FlyingBox),
    /// Generic components.
    Generic(GenericRotor),
    /// Specific device.
    Device(DevicePropulsion),
}

/// Where one motor settles at a constant command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    /// Rotor speed, rad/s; 0 on level [`Level::Box`], which has no rotor.
    pub speed_rad_s: f64,
    /// Lift, N.
    pub lift_n: f64,
    /// Reaction torque on the airframe, N m, without its sign.
    pub reaction_torque_nm: f64,
    /// Winding current, A; 0 on levels without a motor.
    pub current_a: f64,
}

impl Propulsion {
    /// How much detail it has.
    pub fn level(&self) -> Level {
        match self {
            Self::Box(_) => Level::Box,
            Self::Generic(_) => Level::Generic,
            Self::Device(_) => Level::Device,
        }
    }

    /// Where one motor settles at `command` (0..1).
    pub fn equilibrium(&self, command: f64) -> Equilibrium {
        let (speed_rad_s, current_a, lift_n) = match self {
            Self::Box(flying_box) => (0.0, 0.0, flying_box.lift_n(command)),
            Self::Generic(rotor) => {
                let speed_rad_s = rotor.target_speed_rad_s(command);
                (speed_rad_s, 0.0, rotor.lift_n(speed_rad_s))
            }
            Self::Device(device) => {
                let (speed_rad_s, current_a) = device.equilibrium(device.voltage_v(command));
                (speed_rad_s, current_a, device.lift_n(speed_rad_s))
            }
        };
        Equilibrium { speed_rad_s, lift_n, reaction_torque_nm: lift_n * self.reaction_torque_per_lift_m(), current_a }
    }

    /// Lift at which one motor settles at `command` (0..1), N.
    pub fn lift_n(&self, command: f64) -> f64 {
        self.equilibrium(command).lift_n
    }

    /// Reaction torque over lift, N m / N.
    pub fn reaction_torque_per_lift_m(&self) -> f64 {
        match self {
            Self::Box(flying_box) => flying_box.reaction_torque_per_lift_m,
            Self::Generic(rotor) => rotor.reaction_torque_nm_s2 / rotor.lift_n_s2,
            Self::Device(device) => device.reaction_torque_nm_s2 / device.lift_n_s2,
        }
    }

    /// Reads `level` and the table `[propulsion]` that goes with it.
    pub(crate) fn read(root: &Section<'_>) -> Result<Self, ModelError> {
        let level = root.choice("level", &Level::NAMES)?;
        let section = root.section("propulsion")?;
        let propulsion = match level {
            Level::Box => Self::Box(FlyingBox::read(&section)?),
            Level::Generic => Self::Generic(GenericRotor::read(&section)?),
            Level::Device => Self::Device(DevicePropulsion::read(&section)?),
        };
        section.finish()?;
        Ok(propulsion)
    }

    pub(crate) fn write(&self, table: &mut Table) {
        table.header("[propulsion]");
        match self {
            Self::Box(flying_box) => flying_box.write(table),
            Self::Generic(rotor) => rotor.write(table),
            Self::Device(device) => device.write(table),
        }
    }

    /// What drives a motor at `command`, in the unit that [`Propulsion::derivative`] takes: computed once per
    /// command, so that no exponential is left for the integrator.
    pub(crate) fn drive(&self, command: f64) -> f64 {
        match self {
            Self::Box(flying_box) => flying_box.lift_n(command),
            Self::Generic(rotor) => rotor.target_speed_rad_s(command),
            Self::Device(device) => device.voltage_v(command),
        }
    }

    /// Rate of change of the rotors' state under `drive`.
    #[inline]
    pub(crate) fn derivative(&self, drive: &[f64; 4], rotors: &RotorState) -> RotorState {
        match self {
            Self::Box(_) => [0.0; 8],
            Self::Generic(rotor) => rotor.derivative(drive, rotors),
            Self::Device(device) => device.derivative(drive, rotors),
        }
    }

    /// Lifts of motors 1 to 4, N.
    #[inline]
    pub(crate) fn lifts_n(&self, drive: &[f64; 4], rotors: &RotorState) -> [f64; 4] {
        let speeds = [rotors[0], rotors[1], rotors[2], rotors[3]];
        match self {
            Self::Box(_) => *drive,
            Self::Generic(rotor) => speeds.map(|speed| rotor.lift_n(speed)),
            Self::Device(device) => speeds.map(|speed| device.lift_n(speed)),
        }
    }

    /// The same of one motor: its speed (rad/s) and winding current (A).
    #[inline]
    fn derivative_of_motor(&self, drive: f64, state: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Box(_) => [0.0; 2],
            Self::Generic(rotor) => [rotor.derivative_of_motor(drive, state[0]), 0.0],
            Self::Device(device) => device.derivative_of_motor(drive, state),
        }
    }

    /// Lift of one motor, N.
    #[inline]
    fn lift_of_motor_n(&self, drive: f64, speed_rad_s: f64) -> f64 {
        match self {
            Self::Box(_) => drive,
            Self::Generic(rotor) => rotor.lift_n(speed_rad_s),
            Self::Device(device) => device.lift_n(speed_rad_s),
        }
    }

    /// The rotors' spin about the body's z axis, of their state and its rate of change.
    #[inline]
    pub(crate) fn net_spin(rotors: &RotorState, change: &RotorState) -> NetSpin {
        let of = |[a, b, c, d, ..]: &RotorState| spin_sum([*a, *b, *c, *d]);
        NetSpin { speed_rad_s: of(rotors), acceleration_rad_s2: of(change) }
    }

    /// Longest integration step that still follows the fastest part of it, s.
    pub(crate) fn step_max_s(&self) -> f64 {
        match self {
            Self::Box(_) => f64::INFINITY,
            Self::Generic(rotor) => 0.5 * rotor.time_constant_s,
            Self::Device(device) => 0.5 * device.inductance_h / device.resistance_ohm,
        }
    }
}

#[cfg(test)]
mod tests;
