//! What a better model is good for.

use shared_control::config::Controller;
use sil_host::controller_file::ControllerChoice;
use sil_host::effects::Effect;
use sil_host::flight::FlightSetup;
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;

/// A model that a diagnosis has extended makes a better controller by itself: the same vehicle, with motors that are
/// slower and later than the nominal ones, is flown by a controller that takes it for nominal, and by one that knows.
#[test]
fn a_diagnosed_model_makes_a_better_controller() {
    let slow = "motor_lag:time_constant_s=0.03";
    let late = "actuation_delay:delay_s=0.012";
    for control_horizon in [5, 30] {
        let choice = ControllerChoice { control_horizon, ..ControllerChoice::nominal(Controller::Mpc) };
        let mut model = VehicleModel::nominal(Rig::Gimbal);
        model.effects.extend([slow, late].map(|text| Effect::parse(text, Rig::Gimbal).unwrap()));
        let ignorant =
            FlightSetup { model, controller_model: None, choice, scenario: Scenario::test_sequence(), seed: 1 };
        let knowing = FlightSetup { controller_model: Some(ignorant.model.clone()), ..ignorant.clone() };
        let figures = |setup: &FlightSetup| (setup.margins().unwrap(), setup.fly().unwrap().summary.effort);
        let ((ignorant_margins, ignorant_effort), (knowing_margins, knowing_effort)) =
            (figures(&ignorant), figures(&knowing));
        println!("M = {control_horizon}, ignorant: {ignorant_margins:?}, effort {ignorant_effort}");
        println!("M = {control_horizon}, knowing: {knowing_margins:?}, effort {knowing_effort}");
        assert!(knowing_effort < 0.8 * ignorant_effort, "{knowing_effort} {ignorant_effort}");
        for axis in 0..2 {
            let knows = knowing_margins.unwrap()[axis];
            assert!(knows.phase_deg.unwrap() > 35.0 && knows.sensitivity_peak < 2.0, "{knows:?}");
            // it oscillates by itself, or nearly
            let poor = ignorant_margins.is_none_or(|axes| axes[axis].sensitivity_peak > 2.0 * knows.sensitivity_peak);
            assert!(poor, "{ignorant_margins:?}");
        }
    }
}
