//! The pipeline without a plant: who flies when, and that nothing hidden changes a result.

extern crate std;

mod gravity;
mod planning;
mod plans;

use super::*;
use crate::config::{Tuning, mpc_settings};
use crate::lift_curve::LiftCurve;
use crate::record::state_words::{STATE_WORDS, StateWords};
use crate::sensing::imu_health::ImuFault;
use crate::signals::Setpoint;
use crate::signals::{ArmingRequest, MotorTest, PlanReport, RawImuSample};
use crate::supervisor::throttle::{FALL_1_S, HOLD_US};
use crate::supervisor::{DisarmedBecause, IDLE_THROTTLE_MAX, Refusal};
use crate::vehicle::{Actuation, VehicleParameters};

const VEHICLE: VehicleParameters = VehicleParameters {
    gravity_m_s2: 9.80665,
    arm_m: 0.226,
    inertia_kg_m2: [0.0115, 0.0366, 0.02],
    ring_inertia_kg_m2: 0.0,
    torque_per_lift_m: 0.038,
    lift_curve: LiftCurve { lift_min_n: 0.0, lift_max_n: 2.0, command_at: straight_commands() },
    actuation: Actuation { delay_s: 0.0, lag_s: 0.0 },
    gravity_moment: crate::gravity_moment::GravityMoment::NONE,
    yaw_locked: true,
};

const fn straight_commands() -> [f32; 33] {
    let mut commands = [0.0; 33];
    let mut k = 0;
    while k < 33 {
        commands[k] = k as f32 / 32.0;
        k += 1;
    }
    commands
}

fn config(controller: Controller) -> Config {
    Config::new(&VEHICLE, &Tuning::for_motor_lag(0.0), 400.0, 1200.0, controller).unwrap()
}

/// Steps at rest before the first one that a test counts.
const REST_STEPS: u64 = 500;

/// Level and at rest, one sample a step.
fn input(step: u64, throttle: f32, arming: ArmingRequest, plan: Option<Plan>) -> StepInput {
    input_at((REST_STEPS + step) * 2500, throttle, arming, plan)
}

fn input_at(time_us: u64, throttle: f32, arming: ArmingRequest, plan: Option<Plan>) -> StepInput {
    let mut input = StepInput { time_us, arming, plan, ..Default::default() };
    let _ = input.imu.push(RawImuSample { time_us, gyro_counts: [0; 3], accel_counts: [0, 0, -4096] });
    input.setpoint = Setpoint { throttle, ..Default::default() };
    input
}

/// A core that has rested, and been armed for a step.
fn armed(controller: Controller) -> (Config, State) {
    let config = config(controller);
    let mut state = State::default();
    for k in 0..REST_STEPS {
        FlightCore::fast(&config, &mut state, &input_at(k * 2500, 0.0, ArmingRequest::None, None));
    }
    let first = input(0, 0.0, ArmingRequest::Arm, None);
    let output = FlightCore::fast(&config, &mut state, &first);
    FlightCore::follow(&config, &mut state, &output);
    assert_eq!(output.arming, Arming::Armed);
    (config, state)
}

#[test]
fn disarmed_means_the_shortest_pulse_whatever_is_asked() {
    let config = config(Controller::Cascade);
    let mut state = State::default();
    let output = FlightCore::fast(&config, &mut state, &input(0, 0.9, ArmingRequest::None, None));
    assert_eq!(output.source, TorqueSource::Disarmed);
    assert_eq!(output.mix.commands.0, [0.0; 4]);
    assert_eq!(output.compare_counts, [24_000; 4]);
}

#[test]
fn level_and_at_rest_all_motors_get_the_throttle() {
    let (config, mut state) = armed(Controller::Cascade);
    let output = FlightCore::fast(&config, &mut state, &input(1, 0.5, ArmingRequest::None, None));
    assert_eq!(output.mix.commands.0, [0.5; 4]);
    assert_eq!(output.compare_counts, [36_000; 4]);
}

#[test]
fn the_plan_request_looks_one_step_ahead() {
    let (config, mut state) = armed(Controller::Mpc);
    let plan = Plan { step: state.step, torque_nm: [0.1, -0.05, 0.0], status: PlanStatus::Solved, ..Plan::default() };
    let step = input(1, 0.5, ArmingRequest::None, Some(plan));
    let output = FlightCore::fast(&config, &mut state, &step);
    let request = FlightCore::follow(&config, &mut state, &output).unwrap();
    assert_eq!(request.step, state.step);
    let acceleration = 0.1 / 0.0115;
    assert!((request.rate_rad_s[0] - 0.0025 * acceleration).abs() < 1e-6);
    assert!((request.angle_rad[0] - 0.5 * 0.0025 * 0.0025 * acceleration).abs() < 1e-7);
    assert!((request.torque_prev_nm[1] + 0.05).abs() < 1e-6);
}

