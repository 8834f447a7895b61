//! The attitude loop: shaped reference, attitude error as a rotation, square-root P to a rate target.
//!
//! The error is split as AC_AttitudeControl's `thrust_heading_rotation_angles` does: first the shortest rotation that
//! brings the thrust axis where it belongs (what keeps the vehicle in the air), then the rest about that axis
//! (heading).

use nalgebra::{UnitQuaternion, Vector3};

pub use crate::attitude::shaping::AngleState;
use crate::attitude::shaping::{Goal, ShapingConfig, follow};
use crate::attitude::square_root::square_root_controller;
use crate::elementary::{atan2, limit, sqrt, wrap_pi};
use crate::frames::{q_world_from_euler, rate_body_from_euler_rates};
use crate::record::state_words::StateWords;
use crate::signals::{AttitudeEstimate, Setpoint};

/// Largest heading error that the reference may be ahead, rad.
const HEADING_ERROR_MAX_RAD: f32 = 0.5;

/// Gains and limits; arrays are roll, pitch, yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleConfig {
    /// Shaping of the reference.
    pub shaping: [ShapingConfig; 3],
    /// Gain from angle error to rate near the target, 1/s.
    pub gain_1_s: [f32; 3],
    /// Deceleration that the square root counts on, rad/s^2.
    pub acceleration_max_rad_s2: [f32; 3],
    /// Largest rate target, rad/s.
    pub rate_max_rad_s: [f32; 3],
    /// Largest roll or pitch set-point, rad.
    pub tilt_max_rad: f32,
    /// Share of the shaped reference's acceleration that is demanded of the motors before any error shows; 0 for none.
    pub acceleration_feed_forward: f32,
    /// True on a rig whose heading can't move: no heading error, no yaw rate.
    pub yaw_locked: bool,
}

impl AngleConfig {
    /// A roll or pitch set-point within its limit; what is no number stays none.
    pub fn tilt_asked_rad(&self, angle_rad: f32) -> f32 {
        if angle_rad.is_finite() { limit(angle_rad, -self.tilt_max_rad, self.tilt_max_rad) } else { angle_rad }
    }

    /// What the reference of each axis moves towards.
    pub fn goals(&self, setpoint: &Setpoint) -> [Goal; 3] {
        let [roll, pitch] =
            [setpoint.roll_rad, setpoint.pitch_rad].map(|angle_rad| Goal::Angle(self.tilt_asked_rad(angle_rad)));
        [roll, pitch, if self.yaw_locked { Goal::Rest } else { Goal::Rate(setpoint.yaw_rate_rad_s) }]
    }
}

/// What the attitude loop demands of the rate loop, body axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RateTarget {
    /// Rate, rad/s.
    pub rate_rad_s: Vector3<f32>,
    /// Angular acceleration to add to what the rate error requests, rad/s^2.
    pub acceleration_rad_s2: Vector3<f32>,
}

impl RateTarget {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { rate_rad_s, acceleration_rad_s2 } = self;
        words.vector(rate_rad_s);
        words.vector(acceleration_rad_s2);
    }
}

/// Advances the reference by one step and gives what the rate loop is to do until the next.
pub fn update(
    config: &AngleConfig,
    state: &mut AngleState,
    setpoint: &Setpoint,
    estimate: &AttitudeEstimate,
    dt_s: f32,
) -> RateTarget {
    let acceleration_rad_s2 = shape(config, state, setpoint, dt_s);
    let target = q_world_from_euler(state.angles());
    let mut error_rad = attitude_error(&target, &estimate.q_world_from_body);
    if config.yaw_locked {
        error_rad.z = 0.0;
    } else {
        hold_back_heading(state, &mut error_rad.z);
    }
    // the reference's motion is in the target's body axes; the vehicle's are turned against them by the error
    let body_from_target = estimate.q_world_from_body.inverse() * target;
    let in_body = |euler: [f32; 3]| body_from_target * rate_body_from_euler_rates(state.angles(), euler);
    let rate_ahead = in_body(state.reference.map(|axis| axis.rate_rad_s));
    // but for what the axes' own turning adds, which is of second order in the rates
    let acceleration_ahead = in_body(acceleration_rad_s2) * config.acceleration_feed_forward;
    let moves = |axis: usize| axis != 2 || !config.yaw_locked;
    RateTarget {
        rate_rad_s: Vector3::from_fn(|axis, _| {
            let correction = square_root_controller(
                error_rad[axis],
                config.gain_1_s[axis],
                config.acceleration_max_rad_s2[axis],
                dt_s,
            );
            let ahead = if moves(axis) { rate_ahead[axis] } else { 0.0 };
            limit(correction + ahead, -config.rate_max_rad_s[axis], config.rate_max_rad_s[axis])
        }),
        acceleration_rad_s2: Vector3::from_fn(|axis, _| if moves(axis) { acceleration_ahead[axis] } else { 0.0 }),
    }
}

