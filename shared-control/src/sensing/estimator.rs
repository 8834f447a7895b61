//! Attitude and gyro bias from gyro and accelerometer: a complementary filter on the rotation group.
//!
//! Mahony, Hamel, Pflimlin, "Nonlinear complementary filters on the special orthogonal group", IEEE TAC 53(5), 2008,
//! equation 32 (explicit filter with bias): with the down direction measured (d = -f / |f|) and predicted
//! (d^ = R^T z), e = d x d^,
//!
//! ```text
//!   R' = R [gyro - b + k_P w e]x          b' = -k_I w e
//! ```
//! Departures: w falls to zero as |f| leaves g (a vehicle that accelerates says nothing about down), the bias is
//! bounded, and the first usable sample sets roll and pitch outright. In flight the accelerometer feels the thrust,
//! which points along the body's own z axis whatever the tilt, so it is followed only as fast as drift needs. At rest,
//! motors off and the gyro quiet, the gyro reads its bias and nothing else: the bias is its mean, and level is followed
//! quickly. Heading has no reference here and drifts with the bias about the vertical.

use nalgebra::{UnitQuaternion, Vector3};

use crate::elementary::{asin, atan2, larger, magnitude, sqrt};
use crate::frames::{EulerAngles, down_in_body, normalized, q_from_rotation_vector, q_world_from_euler};
use crate::record::state_words::StateWords;
use crate::sensing::gyro_bias::{GyroBias, GyroBiasConfig};
use crate::sensing::imu::{ImuStep, all_finite, seconds_between};
use crate::signals::AttitudeEstimate;

/// Gains and limits of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorConfig {
    /// Gravity, m/s^2.
    pub gravity_m_s2: f32,
    /// k_P in flight: how fast the accelerometer pulls the attitude, 1/s.
    pub flight_attitude_1_s: f32,
    /// k_I in flight: how fast the bias is learnt, 1/s^2.
    pub flight_bias_1_s2: f32,
    /// k_P at rest, 1/s.
    pub rest_attitude_1_s: f32,
    /// The gyro's bias.
    pub gyro_bias: GyroBiasConfig,
    /// Relative deviation of |f| from g at which the accelerometer is ignored.
    pub accel_gate: f32,
    /// The estimate is invalid when no sample came for this long, s.
    pub stale_after_s: f32,
}

impl EstimatorConfig {
    /// In flight critically damped with 20 s (k_P = 2 / T, k_I = 1 / T^2): a tilt of 30 degrees held for 2 s, all of it
    /// seen as level by the accelerometer, costs 5 degrees at worst; integrated gyro noise of 0.01 rad/s at 1 kHz stays
    /// below 1 mrad. At rest half a second.
    pub const NOMINAL: EstimatorConfig = EstimatorConfig {
        gravity_m_s2: 9.806_65,
        flight_attitude_1_s: 0.1,
        flight_bias_1_s2: 0.0025,
        rest_attitude_1_s: 2.0,
        gyro_bias: GyroBiasConfig::NOMINAL,
        accel_gate: 0.15,
        stale_after_s: 0.05,
    };
}

/// What the filter remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorState {
    q_world_from_body: UnitQuaternion<f32>,
    last_sample_us: Option<u64>,
}

impl Default for EstimatorState {
    fn default() -> Self {
        Self { q_world_from_body: UnitQuaternion::identity(), last_sample_us: None }
    }
}

impl EstimatorState {
    /// Forgets roll and pitch; the next usable sample sets them, as the very first does.
    pub fn level_anew(&mut self) {
        self.last_sample_us = None;
    }

    /// Goes on from another attitude.
    pub fn set_attitude(&mut self, q_world_from_body: UnitQuaternion<f32>) {
        self.q_world_from_body = q_world_from_body;
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { q_world_from_body, last_sample_us } = self;
        words.rotation(q_world_from_body);
        words.optional_time_us(*last_sample_us);
    }
}