#[test]
fn step_is_its_three_calls_and_a_replay_repeats_it_to_the_bit() {
    let (config, start) = armed(Controller::Mpc);
    let mpc = Mpc::<3>::prepare(&mpc_settings(&VEHICLE, &Tuning::for_motor_lag(0.0), 400.0)).unwrap();
    let fly = || {
        let (mut state, mut plan_state, mut plan) = (start, MpcState::<3>::new(), None);
        let mut outputs = std::vec::Vec::new();
        for k in 1..400u64 {
            let mut step = input(k, 0.5, ArmingRequest::None, plan);
            step.setpoint.roll_rad = if k > 100 { 0.5 } else { 0.0 };
            let (output, next) = FlightCore::step(&config, &mpc, &mut state, &mut plan_state, &step);
            outputs.push(output);
            plan = next;
        }
        (state, outputs)
    };
    let (state_a, outputs_a) = fly();
    let (state_b, outputs_b) = fly();
    assert!(state_a == state_b && outputs_a == outputs_b);
    assert!(outputs_a.iter().skip(1).all(|output| output.source == TorqueSource::Mpc));
    assert!(outputs_a[150].wrench.torque_body_nm[0] > 0.1);
}

#[test]
fn nothing_that_is_no_number_gets_through() {
    for controller in [Controller::Cascade, Controller::Mpc] {
        let (config, mut state) = armed(controller);
        for k in 1..50 {
            let plan =
                Plan { step: state.step, torque_nm: [f32::NAN; 3], status: PlanStatus::Solved, ..Plan::default() };
            let mut step = input(k, f32::NAN, ArmingRequest::None, Some(plan));
            step.setpoint.roll_rad = f32::NAN;
            step.setpoint.yaw_rate_rad_s = f32::INFINITY;
            let output = FlightCore::fast(&config, &mut state, &step);
            let request = FlightCore::follow(&config, &mut state, &output);
            assert!(output.mix.commands.0.iter().all(|c| (0.0..=1.0).contains(c)));
            assert!(output.wrench.torque_body_nm.iter().all(|t| t.is_finite()));
            assert!(output.mix.unmet_torque_nm.iter().all(|t| t.is_finite()));
            let finite = |values: [f32; 3]| values.iter().all(|v| v.is_finite());
            if let Some(request) = request {
                assert!(finite(request.angle_rad) && finite(request.rate_rad_s) && finite(request.motor_nm));
                assert!(finite(request.torque_prev_nm) && finite(request.disturbance_nm));
                assert!(
                    request.reference.reference.iter().all(|r| r.angle_rad.is_finite() && r.rate_rad_s.is_finite())
                );
                assert!(request.setpoint.is_finite());
            }
        }
    }
}

#[test]
fn arming_waits_for_the_gyro_to_be_calibrated_at_rest() {
    let config = config(Controller::Cascade);
    let mut state = State::default();
    let mut armed_at = None;
    for k in 0..800u64 {
        let output = FlightCore::fast(&config, &mut state, &input_at(k * 2500, 0.0, ArmingRequest::Arm, None));
        if output.arming == Arming::Armed {
            armed_at = Some(k);
            break;
        }
        let refused = Arming::Disarmed(DisarmedBecause::Refused(Refusal::GyroNotCalibrated));
        assert_eq!(output.arming, refused, "step {k}");
    }
    // 1 s is 400 steps after the first, which only sets the tilt; the sum of 400 roundings may cost one more
    assert!((400..=402).contains(&armed_at.unwrap()), "{armed_at:?}");
}

#[test]
fn a_setpoint_that_is_no_number_is_counted_and_the_last_good_one_flown() {
    let (config, mut state) = armed(Controller::Cascade);
    let mut last_lift = 0.0;
    for k in 1..100 {
        let throttle = if k < 50 { 0.5 } else { f32::NAN };
        let output = FlightCore::fast(&config, &mut state, &input(k, throttle, ArmingRequest::None, None));
        FlightCore::follow(&config, &mut state, &output);
        assert_eq!(output.setpoints_rejected, (k as u32).saturating_sub(49));
        assert!(k == 1 || output.wrench.lift_per_motor_n == last_lift);
        last_lift = output.wrench.lift_per_motor_n;
    }
    // after three seconds of it, as with a lost link
    for k in 100..1300 {
        let output = FlightCore::fast(&config, &mut state, &input(k, f32::NAN, ArmingRequest::None, None));
        assert_eq!(output.arming == Arming::Armed, k < 49 + 1200, "step {k}");
    }
}