/// A heading that the vehicle cannot follow (yaw has the least authority and gives way first) waits for it: without
/// this the reference would run on, pass behind the vehicle and turn it the wrong way round. ArduPilot does the same.
fn hold_back_heading(state: &mut AngleState, error_rad: &mut f32) {
    let kept_rad = limit(*error_rad, -HEADING_ERROR_MAX_RAD, HEADING_ERROR_MAX_RAD);
    let heading = &mut state.reference[2].angle_rad;
    *heading = wrap_pi(*heading - (*error_rad - kept_rad));
    *error_rad = kept_rad;
}

/// Moves the reference on; gives its acceleration (Euler angles), rad/s^2.
pub fn shape(config: &AngleConfig, state: &mut AngleState, setpoint: &Setpoint, dt_s: f32) -> [f32; 3] {
    let [to_roll, to_pitch, to_heading] = config.goals(setpoint);
    let [of_roll, of_pitch, of_heading] = &config.shaping;
    let [roll, pitch, heading] = &mut state.reference;
    [
        follow(of_roll, roll, to_roll, dt_s),
        follow(of_pitch, pitch, to_pitch, dt_s),
        follow(of_heading, heading, to_heading, dt_s),
    ]
}

/// Rotation still to make, body frame, rad: x and y move the thrust axis, z is what is then left of the heading.
pub fn attitude_error(target: &UnitQuaternion<f32>, actual: &UnitQuaternion<f32>) -> Vector3<f32> {
    let body_from_target = actual.inverse() * target;
    let q = body_from_target.quaternion();
    // swing about an axis in the xy plane, then twist about z: q = swing * twist
    let cos_half_swing = sqrt(q.w * q.w + q.k * q.k);
    if cos_half_swing < 1e-6 {
        // thrust axes exactly opposite: any horizontal axis will do, so take roll
        return Vector3::new(core::f32::consts::PI, 0.0, 0.0);
    }
    let swing_x = (q.i * q.w - q.j * q.k) / cos_half_swing;
    let swing_y = (q.j * q.w + q.i * q.k) / cos_half_swing;
    let sin_half_swing = sqrt(swing_x * swing_x + swing_y * swing_y);
    let angle_per_sine =
        if sin_half_swing < 1e-4 { 2.0 } else { 2.0 * atan2(sin_half_swing, cos_half_swing) / sin_half_swing };
    let (w, k) = if q.w < 0.0 { (-q.w, -q.k) } else { (q.w, q.k) };
    Vector3::new(swing_x * angle_per_sine, swing_y * angle_per_sine, 2.0 * atan2(k, w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::sin_cos;
    use crate::frames::{EulerAngles, euler_from_q, q_from_rotation_vector};
    use nalgebra::Quaternion;
    use proptest::prelude::*;

    fn any_attitude() -> impl Strategy<Value = UnitQuaternion<f32>> {
        (-3f32..3.0, -3f32..3.0, -3f32..3.0).prop_map(|(x, y, z)| q_from_rotation_vector(&Vector3::new(x, y, z)))
    }

    proptest! {
        /// Swing then twist by the error leads from the actual attitude to the target, whichever sign the quaternions
        /// have.
        #[test]
        fn error_is_the_rotation_that_is_missing(target in any_attitude(), actual in any_attitude()) {
            let error = attitude_error(&target, &actual);
            let swing = q_from_rotation_vector(&Vector3::new(error.x, error.y, 0.0));
            let twist = q_from_rotation_vector(&Vector3::new(0.0, 0.0, error.z));
            let reached = actual * swing * twist;
            let same = reached.into_inner().dot(&target.into_inner()).abs();
            prop_assert!(same > 1.0 - 1e-5, "{same}");
            let other_sign = UnitQuaternion::new_unchecked(-target.into_inner());
            prop_assert!((attitude_error(&other_sign, &actual) - error).norm() < 1e-4);
        }

        /// Turning at the error's rate always arrives (all start and goal pairs).
        #[test]
        fn following_the_error_converges(target in any_attitude(), start in any_attitude()) {
            let mut actual = start;
            for _ in 0..3000 {
                let rate = attitude_error(&target, &actual) * 5.0;
                actual = crate::frames::normalized((actual * q_from_rotation_vector(&(rate * 0.0025))).into_inner());
            }
            prop_assert!(attitude_error(&target, &actual).norm() < 1e-3);
        }
    }

    const SHAPING: ShapingConfig = ShapingConfig { gain_1_s: 7.0, acceleration_max_rad_s2: 20.0, rate_max_rad_s: 3.0 };

    fn config(yaw_locked: bool) -> AngleConfig {
        AngleConfig {
            shaping: [SHAPING; 3],
            gain_1_s: [8.0, 6.0, 3.0],
            acceleration_max_rad_s2: [20.0; 3],
            rate_max_rad_s: [5.0, 5.0, 2.0],
            tilt_max_rad: 1.0,
            acceleration_feed_forward: 1.0,
            yaw_locked,
        }
    }

    fn at(angles: EulerAngles) -> AttitudeEstimate {
        AttitudeEstimate {
            q_world_from_body: q_world_from_euler(angles),
            rate_body_rad_s: Vector3::zeros(),
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        }
    }

    fn euler(roll_rad: f32, pitch_rad: f32, yaw_rad: f32) -> EulerAngles {
        EulerAngles { roll_rad, pitch_rad, yaw_rad }
    }

    /// A vehicle that turns exactly as commanded arrives, from any heading, and keeps to the reference on the way: the
    /// feed-forward has the right size, sign and axes.
    #[test]
    fn a_vehicle_that_obeys_keeps_to_the_moving_reference() {
        for heading in [0.0, 1.5, -3.0] {
            let mut q = q_world_from_euler(euler(0.0, 0.0, heading));
            let mut estimate = AttitudeEstimate { q_world_from_body: q, ..at(EulerAngles::default()) };
            let mut state = AngleState::at(&euler_from_q(&estimate.q_world_from_body));
            let setpoint = Setpoint { roll_rad: 0.5, pitch_rad: -0.4, yaw_rate_rad_s: 0.8, ..Setpoint::default() };
            for _ in 0..1200 {
                let rate = update(&config(false), &mut state, &setpoint, &estimate, 0.0025).rate_rad_s;
                q = crate::frames::normalized((q * q_from_rotation_vector(&(rate * 0.0025))).into_inner());
                estimate.q_world_from_body = q;
                let error = attitude_error(&q_world_from_euler(state.angles()), &q);
                // one step of the fastest rate requested
                assert!(error.norm() < 0.0025 * 6.0, "{error}");
            }
            let reached = euler_from_q(&q);
            assert!((reached.roll_rad - 0.5).abs() < 0.01 && (reached.pitch_rad + 0.4).abs() < 0.01, "{reached:?}");
            assert!((wrap_pi(reached.yaw_rad - heading) - 0.8 * 3.0).abs() < 0.05, "heading turned by the rate");
        }
    }

    #[test]
    fn each_axis_has_its_gain_its_limit_and_its_sign() {
        let mut state = AngleState::default();
        let level = Setpoint::default();
        let rate = update(&config(false), &mut state, &level, &at(euler(-0.01, 0.02, -0.03)), 0.0025).rate_rad_s;
        // small errors: gain times error, per axis
        assert!((rate - Vector3::new(0.08, -0.12, 0.09)).norm() < 2e-3, "{rate}");
        let far = update(&config(false), &mut state, &level, &at(euler(3.0, 0.0, 0.0)), 0.0025).rate_rad_s;
        assert!(far.norm() <= 5.0 + 2.0 + 1e-3 && far.x < -4.0);
        let steep = Setpoint { roll_rad: 2.0, ..level };
        for _ in 0..2000 {
            update(&config(false), &mut state, &steep, &at(EulerAngles::default()), 0.0025);
        }
        assert!((state.angles().roll_rad - 1.0).abs() < 1e-3, "no further than tilt_max_rad");
    }

    /// Half of the reference's acceleration, in the axes of the vehicle: a nose that rises about the horizontal turns a
    /// vehicle that lies on its right side to the left.
    #[test]
    fn the_acceleration_ahead_is_the_references_in_body_axes() {
        let config = AngleConfig { acceleration_feed_forward: 0.5, ..config(false) };
        let (sin, cos) = sin_cos(0.5);
        for (start, setpoint, expected) in [
            (euler(0.0, 0.0, 0.0), euler(0.5, 0.0, 0.0), Vector3::new(10.0, 0.0, 0.0)),
            (euler(0.0, 0.0, 1.5), euler(0.0, -0.5, 1.5), Vector3::new(0.0, -10.0, 0.0)),
            (euler(0.5, 0.0, 0.0), euler(0.5, 0.5, 0.0), Vector3::new(0.0, 10.0 * cos, -10.0 * sin)),
        ] {
            let mut state = AngleState::at(&start);
            let setpoint =
                Setpoint { roll_rad: setpoint.roll_rad, pitch_rad: setpoint.pitch_rad, ..Setpoint::default() };
            let ahead = update(&config, &mut state, &setpoint, &at(start), 0.0025).acceleration_rad_s2;
            // the reference has moved by one step, 6e-5 rad
            assert!((ahead - expected).norm() < 2e-3, "{ahead} {expected}");
        }
    }

    #[test]
    fn a_blocked_heading_is_waited_for_and_a_locked_one_is_left_alone() {
        let mut state = AngleState::default();
        let turning = Setpoint { yaw_rate_rad_s: 1.0, ..Setpoint::default() };
        for _ in 0..4000 {
            let rate = update(&config(false), &mut state, &turning, &at(EulerAngles::default()), 0.0025).rate_rad_s;
            assert!(rate.z >= 0.0, "never the wrong way round");
            assert!(state.angles().yaw_rad <= HEADING_ERROR_MAX_RAD + 1e-3);
        }
        let mut locked = AngleState::default();
        let rate = update(&config(true), &mut locked, &turning, &at(euler(0.0, 0.0, 0.7)), 0.0025);
        assert_eq!((rate.rate_rad_s.z, rate.acceleration_rad_s2.z, locked.angles().yaw_rad), (0.0, 0.0, 0.0));
    }

    /// A vehicle that keeps up within the limit is not waited for; beyond, the reference is left the limit ahead.
    #[test]
    fn the_heading_waits_only_for_what_is_too_far_off() {
        for (behind_rad, waits_rad) in [(0.3, 0.0), (-0.3, 0.0), (0.8, 0.3), (-0.8, -0.3)] {
            let mut state = AngleState::at(&euler(0.0, 0.0, 1.0));
            let vehicle = at(euler(0.0, 0.0, 1.0 - behind_rad));
            update(&config(false), &mut state, &Setpoint::default(), &vehicle, 0.0025);
            let heading_rad = state.angles().yaw_rad;
            assert!((heading_rad - (1.0 - waits_rad)).abs() < 1e-5, "{behind_rad}: {heading_rad}");
        }
    }

    /// A rig whose heading can't move flies roll and pitch like any other vehicle, and none of the heading's share.
    #[test]
    fn a_locked_heading_leaves_roll_and_pitch_as_they_are() {
        let setpoint = Setpoint { roll_rad: 0.5, pitch_rad: 0.3, ..Setpoint::default() };
        let vehicle = at(euler(0.4, 0.0, 0.0));
        let [mut free, mut locked] = [AngleState::at(&euler(0.4, 0.0, 0.0)); 2];
        for _ in 0..20 {
            let free = update(&config(false), &mut free, &setpoint, &vehicle, 0.0025);
            let locked = update(&config(true), &mut locked, &setpoint, &vehicle, 0.0025);
            assert_eq!(free.rate_rad_s.xy(), locked.rate_rad_s.xy());
            assert_eq!(free.acceleration_rad_s2.xy(), locked.acceleration_rad_s2.xy());
            assert!(free.acceleration_rad_s2.z < 0.0, "right side down, a rising nose turns the vehicle to the left");
            assert_eq!((locked.rate_rad_s.z, locked.acceleration_rad_s2.z), (0.0, 0.0));
        }
    }

    #[test]
    fn opposite_thrust_axes_give_a_finite_way_back() {
        for exactly in [Quaternion::new(0.0, 1.0, 0.0, 0.0), Quaternion::new(0.0, 0.6, -0.8, 0.0)] {
            let error = attitude_error(&UnitQuaternion::identity(), &UnitQuaternion::new_unchecked(exactly));
            assert_eq!((error.xy().norm(), error.z), (core::f32::consts::PI, 0.0));
        }
        let upside_down = q_from_rotation_vector(&Vector3::new(0.0, core::f32::consts::PI, 0.0));
        let error = attitude_error(&UnitQuaternion::identity(), &upside_down);
        assert!((error.xy().norm() - core::f32::consts::PI).abs() < 1e-3);
    }
}
