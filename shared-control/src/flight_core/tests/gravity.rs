//! Gravity's moment, where it is known, is held against at once, by either controller, and learnt by neither.

use super::*;
use crate::gravity_moment::{GravityMoment, OffCentre};

/// The ring pulls the nose down.
const RING: GravityMoment = GravityMoment { ring: OffCentre { cos_nm: 0.1, sin_nm: 0.0 }, ..GravityMoment::NONE };

fn armed_on_an_unbalanced_ring(controller: Controller) -> (Config, State) {
    let (config, state) = armed(controller);
    (Config { gravity_moment: Some(RING), ..config }, state)
}

#[test]
fn a_known_moment_is_held_from_the_first_step() {
    let (config, mut state) = armed_on_an_unbalanced_ring(Controller::Mpc);
    let output = FlightCore::fast(&config, &mut state, &input(1, 0.5, ArmingRequest::None, None));
    // no plan yet: the cascade, whose integral has followed the motors' standing still for one step in forty
    assert!((output.wrench.torque_body_nm[1] - 0.1).abs() < 3e-3, "{:?}", output.wrench);
    let request = FlightCore::follow(&config, &mut state, &output).unwrap();
    assert!((request.disturbance_nm[1] + 0.1).abs() < 1e-3, "{:?}", request.disturbance_nm);
}

/// While plans hold against it at rest, neither the observer nor the cascade's integral takes it for something new.
#[test]
fn a_known_moment_is_not_learnt_again() {
    let (config, mut state) = armed_on_an_unbalanced_ring(Controller::Mpc);
    for k in 1..=400 {
        let plan = Plan { step: state.step, torque_nm: [0.0, 0.1, 0.0], status: PlanStatus::Solved, ..Plan::default() };
        let output = FlightCore::fast(&config, &mut state, &input(k, 0.5, ArmingRequest::None, Some(plan)));
        FlightCore::follow(&config, &mut state, &output);
    }
    assert!(state.disturbance_nm()[1].abs() < 1e-3, "{:?}", state.disturbance_nm());
    let fallback = FlightCore::fast(&config, &mut state, &input(401, 0.5, ArmingRequest::None, None));
    assert!((fallback.wrench.torque_body_nm[1] - 0.1).abs() < 2e-3, "{:?}", fallback.wrench);
}
