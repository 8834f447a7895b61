//! Acro: the pilot's sticks are rates about the body's axes, and nothing levels the vehicle.
//!
//! As PX4's acro and Betaflight's, not as ArduPilot's, which follows an attitude that the rates have moved: the rate
//! loop alone keeps the rates. The angle loop's reference goes along with the vehicle, so that it begins there when
//! angles are flown again.

use nalgebra::Vector3;

use crate::attitude::angle::{AngleConfig, RateTarget};
use crate::attitude::shaping::{AngleState, ShapedReference};
use crate::elementary::limit;
use crate::frames::{euler_from_q, euler_rates};
use crate::signals::AttitudeEstimate;

/// What the rate loop is to do until the next step. The rates move no faster than the shaped reference would, and reach
/// no further than the angle loop's; one that is not finite counts as zero.
pub fn update(
    config: &AngleConfig,
    state: &mut AngleState,
    before: &RateTarget,
    (wanted_rad_s, estimate): (&[f32; 3], &AttitudeEstimate),
    dt_s: f32,
) -> RateTarget {
    *state = moving_with(config, estimate);
    let rate_rad_s = Vector3::from_fn(|axis, _| {
        if axis == 2 && config.yaw_locked {
            return 0.0;
        }
        let wanted = if wanted_rad_s[axis].is_finite() { wanted_rad_s[axis] } else { 0.0 };
        let reach = config.shaping[axis].acceleration_max_rad_s2 * dt_s;
        let rate = limit(wanted, before.rate_rad_s[axis] - reach, before.rate_rad_s[axis] + reach);
        limit(rate, -config.rate_max_rad_s[axis], config.rate_max_rad_s[axis])
    });
    RateTarget { rate_rad_s, acceleration_rad_s2: Vector3::zeros() }
}

/// The reference that is where the vehicle is, and turns with it as fast as a reference may.
fn moving_with(config: &AngleConfig, estimate: &AttitudeEstimate) -> AngleState {
    let angles = euler_from_q(&estimate.q_world_from_body);
    let angles_rad = [angles.roll_rad, angles.pitch_rad, angles.yaw_rad];
    let rates_rad_s = euler_rates(angles, &estimate.rate_body_rad_s);
    AngleState {
        reference: core::array::from_fn(|axis| {
            let reach = config.shaping[axis].rate_max_rad_s;
            let moves = axis != 2 || !config.yaw_locked;
            let rate_rad_s = if moves { limit(rates_rad_s[axis], -reach, reach) } else { 0.0 };
            ShapedReference { angle_rad: angles_rad[axis], rate_rad_s }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::shaping::ShapingConfig;
    use crate::frames::{EulerAngles, q_world_from_euler};
    use proptest::prelude::*;

    const SHAPING: ShapingConfig = ShapingConfig { gain_1_s: 7.0, acceleration_max_rad_s2: 20.0, rate_max_rad_s: 3.0 };
    const STEP_S: f32 = 0.0025;

    fn config(yaw_locked: bool) -> AngleConfig {
        AngleConfig {
            shaping: [SHAPING; 3],
            gain_1_s: [8.0; 3],
            acceleration_max_rad_s2: [20.0; 3],
            rate_max_rad_s: [5.0, 5.0, 2.0],
            tilt_max_rad: 1.0,
            acceleration_feed_forward: 1.0,
            yaw_locked,
        }
    }

    fn vehicle(angles: EulerAngles, rate_body_rad_s: [f32; 3]) -> AttitudeEstimate {
        AttitudeEstimate {
            q_world_from_body: q_world_from_euler(angles),
            rate_body_rad_s: rate_body_rad_s.into(),
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        }
    }

    proptest! {
        /// Whatever is wanted and wherever the vehicle is: finite, within the limits, by bounded steps, and there in
        /// the time that the largest way takes (5 rad/s at 20 rad/s^2).
        #[test]
        fn rates_are_reached_by_bounded_steps(
            wanted in any::<[i8; 3]>(), angles in any::<[i8; 3]>(), rates in any::<[i8; 3]>(), locked: bool,
        ) {
            let config = config(locked);
            let wanted = wanted.map(|rate| f32::from(rate) * 0.08);
            let [roll_rad, pitch_rad, yaw_rad] = angles.map(|angle| f32::from(angle) / 41.0);
            let angles = EulerAngles { roll_rad, pitch_rad: pitch_rad / 2.0, yaw_rad };
            let estimate = vehicle(angles, rates.map(|rate| f32::from(rate) * 0.2));
            let (mut state, mut target) = (AngleState::default(), RateTarget::default());
            for _ in 0..110 {
                let next = update(&config, &mut state, &target, (&wanted, &estimate), STEP_S);
                let step = next.rate_rad_s - target.rate_rad_s;
                prop_assert!(step.amax() <= 20.0 * STEP_S * 1.001);
                prop_assert!(state.reference.iter().all(|axis| axis.rate_rad_s.abs() <= 3.0));
                target = next;
            }
            for (axis, (wanted, most)) in wanted.into_iter().zip(config.rate_max_rad_s).enumerate() {
                let reached = if axis == 2 && locked { 0.0 } else { limit(wanted, -most, most) };
                prop_assert!((target.rate_rad_s[axis] - reached).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn the_reference_goes_along_with_the_vehicle() {
        let mut state = AngleState::default();
        let angles = EulerAngles { roll_rad: 1.0, pitch_rad: 0.0, yaw_rad: -2.0 };
        let before = RateTarget { rate_rad_s: Vector3::new(4.0, 0.0, 0.0), ..RateTarget::default() };
        let turning = vehicle(angles, [4.0, 0.0, 0.0]);
        let target = update(&config(false), &mut state, &before, (&[4.0, f32::NAN, 0.0], &turning), STEP_S);
        assert_eq!(target.rate_rad_s, Vector3::new(4.0, 0.0, 0.0), "as fast as wanted already; no number is no rate");
        let [roll, pitch, yaw] = state.reference;
        let near = |found: f32, expected: f32| (found - expected).abs() < 1e-3;
        assert!(near(roll.angle_rad, 1.0) && near(pitch.angle_rad, 0.0) && near(yaw.angle_rad, -2.0), "{state:?}");
        assert_eq!(roll.rate_rad_s, 3.0, "no faster than a reference may");
    }
}
