//! The vehicle that the firmware carries is the model's, number by number.

use shared_control::vehicle::VehicleParameters;
use sil_host::control_setup::{motor_lag_s, vehicle_parameters};
use sil_host::model::{Rig, VehicleModel};

#[test]
fn the_compiled_in_vehicle_is_the_nominal_gimbal() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    assert_eq!(VehicleParameters::F450_GIMBAL, vehicle_parameters(&model));
    assert_eq!(VehicleParameters::F450_GIMBAL_MOTOR_LAG_S, motor_lag_s(&model) as f32);
}
