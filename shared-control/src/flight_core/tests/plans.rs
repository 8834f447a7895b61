//! Which plans fly, which are refused, and what is said of them.

use super::*;

#[test]
fn a_plan_flies_only_if_it_is_for_this_step_and_solved_or_curtailed() {
    let (config, state) = armed(Controller::Mpc);
    let plan = Plan { step: state.step, torque_nm: [0.1, 0.0, 0.0], status: PlanStatus::Solved, ..Plan::default() };
    let source_with = |plan| {
        let mut state = state;
        FlightCore::fast(&config, &mut state, &input(1, 0.5, ArmingRequest::None, plan)).source
    };
    assert_eq!(source_with(Some(plan)), TorqueSource::Mpc);
    let curtailed = Plan { status: PlanStatus::Curtailed, ..plan };
    assert_eq!(source_with(Some(curtailed)), TorqueSource::Mpc);
    let beyond = Plan { torque_nm: [3e38, 0.0, 0.0], ..curtailed };
    assert_eq!(source_with(Some(beyond)), TorqueSource::CascadeUnsolved(PlanStatus::NumericalError));
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
fn a_plan_beyond_the_bounds_did_not_come_from_the_mpc() {
    let (config, state) = armed(Controller::Mpc);
    let refused = TorqueSource::CascadeUnsolved(PlanStatus::NumericalError);
    let source_at = |axis: usize, torque_nm: f32| {
        let mut state = state;
        let mut plan = Plan { step: state.step, status: PlanStatus::Solved, ..Plan::default() };
        plan.torque_nm[axis] = torque_nm;
        FlightCore::fast(&config, &mut state, &input(1, 0.5, ArmingRequest::None, Some(plan))).source
    };
    assert_eq!(source_at(0, 3e38), refused);
    for axis in 0..3 {
        let max_nm = config.mpc_torque_max_nm[axis];
        for sign in [1.0, -1.0] {
            assert_eq!(source_at(axis, sign * max_nm), TorqueSource::Mpc, "axis {axis}: a bound may be used");
            assert_eq!(source_at(axis, 1.0005 * sign * max_nm), TorqueSource::Mpc, "axis {axis}: rounding");
            assert_eq!(source_at(axis, 1.01 * sign * max_nm), refused, "axis {axis}");
        }
    }
}

#[test]
fn what_the_mixer_could_not_deliver_is_no_part_of_the_planners_input() {
    let (config, mut state) = armed(Controller::Mpc);
    // roll and pitch at their bounds together, more than one motor's span gives each
    let plan = Plan { step: state.step, torque_nm: [0.452, 0.452, 0.0], status: PlanStatus::Solved, ..Plan::default() };
    let step = input(1, 0.03, ArmingRequest::None, Some(plan));
    let output = FlightCore::fast(&config, &mut state, &step);
    assert_eq!(output.source, TorqueSource::Mpc);
    let request = FlightCore::follow(&config, &mut state, &output).unwrap();
    for axis in 0..2 {
        let delivered_nm = output.wrench.torque_body_nm[axis] - output.mix.unmet_torque_nm[axis];
        assert!(output.mix.unmet_torque_nm[axis] > 0.1, "{:?}", output.mix);
        assert!((request.torque_prev_nm[axis] - delivered_nm).abs() < 1e-6);
    }
}

/// What the output says of the plans is what happened: two that came late, one that was not solved, the rest flown.
#[test]
fn the_output_tells_how_the_plans_fare() {
    let (config, mut state) = armed(Controller::Mpc);
    let plan_of = |state: &State| Plan { step: state.step, iterations: 3, duration_us: 250, ..Plan::default() };
    let solved = |state: &State| Plan { status: PlanStatus::Solved, ..plan_of(state) };
    let mut last = PlanReport::default();
    for k in 1..=10 {
        let plan = match k {
            // one that comes late, and one that never comes
            4 => Some(Plan { step: state.step.wrapping_sub(1), ..solved(&state) }),
            7 => None,
            9 => Some(Plan { status: PlanStatus::IterationLimit, ..plan_of(&state) }),
            _ => Some(solved(&state)),
        };
        let output = FlightCore::fast(&config, &mut state, &input(k, 0.5, ArmingRequest::None, plan));
        FlightCore::follow(&config, &mut state, &output);
        let expected = match k {
            4 | 7 => (None, 0, 0),
            9 => (Some(PlanStatus::IterationLimit), 3, 250),
            _ => (Some(PlanStatus::Solved), 3, 250),
        };
        last = output.planning;
        assert_eq!((last.status, last.iterations, last.duration_us), expected, "step {k}");
    }
    assert_eq!((last.fallbacks, last.deadline_misses), (3, 2));
    // the cascade asks for no plan, and misses none
    let (config, mut state) = armed(Controller::Cascade);
    let output = FlightCore::fast(&config, &mut state, &input(1, 0.5, ArmingRequest::None, None));
    assert_eq!(output.planning, PlanReport::default());
}
