//! The propulsion of the four arms of one vehicle: alike as in a model, or each with the constants of its own parts.

use super::{Equilibrium, Level, Propulsion, RotorState};

/// Motors 1 to 4 with their speed controllers and rotors.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "what nearly every vehicle has lies in the plant itself, where the integrator reads it all the time"
)]
pub(crate) enum FourArms {
    /// All four are one.
    Alike(Propulsion),
    /// Each is another.
    Apart(Box<[Propulsion; 4]>),
}

impl FourArms {
    /// Of a model: one for all, unless there is one for each.
    pub(crate) fn of(for_all: &Propulsion, each: Option<&[Propulsion; 4]>) -> Self {
        each.map_or(Self::Alike(*for_all), |arms| Self::Apart(Box::new(*arms)))
    }

    fn of_motor(&self, motor: usize) -> &Propulsion {
        match self {
            Self::Alike(propulsion) => propulsion,
            Self::Apart(arms) => &arms[motor],
        }
    }

    /// How much detail they have.
    pub(crate) fn level(&self) -> Level {
        self.of_motor(0).level()
    }

    /// What drives the motors at these commands (0..1), see [`Propulsion::drive`].
    pub(crate) fn drive(&self, commands: [f64; 4]) -> [f64; 4] {
        core::array::from_fn(|motor| self.of_motor(motor).drive(commands[motor]))
    }

    /// Where a motor (0 to 3) settles at `command` (0..1).
    pub(crate) fn equilibrium(&self, motor: usize, command: f64) -> Equilibrium {
        self.of_motor(motor).equilibrium(command)
    }

    /// Lifts of motors 1 to 4, N.
    #[inline]
    pub(crate) fn lifts_n(&self, drive: &[f64; 4], rotors: &RotorState) -> [f64; 4] {
        match self {
            Self::Alike(propulsion) => propulsion.lifts_n(drive, rotors),
            Self::Apart(arms) => core::array::from_fn(|motor| arms[motor].lift_of_motor_n(drive[motor], rotors[motor])),
        }
    }

    /// Rate of change of the rotors' state under `drive`.
    #[inline]
    pub(crate) fn derivative(&self, drive: &[f64; 4], rotors: &RotorState) -> RotorState {
        match self {
            Self::Alike(propulsion) => propulsion.derivative(drive, rotors),
            Self::Apart(arms) => {
                let mut change = [0.0; 8];
                for (motor, arm) in arms.iter().enumerate() {
                    let of_motor = arm.derivative_of_motor(drive[motor], [rotors[motor], rotors[4 + motor]]);
                    [change[motor], change[4 + motor]] = of_motor;
                }
                change
            }
        }
    }

    /// Reaction torques over lift of motors 1 to 4, m; none where one number holds for all.
    #[inline]
    pub(crate) fn own_reactions_per_lift_m(&self) -> Option<[f64; 4]> {
        match self {
            Self::Alike(_) => None,
            Self::Apart(arms) => Some(core::array::from_fn(|motor| arms[motor].reaction_torque_per_lift_m())),
        }
    }

    /// Longest integration step that still follows the fastest part of any arm, s.
    pub(crate) fn step_max_s(&self) -> f64 {
        (0..4).map(|motor| self.of_motor(motor).step_max_s()).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::VehicleModel;
    use crate::vehicle::Rig;

    /// Four equal arms told one by one are the four arms told at once, to the bit, on every level.
    #[test]
    fn arms_apart_that_are_equal_are_arms_alike() {
        let (drive, rotors) = ([3.0, 5.0, 4.0, 6.5], [500.0, 510.0, 0.0, 490.0, 4.0, 5.0, -1.0, 3.0]);
        for model in [VehicleModel::nominal(Rig::Free), VehicleModel::generic(Rig::Free)] {
            let alike = FourArms::of(&model.propulsion, None);
            let apart = FourArms::of(&model.propulsion, Some(&[model.propulsion; 4]));
            assert_eq!(alike.derivative(&drive, &rotors), apart.derivative(&drive, &rotors));
            assert_eq!(alike.lifts_n(&drive, &rotors), apart.lifts_n(&drive, &rotors));
            assert_eq!(alike.step_max_s(), apart.step_max_s());
            let ratio_m = model.propulsion.reaction_torque_per_lift_m();
            assert_eq!(apart.own_reactions_per_lift_m(), Some([ratio_m; 4]));
        }
    }
}
