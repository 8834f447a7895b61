//! What commands do to a vehicle's motors, or to separate axes by themselves.

use crate::vehicle::propulsion::Propulsion;
use crate::vehicle::{CommandPath, signed_sums};

/// What is quickest in motors with windings, s, and the least that is followed of a lag.
pub(super) const QUICKEST_S: f64 = 1.6e-3;

/// What turns commands into forces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a table lies in the model itself, so that models stay plain values; they are few and passed by reference"
)]
pub(crate) enum Drive {
    /// Motors with propellers: the forces are their lifts, N.
    Motors(Propulsion),
    /// Nothing: the forces are the commands themselves.
    Direct(DirectInput),
}

/// What drives separate axes, of whose motors nothing is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DirectInput {
    /// Commands of the axes (roll, pitch, yaw, 0), -1..1.
    Axes,
    /// Commands of four motors, 0..1.
    Motors,
    /// The same of motors that turn the other way than docs/rig.md's.
    ReversedMotors,
}

impl DirectInput {
    /// What acts about roll, pitch and yaw: of motors half the signed sum, so that it lies in -1..1 too.
    #[inline]
    pub(crate) fn about_axes(self, force: [f64; 4]) -> [f64; 3] {
        match self {
            DirectInput::Axes => [force[0], force[1], force[2]],
            DirectInput::Motors => signed_sums(force).map(|sum| 0.5 * sum),
            DirectInput::ReversedMotors => {
                let [roll, pitch, yaw] = DirectInput::Motors.about_axes(force);
                [roll, pitch, -yaw]
            }
        }
    }
}

impl Drive {
    /// Forces once lag and motors have settled.
    pub(crate) fn settled(&self, commands: &[f64; 4], path: &CommandPath) -> [f64; 4] {
        let bent = self.bent(*commands, path);
        match self {
            Drive::Motors(propulsion) => bent.map(|command| propulsion.lift_n(command)),
            Drive::Direct(_) => bent,
        }
    }

    /// What is quickest in it, s.
    pub(crate) fn quickest_s(&self) -> f64 {
        match self {
            Drive::Motors(Propulsion::Device(_)) => QUICKEST_S,
            Drive::Motors(Propulsion::Generic(rotor)) => rotor.time_constant_s,
            Drive::Motors(Propulsion::Box(_)) | Drive::Direct(_) => f64::INFINITY,
        }
    }

    /// What commands act as behind the lag; those of axes have no curve.
    #[inline]
    pub(super) fn bent(&self, commands: [f64; 4], path: &CommandPath) -> [f64; 4] {
        match self {
            Drive::Direct(DirectInput::Axes) => commands,
            Drive::Motors(_) | Drive::Direct(DirectInput::Motors | DirectInput::ReversedMotors) => {
                commands.map(|command| path.bent(command))
            }
        }
    }

    /// What commands make the motors do, in the unit of [`Propulsion::derivative`]; without motors the commands
    /// themselves.
    pub(super) fn of_commands(&self, commands: &[f64; 4]) -> [f64; 4] {
        match self {
            Drive::Motors(propulsion) => core::array::from_fn(|motor| propulsion.drive(commands[motor])),
            Drive::Direct(_) => *commands,
        }
    }

    /// What of a command arrives behind the limits of the speed controllers.
    pub(crate) fn clipped(&self, command: [f64; 4], path: &CommandPath) -> [f64; 4] {
        core::array::from_fn(|i| match self {
            Drive::Motors(_) | Drive::Direct(DirectInput::Motors | DirectInput::ReversedMotors) => {
                path.clipped(command[i])
            }
            Drive::Direct(DirectInput::Axes) => path.clipped_about_zero(command[i]),
        })
    }
}