/// One step of the filter with an IMU and that IMU's gyro bias. `time_us` is the step's time; it only decides whether
/// samples stay away.
pub fn update(
    config: &EstimatorConfig,
    state: &mut EstimatorState,
    gyro: &mut GyroBias,
    imu: &ImuStep,
    time_us: u64,
    in_flight: bool,
) -> AttitudeEstimate {
    if imu.is_usable() {
        let down = measured_down(config, &imu.specific_force_m_s2);
        match (state.last_sample_us, imu.after_gap, down) {
            (None, _, None) => {}
            (None, _, Some((down_body, _))) => {
                state.q_world_from_body = level_attitude(&down_body, state);
                state.last_sample_us = Some(time_us);
            }
            // only on the ground: in flight the accelerometer would call the thrust's direction down
            (Some(_), true, Some((down_body, _))) if !in_flight => {
                state.q_world_from_body = level_attitude(&down_body, state);
                gyro.moved();
                state.last_sample_us = Some(time_us);
            }
            (Some(_), _, down) => {
                if in_flight {
                    gyro.moved();
                } else {
                    gyro.average_at_rest(&config.gyro_bias, imu, down.map(|(down_body, _)| down_body));
                }
                predict_and_correct(config, state, gyro, imu, down, in_flight);
                state.last_sample_us = Some(time_us);
            }
        }
    }
    let fresh = match state.last_sample_us {
        // a clock that ran back makes nothing fresh
        Some(last) => time_us >= last && seconds_between(last, time_us) <= config.stale_after_s,
        None => false,
    };
    let rate_body_rad_s = imu.rate_body_rad_s - gyro.bias_rad_s();
    AttitudeEstimate {
        q_world_from_body: state.q_world_from_body,
        rate_body_rad_s: if all_finite(&rate_body_rad_s) { rate_body_rad_s } else { Vector3::zeros() },
        gyro_bias_rad_s: gyro.bias_rad_s(),
        valid: fresh,
    }
}

fn predict_and_correct(
    config: &EstimatorConfig,
    state: &mut EstimatorState,
    gyro: &mut GyroBias,
    imu: &ImuStep,
    down: Option<(Vector3<f32>, f32)>,
    in_flight: bool,
) {
    let dt_s = imu.duration_s;
    let mut rotation = imu.rotation_rad - gyro.bias_rad_s() * dt_s;
    if let Some((down_body, weight)) = down {
        let error = down_body.cross(&down_in_body(&state.q_world_from_body));
        let gain_1_s = if in_flight { config.flight_attitude_1_s } else { config.rest_attitude_1_s };
        rotation += error * (gain_1_s * weight * dt_s);
        if in_flight {
            gyro.correct(&config.gyro_bias, error * (-config.flight_bias_1_s2 * weight * dt_s));
        }
    }
    state.q_world_from_body = turned(&state.q_world_from_body, &rotation);
}

/// An attitude after a rotation, rad, about the body's axes.
pub fn turned(q_world_from_body: &UnitQuaternion<f32>, rotation_rad: &Vector3<f32>) -> UnitQuaternion<f32> {
    normalized((q_world_from_body * q_from_rotation_vector(rotation_rad)).into_inner())
}

/// Direction of down in the body frame as the accelerometer has it, and how much it may be believed (0..1); none
/// where the specific force is too far from gravity.
pub fn measured_down(config: &EstimatorConfig, specific_force: &Vector3<f32>) -> Option<(Vector3<f32>, f32)> {
    let norm = sqrt(specific_force.dot(specific_force));
    let deviation = magnitude(norm / config.gravity_m_s2 - 1.0);
    let weight = larger(0.0, 1.0 - deviation / config.accel_gate);
    (norm > 0.0 && weight > 0.0).then(|| (specific_force * (-1.0 / norm), weight))
}

