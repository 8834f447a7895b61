//! The square-root controller: proportional near the target, and far from it no faster than a constant deceleration
//! can still stop.

use crate::elementary::{limit, magnitude, smaller, sqrt};

/// Rate (unit/s) to request at a given error (unit).
///
/// Within `acceleration_max / gain^2` the law is `gain * error`; beyond, sqrt(2 a (|error| - a / (2 gain^2))), which
/// meets the line with equal value and slope. Never so fast that one step of `dt_s` overshoots the target.
/// (AC_AttitudeControl's `sqrt_controller`.)
pub fn square_root_controller(error: f32, gain_1_s: f32, acceleration_max: f32, dt_s: f32) -> f32 {
    let distance = magnitude(error);
    let linear_distance = acceleration_max / (gain_1_s * gain_1_s);
    let speed = if distance > linear_distance {
        sqrt(2.0 * acceleration_max * (distance - 0.5 * linear_distance))
    } else {
        gain_1_s * distance
    };
    let speed = smaller(speed, distance / dt_s);
    limit(if error < 0.0 { -speed } else { speed }, -1e6, 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_odd_monotone_and_continuous(error in 0f32..3.0, gain in 1f32..15.0, acceleration in 1f32..60.0) {
            let at = |e| square_root_controller(e, gain, acceleration, 0.0025);
            prop_assert_eq!(at(error), -at(-error));
            prop_assert!(at(error + 0.01) >= at(error));
            // slope nowhere above the linear gain
            prop_assert!(at(error + 0.001) - at(error) <= gain * 0.001 * 1.01 + 1e-5);
        }

        #[test]
        fn stops_without_overshoot_within_the_acceleration(start in 0.1f32..3.0, gain in 2f32..10.0) {
            let (acceleration, dt) = (20.0f32, 0.0025f32);
            let (mut angle, mut last) = (start, square_root_controller(-start, gain, acceleration, dt));
            for _ in 0..4000 {
                let rate = square_root_controller(-angle, gain, acceleration, dt);
                // deceleration stays within the limit; a chord of the concave root is steeper by up to gain * dt
                prop_assert!((rate - last).abs() <= acceleration * dt * (1.0 + gain * dt) + 1e-5);
                angle += rate * dt;
                last = rate;
                prop_assert!(angle >= -1e-6);
            }
            prop_assert!(angle < 1e-3);
        }
    }
}
