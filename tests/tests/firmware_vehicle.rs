//! The vehicles that the firmware carries are the models', number by number.

use shared_control::vehicle::VehicleParameters;
use sil_host::control_setup::vehicle_parameters;
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
