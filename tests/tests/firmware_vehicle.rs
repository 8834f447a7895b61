//! The vehicles that the firmware carries are the models', number by number.

use shared_control::config::{Controller, Tuning};
use shared_control::params::Params;
use shared_control::vehicle::VehicleParameters;
use sil_host::control_setup::{core_config, vehicle_parameters};
use sil_host::model::{Rig, VehicleModel};

#[test]
fn the_compiled_in_vehicle_is_the_nominal_gimbal() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    assert_eq!(VehicleParameters::F450_GIMBAL, vehicle_parameters(&model));
}

#[test]
fn the_compiled_in_free_vehicle_is_the_nominal_one() {
    let model = VehicleModel::nominal(Rig::Free);
    assert_eq!(VehicleParameters::F450_FREE, vehicle_parameters(&model));
}

/// The board's default, the host's core for this model, and the model file agree.
#[test]
fn the_rotor_drag_that_is_known_is_the_free_models() {
    let model = VehicleModel::nominal(Rig::Free);
    let permille = Params::DEFAULT.rotor_drag_permille_1_s;
    assert_eq!(model.known_rotor_drag_1_s, f64::from(permille) / 1000.0);
    let tuning = Tuning::for_vehicle(&vehicle_parameters(&model));
    let drag_of = |model: &VehicleModel| {
        let config = core_config(model, &tuning, 400, 1000, Controller::Cascade).unwrap();
        config.sensing.estimator.levelling.rotor_drag_1_s
    };
    assert_eq!(drag_of(&model), 0.45);
    let other = VehicleModel { known_rotor_drag_1_s: 0.3, ..model };
    assert_eq!(drag_of(&other), 0.3);
    let again = VehicleModel::parse(&other.to_toml(), "written").unwrap();
    assert_eq!(again.known_rotor_drag_1_s, 0.3);
}
