//! The cascade's part of the configuration: attitude loop and rate loop.

use super::tuning::Tuning;
use crate::attitude::angle::AngleConfig;
use crate::attitude::rate::RateGains;
use crate::attitude::shaping::ShapingConfig;
use crate::elementary::smaller;
use crate::filter::LowPass1;
use crate::vehicle::VehicleParameters;

/// Noise above half the loop rate would fold down: the cut-off stays at or below 0.4 of the loop rate.
pub(super) fn gyro_cutoff(tuning: &Tuning, loop_rate_hz: f32) -> f32 {
    smaller(tuning.gyro_cutoff_hz, 0.4 * loop_rate_hz)
}

/// Limits and gains of the attitude loop, as the vehicle's authority allows.
pub(super) fn angle_config(vehicle: &VehicleParameters, tuning: &Tuning) -> AngleConfig {
    let acceleration_max = vehicle.acceleration_authority_rad_s2().map(|a| a * tuning.acceleration_share);
    AngleConfig {
        shaping: core::array::from_fn(|axis| ShapingConfig {
            gain_1_s: tuning.shaping_gain_1_s[axis],
            acceleration_max_rad_s2: acceleration_max[axis],
            rate_max_rad_s: tuning.rate_max_rad_s[axis],
        }),
        gain_1_s: tuning.angle_gain_1_s,
        // the reference may use it all; the correction counts on half of it, as both can act together
        acceleration_max_rad_s2: acceleration_max.map(|a| 0.5 * a),
        rate_max_rad_s: tuning.rate_max_rad_s,
        tilt_max_rad: tuning.tilt_max_rad,
        acceleration_feed_forward: tuning.acceleration_feed_forward,
        yaw_locked: vehicle.yaw_locked,
    }
}

/// Gains of the rate loop.
pub(super) fn rate_gains(vehicle: &VehicleParameters, tuning: &Tuning, loop_rate_hz: f32) -> [RateGains; 3] {
    let authority = vehicle.acceleration_authority_rad_s2();
    // a heading that can't move has no rate error: on the gimbal r = -theta' sin phi, which an integral would collect
    let active = |axis: usize| if axis == 2 && vehicle.yaw_locked { 0.0 } else { 1.0 };
    core::array::from_fn(|axis| RateGains {
        proportional_1_s: active(axis) * tuning.rate_proportional_1_s[axis],
        integral_1_s2: active(axis) * tuning.rate_integral_1_s2[axis],
        derivative: active(axis) * tuning.rate_derivative[axis],
        integral_max_rad_s2: tuning.integral_share * authority[axis],
        derivative_filter: LowPass1::new(tuning.rate_derivative_cutoff_hz, loop_rate_hz),
    })
}