/// Roll and pitch from the down direction, heading as it was.
fn level_attitude(down_body: &Vector3<f32>, state: &EstimatorState) -> UnitQuaternion<f32> {
    q_world_from_euler(EulerAngles {
        roll_rad: atan2(down_body.y, down_body.z),
        pitch_rad: asin(-down_body.x),
        yaw_rad: crate::frames::euler_from_q(&state.q_world_from_body).yaw_rad,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CONFIG: EstimatorConfig = EstimatorConfig::NOMINAL;

    fn imu(rate: Vector3<f32>, force: Vector3<f32>, duration_s: f32) -> ImuStep {
        ImuStep {
            samples: 1,
            duration_s,
            after_gap: duration_s == 0.0,
            rotation_rad: rate * duration_s,
            rate_body_rad_s: rate,
            specific_force_m_s2: force,
        }
    }

    /// A filter with its gyro.
    type Filter = (EstimatorState, GyroBias);

    /// One that has had a sample, at this attitude.
    fn started(q_world_from_body: UnitQuaternion<f32>) -> Filter {
        (EstimatorState { q_world_from_body, last_sample_us: Some(0) }, GyroBias::default())
    }

    /// At rest.
    fn update(config: &EstimatorConfig, filter: &mut Filter, imu: &ImuStep, time_us: u64) -> AttitudeEstimate {
        super::update(config, &mut filter.0, &mut filter.1, imu, time_us, false)
    }

    fn update_in_flight(filter: &mut Filter, imu: &ImuStep, time_us: u64) -> AttitudeEstimate {
        super::update(&CONFIG, &mut filter.0, &mut filter.1, imu, time_us, true)
    }

    fn force_at(q: &UnitQuaternion<f32>) -> Vector3<f32> {
        down_in_body(q) * -CONFIG.gravity_m_s2
    }

    fn angle_between_downs(a: &UnitQuaternion<f32>, b: &UnitQuaternion<f32>) -> f32 {
        asin(down_in_body(a).cross(&down_in_body(b)).norm())
    }

    proptest! {
        /// Any attitude, upside down included: the first sample already knows where down is.
        #[test]
        fn first_sample_sets_the_tilt(roll in -3.1f32..3.1, pitch in -1.55f32..1.55) {
            let truth = q_world_from_euler(EulerAngles { roll_rad: roll, pitch_rad: pitch, yaw_rad: 0.0 });
            let mut state = Filter::default();
            let estimate = update(&CONFIG, &mut state, &imu(Vector3::zeros(), force_at(&truth), 0.0), 0);
            prop_assert!(estimate.valid);
            prop_assert!((down_in_body(&estimate.q_world_from_body) - down_in_body(&truth)).norm() < 1e-5);
        }

        /// From any wrong tilt short of the exact opposite the accelerometer brings it back.
        #[test]
        fn tilt_converges_from_any_start(roll in -2.9f32..2.9, pitch in -1.4f32..1.4) {
            let mut state = started(UnitQuaternion::identity());
            let truth = q_world_from_euler(EulerAngles { roll_rad: roll, pitch_rad: pitch, yaw_rad: 0.3 });
            prop_assume!(down_in_body(&truth).z > -0.97);
            let mut estimate = None;
            for k in 1..16_000u64 {
                let at_rest = imu(Vector3::zeros(), force_at(&truth), 0.0025);
                estimate = Some(update(&CONFIG, &mut state, &at_rest, k * 2500));
            }
            let error = angle_between_downs(&estimate.unwrap().q_world_from_body, &truth);
            prop_assert!(error < 0.02, "{error}");
        }
    }

    #[test]
    fn follows_loops_through_every_attitude_without_the_accelerometer() {
        // pitching over backwards at 2 rad/s in free fall (no specific force): 10 full loops
        let mut state = started(UnitQuaternion::identity());
        let rate = Vector3::new(0.0, 2.0, 0.0);
        let steps = 12_566u64;
        for k in 1..=steps {
            update(&CONFIG, &mut state, &imu(rate, Vector3::zeros(), 0.0025), k * 2500);
        }
        let truth = q_from_rotation_vector(&Vector3::new(
            0.0,
            2.0 * 0.0025 * steps as f32 % (2.0 * core::f32::consts::PI),
            0.0,
        ));
        // f32 time steps round by 6e-8 each, 12566 of them
        assert!(angle_between_downs(&state.0.q_world_from_body, &truth) < 2e-3);
    }

    #[test]
    fn learns_the_gyro_bias_at_rest_and_not_while_carried_about() {
        let mut state = Filter::default();
        let bias = Vector3::new(0.03, -0.02, 0.01);
        let level = force_at(&UnitQuaternion::identity());
        update(&CONFIG, &mut state, &imu(bias, level, 0.0), 0);
        let mut estimate = update(&CONFIG, &mut state, &imu(bias, level, 0.0025), 2500);
        for k in 2..800u64 {
            estimate = update(&CONFIG, &mut state, &imu(bias, level, 0.0025), k * 2500);
        }
        assert!((estimate.gyro_bias_rad_s - bias).norm() < 1e-6, "{:?}", estimate.gyro_bias_rad_s);
        // jerked, then turned slowly for two seconds: the accelerometer separates that from rest
        let mut attitude_rad = 0.0f32;
        for k in 800..1600u64 {
            let rate = if k < 810 { 0.5 } else { 0.085 };
            attitude_rad += rate * 0.0025;
            let truth = q_from_rotation_vector(&Vector3::new(attitude_rad, 0.0, 0.0));
            let carried = imu(bias + Vector3::new(rate, 0.0, 0.0), force_at(&truth), 0.0025);
            estimate = update(&CONFIG, &mut state, &carried, k * 2500);
        }
        assert!((estimate.gyro_bias_rad_s - bias).norm() < 1e-6, "{:?}", estimate.gyro_bias_rad_s);
        assert!((estimate.rate_body_rad_s.x - 0.085).abs() < 1e-5);
    }

    #[test]
    fn learns_the_largest_bias_that_the_chip_may_have() {
        let mut state = Filter::default();
        let bias = Vector3::new(20f32.to_radians(), -20f32.to_radians(), 20f32.to_radians());
        let level = force_at(&UnitQuaternion::identity());
        let mut estimate = update(&CONFIG, &mut state, &imu(bias, level, 0.0), 0);
        for k in 1..4000u64 {
            estimate = update(&CONFIG, &mut state, &imu(bias, level, 0.0025), k * 2500);
        }
        // 4000 sums up to 3.5 rad, each rounded to 2.4e-7, over 10 s
        assert!((estimate.gyro_bias_rad_s - bias).norm() < 2e-4);
        assert!(angle_between_downs(&estimate.q_world_from_body, &UnitQuaternion::identity()) < 1e-3);
    }

    #[test]
    fn a_gap_in_flight_keeps_the_attitude() {
        let truth = q_world_from_euler(EulerAngles { roll_rad: 0.5, pitch_rad: 0.0, yaw_rad: 0.0 });
        let thrust = force_at(&UnitQuaternion::identity());
        for in_flight in [true, false] {
            let mut state = started(truth);
            let gap = ImuStep { after_gap: true, ..imu(Vector3::zeros(), thrust, 0.0) };
            let estimate = if in_flight {
                update_in_flight(&mut state, &gap, 600_000)
            } else {
                update(&CONFIG, &mut state, &gap, 600_000)
            };
            let kept = angle_between_downs(&estimate.q_world_from_body, &truth) < 1e-5;
            assert_eq!(kept, in_flight, "on the ground the accelerometer is right, in flight it is not");
        }
    }

    #[test]
    fn a_clock_that_runs_back_makes_nothing_fresh() {
        let mut state = Filter::default();
        let level = force_at(&UnitQuaternion::identity());
        update(&CONFIG, &mut state, &imu(Vector3::zeros(), level, 0.0), 1_000_000);
        let nothing = ImuStep { samples: 0, ..imu(Vector3::zeros(), Vector3::zeros(), 0.0) };
        assert!(!update(&CONFIG, &mut state, &nothing, 500_000).valid);
    }

    #[test]
    fn follows_the_bias_about_the_horizontal_axes_in_flight() {
        let mut state = started(UnitQuaternion::identity());
        let bias = Vector3::new(0.01, -0.01, 0.0);
        let level = force_at(&UnitQuaternion::identity());
        for k in 1..80_000u64 {
            update_in_flight(&mut state, &imu(bias, level, 0.0025), k * 2500);
        }
        // critically damped with 20 s: after 200 s (1 + 10) e^-10 is left, 5e-4 of the bias, and f32 rounding
        assert!((state.1.bias_rad_s() - bias).norm() < 1e-4, "{:?}", state.1);
    }

    #[test]
    fn in_flight_a_held_tilt_is_believed_for_a_while() {
        // 30 degrees held for 2 s in free flight: the accelerometer feels only the thrust, as if level
        let truth = q_world_from_euler(EulerAngles { roll_rad: 0.52, pitch_rad: 0.0, yaw_rad: 0.0 });
        let mut state = started(truth);
        let thrust = force_at(&UnitQuaternion::identity());
        for k in 1..800u64 {
            update_in_flight(&mut state, &imu(Vector3::zeros(), thrust, 0.0025), k * 2500);
        }
        // 30 degrees * (1 - exp(-k_P t)) = 5.4 degrees, a little more by the bias
        assert!(angle_between_downs(&state.0.q_world_from_body, &truth) < 5.6f32.to_radians());
    }

    #[test]
    fn is_sensible_before_the_first_sample_and_when_samples_stay_away() {
        let mut state = Filter::default();
        let nothing = ImuStep { samples: 0, ..imu(Vector3::zeros(), Vector3::zeros(), 0.0) };
        let estimate = update(&CONFIG, &mut state, &nothing, 0);
        assert!(!estimate.valid && estimate.q_world_from_body == UnitQuaternion::identity());
        let level = force_at(&UnitQuaternion::identity());
        assert!(update(&CONFIG, &mut state, &imu(Vector3::zeros(), level, 0.0), 10_000).valid);
        assert!(update(&CONFIG, &mut state, &nothing, 50_000).valid);
        assert!(!update(&CONFIG, &mut state, &nothing, 70_000).valid);
    }

    #[test]
    fn nan_leaves_no_trace() {
        let mut state = Filter::default();
        let level = force_at(&UnitQuaternion::identity());
        update(&CONFIG, &mut state, &imu(Vector3::zeros(), level, 0.0), 0);
        let before = state;
        for poison in [f32::NAN, f32::INFINITY] {
            let bad = imu(Vector3::new(poison, 0.0, 0.0), Vector3::new(0.0, poison, 0.0), 0.0025);
            let estimate = update(&CONFIG, &mut state, &bad, 2500);
            assert_eq!(state, before);
            assert!(estimate.rate_body_rad_s == Vector3::zeros());
        }
    }
}
