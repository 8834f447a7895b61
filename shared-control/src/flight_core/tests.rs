//! The pipeline without a plant: who flies when, and that nothing hidden changes a result.

extern crate std;
use super::*;
use crate::config::{Tuning, mpc_settings};
use crate::lift_curve::LiftCurve;
use crate::signals::{ArmingRequest, RawImuSample, Setpoint};
use crate::vehicle::VehicleParameters;

const VEHICLE: VehicleParameters = VehicleParameters {
    gravity_m_s2: 9.80665,
    arm_m: 0.226,
    inertia_kg_m2: [0.0115, 0.0366, 0.02],
    torque_per_lift_m: 0.038,
    lift_curve: LiftCurve { lift_min_n: 0.0, lift_max_n: 2.0, command_at: straight_commands() },
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
fn a_plan_flies_only_if_it_is_for_this_step_and_solved() {
    let (config, state) = armed(Controller::Mpc);
    let plan = Plan { step: state.step, input: [0.5, 0.0, 0.0], status: PlanStatus::Solved, iterations: 1 };
    let source_with = |plan| {
        let mut state = state;
        FlightCore::fast(&config, &mut state, &input(1, 0.5, ArmingRequest::None, plan)).source
    };
    assert_eq!(source_with(Some(plan)), TorqueSource::Mpc);
    assert_eq!(source_with(None), TorqueSource::CascadeNoPlan);
    assert_eq!(source_with(Some(Plan { step: plan.step.wrapping_sub(1), ..plan })), TorqueSource::CascadeNoPlan);
    for status in [PlanStatus::IterationLimit, PlanStatus::Infeasible, PlanStatus::NumericalError] {
        assert_eq!(source_with(Some(Plan { status, ..plan })), TorqueSource::CascadeUnsolved(status));
    }
    let (cascade, mut cascade_state) = armed(Controller::Cascade);
    let output = FlightCore::fast(&cascade, &mut cascade_state, &input(1, 0.5, ArmingRequest::None, Some(plan)));
    assert_eq!(output.source, TorqueSource::Cascade);
}

#[test]
fn the_plan_request_looks_one_step_ahead() {
    let (config, mut state) = armed(Controller::Mpc);
    let plan = Plan { step: state.step, input: [0.5, -0.25, 0.0], status: PlanStatus::Solved, iterations: 1 };
    let step = input(1, 0.5, ArmingRequest::None, Some(plan));
    let output = FlightCore::fast(&config, &mut state, &step);
    let request = FlightCore::follow(&config, &mut state, &output).unwrap();
    assert_eq!(request.step, state.step);
    let acceleration = 0.5 * 0.226 / 0.0115;
    assert!((request.rate_rad_s[0] - 0.0025 * acceleration).abs() < 1e-6);
    assert!((request.angle_rad[0] - 0.5 * 0.0025 * 0.0025 * acceleration).abs() < 1e-7);
    assert!((request.input_prev[1] + 0.25).abs() < 1e-6);
}

#[test]
fn step_is_its_three_calls_and_a_replay_repeats_it_to_the_bit() {
    let (config, start) = armed(Controller::Mpc);
    let mpc = Mpc::<3>::prepare(&mpc_settings(&VEHICLE, &Tuning::for_motor_lag(0.0))).unwrap();
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
            let plan = Plan { step: state.step, input: [f32::NAN; 3], status: PlanStatus::Solved, iterations: 1 };
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
                assert!(finite(request.angle_rad) && finite(request.rate_rad_s) && finite(request.reference_rad));
                assert!(finite(request.input_prev));
            }
        }
    }
}
