//! Arming: the one place that decides whether the motors may turn.

use crate::signals::{ArmingRequest, AttitudeEstimate, StepInput};

/// Largest throttle at which arming is allowed.
const ARMING_THROTTLE_MAX: f32 = 0.02;

/// May the motors turn?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arming {
    /// No; and why not, if somebody asked or it was taken away.
    Disarmed(DisarmedBecause),
    /// Yes.
    Armed,
}

/// Why the motors stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisarmedBecause {
    /// Nobody armed since start.
    Start,
    /// Asked for.
    Requested,
    /// Arming refused: throttle is not at zero.
    ThrottleNotZero,
    /// Arming refused or taken away: the attitude is not known.
    AttitudeUnknown,
}

impl Default for Arming {
    fn default() -> Self {
        Arming::Disarmed(DisarmedBecause::Start)
    }
}

/// Next arming state. Disarming is obeyed at any time.
pub fn update(arming: Arming, input: &StepInput, estimate: &AttitudeEstimate) -> Arming {
    let throttle_is_zero = input.setpoint.throttle <= ARMING_THROTTLE_MAX;
    match (arming, input.arming) {
        (_, ArmingRequest::Disarm) => Arming::Disarmed(DisarmedBecause::Requested),
        (Arming::Armed, ArmingRequest::None | ArmingRequest::Arm) if estimate.valid => Arming::Armed,
        (Arming::Armed, ArmingRequest::None | ArmingRequest::Arm) => Arming::Disarmed(DisarmedBecause::AttitudeUnknown),
        (Arming::Disarmed(because), ArmingRequest::None) => Arming::Disarmed(because),
        (Arming::Disarmed(_), ArmingRequest::Arm) if !estimate.valid => {
            Arming::Disarmed(DisarmedBecause::AttitudeUnknown)
        }
        (Arming::Disarmed(_), ArmingRequest::Arm) if !throttle_is_zero => {
            Arming::Disarmed(DisarmedBecause::ThrottleNotZero)
        }
        (Arming::Disarmed(_), ArmingRequest::Arm) => Arming::Armed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Setpoint;
    use nalgebra::{UnitQuaternion, Vector3};

    fn next(from: Arming, request: ArmingRequest, throttle: f32, valid: bool) -> Arming {
        let input =
            StepInput { arming: request, setpoint: Setpoint { throttle, ..Default::default() }, ..Default::default() };
        let estimate = AttitudeEstimate {
            q_world_from_body: UnitQuaternion::identity(),
            rate_body_rad_s: Vector3::zeros(),
            gyro_bias_rad_s: Vector3::zeros(),
            valid,
        };
        update(from, &input, &estimate)
    }

    #[test]
    fn every_transition_is_as_written() {
        use ArmingRequest::{Arm, Disarm, None};
        let start = Arming::default();
        assert_eq!(next(start, Arm, 0.0, true), Arming::Armed);
        assert_eq!(next(start, Arm, 0.5, true), Arming::Disarmed(DisarmedBecause::ThrottleNotZero));
        assert_eq!(next(start, Arm, f32::NAN, true), Arming::Disarmed(DisarmedBecause::ThrottleNotZero));
        assert_eq!(next(start, Arm, 0.0, false), Arming::Disarmed(DisarmedBecause::AttitudeUnknown));
        assert_eq!(next(start, None, 0.0, true), start);
        assert_eq!(next(Arming::Armed, None, 0.7, true), Arming::Armed);
        assert_eq!(next(Arming::Armed, None, 0.7, false), Arming::Disarmed(DisarmedBecause::AttitudeUnknown));
        assert_eq!(next(Arming::Armed, Disarm, 0.7, true), Arming::Disarmed(DisarmedBecause::Requested));
    }
}
