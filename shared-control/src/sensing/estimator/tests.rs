//! The attitude against the one that is known: at rest, in flight, through gaps and on nonsense.

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
        steady_force_m_s2: force,
        vibration_m_s2: Vector3::zeros(),
    }
}

/// A filter with its gyro.
type Filter = (EstimatorState, GyroBias);

/// One that has had a sample, at this attitude.
fn started(q_world_from_body: UnitQuaternion<f32>) -> Filter {
    let state = EstimatorState { q_world_from_body, last_sample_us: Some(0), ..EstimatorState::default() };
    (state, GyroBias::default())
}

/// At rest.
fn update(config: &EstimatorConfig, filter: &mut Filter, imu: &ImuStep, time_us: u64) -> AttitudeEstimate {
    super::update(config, &mut filter.0, &mut filter.1, imu, time_us, None)
}

fn update_in_flight(filter: &mut Filter, imu: &ImuStep, time_us: u64) -> AttitudeEstimate {
    super::update(&CONFIG, &mut filter.0, &mut filter.1, imu, time_us, Some(Support::Air))
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
    let truth =
        q_from_rotation_vector(&Vector3::new(0.0, 2.0 * 0.0025 * steps as f32 % (2.0 * core::f32::consts::PI), 0.0));
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
    // jerked, then turned slowly for two seconds: the accelerometer tells that from rest
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

/// Believed wholly at 1 g, less in proportion to what is missing or too much, and not at all beyond the gate.
#[test]
fn the_accelerometer_is_believed_as_far_as_it_feels_gravity() {
    let direction = Vector3::new(0.6, 0.0, 0.8);
    let felt = |g: f32| measured_down(&CONFIG, &(direction * (-g * CONFIG.gravity_m_s2)));
    for (g, weight) in [(1.0, 1.0), (1.075, 0.5), (0.925, 0.5), (1.12, 0.2), (0.88, 0.2)] {
        let (down, found) = felt(g).unwrap();
        assert!((found - weight).abs() < 1e-5, "{g}: {found}");
        assert!((down - direction).norm() < 1e-6, "{down}");
    }
    for g in [0.0, 0.84, 1.16, -0.5, 100.0, f32::NAN, f32::INFINITY] {
        assert_eq!(felt(g), None, "{g}");
    }
    // where everything is believed, nothing still has no direction
    let all = EstimatorConfig { accel_gate: 2.0, ..CONFIG };
    assert_eq!(measured_down(&all, &Vector3::zeros()), None);
}

/// A small tilt that the accelerometer denies at rest goes with 1 - exp(-k_P w t), as fast as its weight says.
#[test]
fn the_accelerometer_pulls_with_its_gain_and_weight() {
    let tilt_rad = 0.02;
    let truth = q_from_rotation_vector(&Vector3::new(tilt_rad, 0.0, 0.0));
    for (g, time_s, left) in [(1.0, 0.25, (-0.5f32).exp()), (1.075, 0.25, (-0.25f32).exp())] {
        let mut state = started(truth);
        let level = force_at(&UnitQuaternion::identity()) * g;
        for k in 1..=(time_s / 0.0025) as u64 {
            let still = imu(Vector3::zeros(), level, 0.0025);
            update(&CONFIG, &mut state, &still, k * 2500);
        }
        let found = angle_between_downs(&state.0.q_world_from_body, &UnitQuaternion::identity()) / tilt_rad;
        assert!((found - left).abs() < 0.01, "{g}: {found} for {left}");
    }
}

/// The rate is the gyro's less the bias, and the attitude turns by the same: a gyro that reads its bias stands still.
#[test]
fn the_bias_is_taken_off_rate_and_rotation() {
    let bias = Vector3::new(0.2, -0.1, 0.05);
    let mut state = started(UnitQuaternion::identity());
    state.1.correct(&CONFIG.gyro_bias, bias);
    for k in 1..=400u64 {
        // in free fall, where the accelerometer says nothing
        let estimate = update_in_flight(&mut state, &imu(bias, Vector3::zeros(), 0.0025), k * 2500);
        assert_eq!(estimate.rate_body_rad_s, Vector3::zeros());
        assert_eq!(estimate.gyro_bias_rad_s, bias);
    }
    assert!(state.0.q_world_from_body.quaternion().imag().norm() < 5e-6);
}

/// Made to forget, it takes level from the next sample, in flight too, and is not valid before.
#[test]
fn level_anew_is_level_from_the_next_sample() {
    let mut state = started(UnitQuaternion::identity());
    state.0.level_anew();
    let nothing = ImuStep { samples: 0, ..imu(Vector3::zeros(), Vector3::zeros(), 0.0) };
    assert!(!update_in_flight(&mut state, &nothing, 1000).valid);
    let truth = q_world_from_euler(EulerAngles { roll_rad: 0.4, pitch_rad: 0.1, yaw_rad: 0.0 });
    let estimate = update_in_flight(&mut state, &imu(Vector3::zeros(), force_at(&truth), 0.0025), 2500);
    assert!(estimate.valid && angle_between_downs(&estimate.q_world_from_body, &truth) < 1e-5);
}

/// Up to the limit an estimate is fresh, a microsecond later it is not.
#[test]
fn freshness_ends_with_its_time() {
    let mut state = started(UnitQuaternion::identity());
    let nothing = ImuStep { samples: 0, ..imu(Vector3::zeros(), Vector3::zeros(), 0.0) };
    assert!(update(&CONFIG, &mut state, &nothing, 50_000).valid);
    assert!(!update(&CONFIG, &mut state, &nothing, 50_001).valid);
    assert!(update(&CONFIG, &mut state, &nothing, 0).valid, "the sample's own time");
}

/// Rest begins anew after a gap on the ground, and in flight; the heading is kept when level is set.
#[test]
fn a_gap_on_the_ground_sets_level_keeps_the_heading_and_ends_the_rest() {
    let heading = q_world_from_euler(EulerAngles { yaw_rad: 0.7, ..EulerAngles::default() });
    let mut state = started(heading);
    let level = force_at(&UnitQuaternion::identity());
    for k in 1..=400u64 {
        update(&CONFIG, &mut state, &imu(Vector3::zeros(), level, 0.0025), k * 2500);
    }
    assert!(state.1.rest_s() > 0.9);
    let tilted = EulerAngles { roll_rad: 0.3, pitch_rad: -0.2, yaw_rad: 0.7 };
    let force = force_at(&q_world_from_euler(tilted));
    let estimate = update(&CONFIG, &mut state, &imu(Vector3::zeros(), force, 0.0), 2_000_000);
    let found = crate::frames::euler_from_q(&estimate.q_world_from_body);
    for (found, expected) in [(found.roll_rad, 0.3), (found.pitch_rad, -0.2), (found.yaw_rad, 0.7)] {
        assert!((found - expected).abs() < 1e-5, "{estimate:?}");
    }
    assert_eq!(state.1.rest_s(), 0.0);
    assert!(estimate.valid);
}