/// On a rig: level, the throttle kept for two seconds, then down to idle, and disarmed a second after that.
#[test]
fn a_lost_link_brings_the_vehicle_down_before_it_is_disarmed() {
    let (config, mut state) = armed(Controller::Cascade);
    let mut step = |k: u64, silent: bool| {
        let mut step = input(k, 0.5, ArmingRequest::None, None);
        (step.setpoint.roll_rad, step.link_age_us) = (0.1, Some(if silent { 3_000_000 } else { 0 }));
        let output = FlightCore::fast(&config, &mut state, &step);
        FlightCore::follow(&config, &mut state, &output);
        (output, state.setpoint.flown)
    };
    let lift_at = |throttle: f32| config.mixer.lift_curve.lift(throttle);
    (1..400).for_each(|k| assert_eq!(step(k, false).0.arming, Arming::Armed));
    let (hold, fall) = (HOLD_US / 2500, (0.5 / FALL_1_S * 400.0) as u64);
    for k in 0..hold + fall {
        let (output, flown) = step(400 + k, true);
        assert!(matches!(output.arming, Arming::LinkLost { .. }), "step {k}: {:?}", output.arming);
        let expected = 0.5 - FALL_1_S / 400.0 * k.saturating_sub(hold) as f32;
        assert!((flown.throttle - expected).abs() < 2e-3, "step {k}: {flown:?}");
        assert_eq!(flown.roll_rad, 0.0);
        assert!((output.wrench.lift_per_motor_n - lift_at(flown.throttle)).abs() < 1e-6);
    }
    // idle is reached a little before the throttle's very end, by which it counts as idle
    let down = (0..500).find(|k| !step(400 + hold + fall + k, true).0.arming.motors_turn());
    assert!((350..=402).contains(&down.unwrap()), "{down:?}");
    assert_eq!(step(2900, false).0.arming, Arming::Disarmed(DisarmedBecause::LinkLost), "and stays so");
}

#[test]
fn a_link_that_comes_back_gives_control_back_without_a_jump() {
    let (config, mut state) = armed(Controller::Cascade);
    let mut before = None;
    for k in 1..3000u64 {
        let mut step = input(k, 0.5, ArmingRequest::None, None);
        // away from 1 s to 5 s: three quarters through the fall of the throttle
        step.link_age_us = Some(if (400..2000).contains(&k) { 3_000_000 } else { 0 });
        let output = FlightCore::fast(&config, &mut state, &step);
        FlightCore::follow(&config, &mut state, &output);
        let commands = output.mix.commands.0;
        if let Some(before) = before.replace(commands).filter(|_| k > 2) {
            let smooth = (0..4).all(|motor: usize| (commands[motor] - before[motor]).abs() < 2e-3);
            assert!(smooth, "step {k}: {before:?} {commands:?}");
        }
        assert_eq!(matches!(output.arming, Arming::LinkLost { .. }), (400..2000).contains(&k), "step {k}");
    }
    assert_eq!(state.setpoint.flown.throttle, 0.5);
}

/// Rates are the rate loop's, whoever flies the angles: with the MPC no plan is asked for, and none is missed. Back in
/// stabilise the reference begins where the vehicle is.
#[test]
fn in_acro_the_rate_loop_flies_with_either_controller() {
    let fly = |controller| {
        let (config, mut state) = armed(controller);
        let mut outputs = std::vec::Vec::new();
        for k in 1..=60u64 {
            let mut step = input(k, 0.5, ArmingRequest::None, None);
            step.setpoint.roll_rad = 0.4;
            step.setpoint.acro_rad_s = (k <= 40).then_some([0.0, 0.5, 1.0]);
            let output = FlightCore::fast(&config, &mut state, &step);
            let request = FlightCore::follow(&config, &mut state, &output);
            assert_eq!(request.is_some(), controller == Controller::Mpc && k > 40, "step {k}");
            if k == 40 {
                // 0.5 rad/s, and a heading that is locked; a vehicle that stays where it is takes its reference along
                assert_eq!(state.rate_target.rate_rad_s.as_slice(), [0.0, 0.5, 0.0]);
                assert!(state.shaped_reference_rad().iter().all(|angle| angle.abs() < 1e-3));
            }
            outputs.push(output);
        }
        outputs
    };
    let (cascade, mpc) = (fly(Controller::Cascade), fly(Controller::Mpc));
    for (cascade, mpc) in cascade.iter().zip(&mpc).take(40) {
        assert_eq!((mpc.source, mpc.mix.commands), (TorqueSource::Cascade, cascade.mix.commands));
    }
    let [.., last] = &mpc[..] else { panic!("no step") };
    // no plan is given here: the one that arming asked for and the 19 since the end of acro are missed
    assert_eq!((last.source, last.planning.deadline_misses), (TorqueSource::CascadeNoPlan, 1 + 19));
}

