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

#[cfg(test)]
mod tests {
    use super::*;

    fn vehicle(yaw_locked: bool) -> VehicleParameters {
        VehicleParameters { yaw_locked, ..VehicleParameters::F450_GIMBAL }
    }

    /// `docs/tuning.md`: at 100 Hz, or at 0.4 of the loop rate where that is less.
    #[test]
    fn the_gyros_low_pass_lets_no_noise_fold_down() {
        let tuning = Tuning::for_motor_lag(0.0);
        for (loop_rate_hz, cutoff_hz) in [(400.0, 100.0), (250.0, 100.0), (200.0, 80.0), (100.0, 40.0)] {
            assert!((gyro_cutoff(&tuning, loop_rate_hz) - cutoff_hz).abs() < 1e-4, "{loop_rate_hz}");
        }
    }

    /// The reference may use its share of what the motors can do, the correction half of that.
    #[test]
    fn limits_follow_from_the_vehicles_authority() {
        let (vehicle, tuning) = (vehicle(true), Tuning { acceleration_share: 0.5, ..Tuning::for_motor_lag(0.0) });
        let config = angle_config(&vehicle, &tuning);
        for (axis, authority) in vehicle.acceleration_authority_rad_s2().into_iter().enumerate() {
            assert!((config.shaping[axis].acceleration_max_rad_s2 / authority - 0.5).abs() < 1e-6);
            assert!((config.acceleration_max_rad_s2[axis] / authority - 0.25).abs() < 1e-6);
            assert_eq!(config.shaping[axis].gain_1_s, tuning.shaping_gain_1_s[axis]);
            assert_eq!(config.gain_1_s[axis], tuning.angle_gain_1_s[axis]);
        }
        assert!(config.yaw_locked);
    }

    /// Gains are the tuning's, but for a heading that can't move, which has none.
    #[test]
    fn a_locked_heading_has_no_rate_loop() {
        let tuning = Tuning { rate_derivative: [0.1, 0.2, 0.3], ..Tuning::for_motor_lag(0.02) };
        for locked in [false, true] {
            let authority = vehicle(locked).acceleration_authority_rad_s2();
            for (axis, gains) in rate_gains(&vehicle(locked), &tuning, 400.0).into_iter().enumerate() {
                let expected = if locked && axis == 2 {
                    [0.0; 3]
                } else {
                    [tuning.rate_proportional_1_s[axis], tuning.rate_integral_1_s2[axis], tuning.rate_derivative[axis]]
                };
                assert_eq!([gains.proportional_1_s, gains.integral_1_s2, gains.derivative], expected);
                assert!((gains.integral_max_rad_s2 / authority[axis] - 0.8).abs() < 1e-6);
            }
        }
    }
}
