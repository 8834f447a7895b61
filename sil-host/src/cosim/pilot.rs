//! A pilot who holds a height in free flight by the throttle stick, as the controllers here have none for it.
//!
//! Lift goes with the square of the command, roughly: near hover an acceleration a takes a change of `a / (2 g)` of the
//! command. What is requested is `a = w^2 e + 2 z w e' + k int e`, divided by the tilt's cosine, as who flies does by
//! eye.

use crate::cosim::contract::DesignParameters;
use crate::plant::Truth;

/// How quickly a height is taken, rad/s: slower than attitude, so that the two don't meet.
const FREQUENCY_RAD_S: f64 = 1.5;
const DAMPING: f64 = 0.9;
/// Of the integral, 1/s^3: what the vehicle is heavier or weaker by is learnt within seconds.
const INTEGRAL_S3: f64 = 0.7;
/// The largest acceleration that is requested, m/s^2.
const ACCELERATION_MAX_M_S2: f64 = 3.0;
/// Least cosine of the tilt that is made up for.
const TILT_COSINE_MIN: f64 = 0.5;

/// What the hand has learnt.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pilot {
    learnt_m_s2: f64,
}

impl Pilot {
    /// The throttle of the next control step, 0..1, to be so far above the start, m.
    pub(super) fn throttle(&mut self, parameters: &DesignParameters, truth: &Truth, climb_m: f64) -> f64 {
        let (miss_m, sinking_m_s) = (climb_m + truth.position_ned_m[2], truth.velocity_ned_m_s[2]);
        self.learnt_m_s2 += INTEGRAL_S3 * miss_m / f64::from(parameters.control_rate_hz.max(1));
        let asked_m_s2 = FREQUENCY_RAD_S * (FREQUENCY_RAD_S * miss_m + 2.0 * DAMPING * sinking_m_s) + self.learnt_m_s2;
        let asked_m_s2 = asked_m_s2.clamp(-ACCELERATION_MAX_M_S2, ACCELERATION_MAX_M_S2);
        let upright = (libm::cos(truth.roll_rad) * libm::cos(truth.pitch_rad)).max(TILT_COSINE_MIN);
        let lift_over_weight = (1.0 + asked_m_s2 / parameters.gravity_m_s2.max(1.0)) / upright;
        (parameters.base_command * (0.5 + 0.5 * lift_over_weight)).clamp(0.0, 1.0)
    }
}