#[test]
fn a_motor_test_turns_its_motor_and_no_other() {
    let config = config(Controller::Mpc);
    for motor in 1..=4u8 {
        let mut state = State::default();
        let test = MotorTest { motor, throttle_percent: 10, duration_ms: 100 };
        for k in 0..60 {
            let request = if k == 1 { ArmingRequest::MotorTest(test) } else { ArmingRequest::None };
            let output = FlightCore::fast(&config, &mut state, &input_at(k * 2500, 0.0, request, None));
            FlightCore::follow(&config, &mut state, &output);
            let turns = (1..41).contains(&k);
            let expected: [u16; 4] =
                core::array::from_fn(|i| if turns && i + 1 == usize::from(motor) { 26_400 } else { 24_000 });
            assert_eq!(output.compare_counts, expected, "motor {motor}, step {k}");
        }
    }
}

/// On the ground within five steps; in the air the model stands in for 40 ms.
#[test]
fn an_imu_that_falls_silent_disarms() {
    for (throttle, last_step) in [(0.0, 4), (0.5, 2 + COAST_MAX_US / 2500)] {
        let (config, mut state) = armed(Controller::Cascade);
        for k in 1..40 {
            let mut step = input(k, throttle, ArmingRequest::None, None);
            if k > 1 || throttle == 0.0 {
                step.imu.clear();
            }
            let output = FlightCore::fast(&config, &mut state, &step);
            FlightCore::follow(&config, &mut state, &output);
            let disarmed = output.arming == Arming::Disarmed(DisarmedBecause::ImuFailed(ImuFault::Stale));
            assert_eq!(disarmed, k >= last_step, "throttle {throttle}, step {k}: {:?}", output.arming);
            assert_eq!(output.compare_counts == [24_000; 4], k >= last_step || throttle == 0.0, "step {k}");
        }
    }
}

/// A vehicle that its motors turn, and no sample for 40 ms: the model says where it went, to what a time step leaves.
#[test]
fn in_a_gap_the_model_turns_as_the_vehicle_does() {
    let (config, mut state) = armed(Controller::Cascade);
    let inertia_kg_m2 = config.inertia_kg_m2[0];
    let (mut roll_rad, mut rate_rad_s, mut torque_nm) = (0f32, 0f32, 0f32);
    let count = |value: f32| if value < 0.0 { value - 0.5 } else { value + 0.5 } as i16;
    for k in 1..120u64 {
        let mut step = input(k, 0.5, ArmingRequest::None, None);
        step.setpoint.roll_rad = 0.5;
        // an ideal rigid body between two steps
        let acceleration_rad_s2 = torque_nm / inertia_kg_m2;
        roll_rad += 0.0025 * (rate_rad_s + 0.5 * 0.0025 * acceleration_rad_s2);
        rate_rad_s += 0.0025 * acceleration_rad_s2;
        let (sin, cos) = crate::elementary::sin_cos(roll_rad);
        // sensor axes: body x is the sensor's y, body y its -x
        step.imu[0].gyro_counts = [0, count(rate_rad_s / config.sensing.imu.gyro_rad_s_per_count), 0];
        step.imu[0].accel_counts = [count(4096.0 * sin), 0, count(-4096.0 * cos)];
        let gap = (60..=75).contains(&k);
        if gap {
            step.imu.clear();
        }
        let output = FlightCore::fast(&config, &mut state, &step);
        FlightCore::follow(&config, &mut state, &output);
        assert_eq!(output.arming, Arming::Armed, "step {k}");
        torque_nm = output.wrench.torque_body_nm[0] - output.mix.unmet_torque_nm[0];
        if gap {
            let seen = euler_from_q(&output.estimate.q_world_from_body).roll_rad;
            // what is there before the gap already: the gyro's low-pass is a step late
            let rate_error_rad_s = output.estimate.rate_body_rad_s.x - rate_rad_s;
            assert!(rate_error_rad_s.abs() < 0.3, "step {k}: {rate_rad_s}");
            assert!((seen - roll_rad).abs() < 0.02, "step {k}: {seen} {roll_rad}");
        }
    }
    assert!(roll_rad > 0.3, "it was on its way: {roll_rad}");
}

