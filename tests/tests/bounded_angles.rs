//! Bounds on roll and pitch in the MPC, flown on the simulated vehicle with its sensors.

use campaigns::limits_and_switching::route;
use shared_control::config::Controller;
use sil_host::controller_file::{ControllerChoice, ReferenceName, TuningChange};
use sil_host::flight::FlightSetup;
use sil_host::model::{Rig, VehicleModel};

/// The thesis' weights after the raw set-point, which overshoot.
fn tuning(mpc_tilt_max_rad: Option<f32>) -> TuningChange {
    TuningChange {
        mpc_reference: Some(ReferenceName::Setpoint),
        mpc_lead_s: Some([0.0; 3]),
        mpc_increment_weight: Some([30.0, 30.0, 3000.0]),
        mpc_tilt_max_rad,
        ..TuningChange::default()
    }
}

/// The steepest roll in a step to 20 degrees, and steps flown by the cascade.
fn steepest_deg(control_horizon: usize, mpc_tilt_max_rad: Option<f32>) -> (f64, u32) {
    let choice = ControllerChoice {
        tuning: tuning(mpc_tilt_max_rad),
        control_horizon,
        ..ControllerChoice::nominal(Controller::Mpc)
    };
    let setup = FlightSetup {
        model: VehicleModel::nominal(Rig::Gimbal),
        controller_model: None,
        choice,
        scenario: route(&[(20.0, 0.0)], None),
        seed: 1,
    };
    let flight = setup.fly().expect("a configuration that flies");
    let steepest = flight.record.angle_rad.iter().fold(0.0, |most: f64, [roll, ..]| most.max(roll.abs()));
    (steepest.to_degrees(), flight.summary.mpc.expect("an MPC flew").fallbacks)
}

#[test]
fn a_step_stays_inside_the_bound_that_it_overshoots_without() {
    for control_horizon in [1, 5, 10, 30] {
        let (free_deg, _) = steepest_deg(control_horizon, None);
        let (bounded_deg, fallbacks) = steepest_deg(control_horizon, Some(20.2_f32.to_radians()));
        // what the bound cannot know: how the plant differs from the prediction, and what the estimate is off
        assert!(bounded_deg < 20.2 + 0.5, "M {control_horizon}: {bounded_deg}");
        assert!(free_deg > bounded_deg + 0.2, "M {control_horizon}: {free_deg} and {bounded_deg} with the bound");
        assert_eq!(fallbacks, 0);
    }
}

#[test]
fn a_set_point_beyond_the_bound_is_followed_up_to_it() {
    let (bounded_deg, fallbacks) = steepest_deg(5, Some(15.0_f32.to_radians()));
    assert!((bounded_deg - 15.0).abs() < 0.5, "{bounded_deg}");
    assert_eq!(fallbacks, 0);
}