/// The MPC holds a torque against a disturbance; a plan that comes late must not let the vehicle jump.
#[test]
fn the_cascade_begins_where_the_mpc_ended() {
    let (config, mut state) = armed(Controller::Mpc);
    let held_nm = 0.05;
    let mut step_with = |k: u64, plan: Option<Plan>| {
        let step = input(k, 0.5, ArmingRequest::None, plan);
        let output = FlightCore::fast(&config, &mut state, &step);
        FlightCore::follow(&config, &mut state, &output);
        (output, state.step)
    };
    let (_, mut last_step) = step_with(1, None);
    for k in 2..600 {
        let torque_nm = [held_nm, 0.0, 0.0];
        let plan = Plan { step: last_step, torque_nm, status: PlanStatus::Solved, ..Plan::default() };
        let (output, step) = step_with(k, Some(plan));
        assert_eq!(output.source, TorqueSource::Mpc);
        last_step = step;
    }
    let (output, _) = step_with(600, None);
    assert_eq!(output.source, TorqueSource::CascadeNoPlan);
    assert!((output.wrench.torque_body_nm[0] - held_nm).abs() < 0.01 * held_nm, "{:?}", output.wrench);
}

#[test]
fn armed_on_a_slope_all_motors_idle_until_the_throttle_is_raised() {
    let (mut config, mut state) = armed(Controller::Cascade);
    config.ground_idle_command = 0.1;
    // 10 degrees of roll on the ground, for the accelerometer
    let (sin, cos) = crate::elementary::sin_cos(10f32.to_radians());
    let tilted = [(-4096.0 * sin) as i16, 0, (-4096.0 * cos) as i16];
    let mut last = None;
    for k in 1..400 {
        let throttle = if k < 390 { IDLE_THROTTLE_MAX } else { 0.5 };
        let mut step = input(k, throttle, ArmingRequest::None, None);
        step.imu[0].accel_counts = [-tilted[1], tilted[0], tilted[2]];
        let output = FlightCore::fast(&config, &mut state, &step);
        FlightCore::follow(&config, &mut state, &output);
        if k < 390 {
            assert_eq!(output.source, TorqueSource::Idle);
            let commands = output.mix.commands.0;
            assert!(commands.iter().all(|command| *command == 0.1), "{commands:?}");
        }
        last = Some(output);
    }
    assert_eq!(last.map(|output| output.source), Some(TorqueSource::Cascade));
}

#[test]
fn disarming_forgets_what_was_wound_up() {
    let (config, mut state) = armed(Controller::Cascade);
    for k in 1..200 {
        let mut step = input(k, 0.5, ArmingRequest::None, None);
        // a turn of 0.2 rad/s that the motors do not stop
        step.imu[0].gyro_counts = [0, 188, 0];
        let output = FlightCore::fast(&config, &mut state, &step);
        FlightCore::follow(&config, &mut state, &output);
    }
    assert!(state.rate != RateState::default());
    let off = input(200, 0.0, ArmingRequest::Disarm, None);
    let output = FlightCore::fast(&config, &mut state, &off);
    FlightCore::follow(&config, &mut state, &output);
    assert_eq!(state.rate, RateState::default());
    assert_eq!(state.rate_target, RateTarget::default());
    assert!(!state.watch.is_airborne());
}

proptest::proptest! {
    /// Two states that differ anywhere have different words, and there is room for all.
    #[test]
    fn words_tell_any_two_states_apart(
        gyro in proptest::collection::vec(-500i16..500, 40),
        asks in proptest::collection::vec(0u8..8, 40),
    ) {
        let (config, mut state) = armed(Controller::Cascade);
        let mut before = state;
        for (k, (gyro, ask)) in (1..).zip(gyro.into_iter().zip(asks)) {
            let arming = match ask {
                0 => ArmingRequest::Arm,
                1 => ArmingRequest::Disarm,
                2 => ArmingRequest::MotorTest(MotorTest { motor: 1, throttle_percent: 9, duration_ms: 10 }),
                _ => ArmingRequest::None,
            };
            let mut input = input(k, f32::from(ask) * 0.1, arming, None);
            input.imu[0].gyro_counts = [gyro, 3 - gyro, 7];
            let output = FlightCore::fast(&config, &mut state, &input);
            FlightCore::follow(&config, &mut state, &output);
            // all but the number of the step, which would tell any two apart
            let apart = State { step: before.step, ..state };
            proptest::prop_assert!(apart == before || apart.words() != before.words());
            let mut words = StateWords::EMPTY;
            state.record(&mut words);
            proptest::prop_assert_eq!(words.written, STATE_WORDS);
            before = state;
        }
    }
}
