//! The thesis' experiment as far as it can be had again: its MPC, and its testbed with the ring off balance.

use crate::axis::Axis;
use crate::controller_file::{ControllerChoice, ControllerFileError};
use crate::effects::{CgOffset, Effect};
use crate::model::{Rig, VehicleModel};

/// Moment of the ring at which the nominal simulation of the thesis' MPC misses pitch by what the thesis measured, N m.
pub const RING_MOMENT_NM: f64 = 0.167;

/// The thesis' MPC: 100 Hz, one free input, no estimate of disturbances.
///
/// # Errors
/// None: its file ships, and a test reads it.
pub fn thesis_mpc() -> Result<ControllerChoice, ControllerFileError> {
    ControllerChoice::parse(include_str!("../../demonstration/thesis-mpc.toml"), "thesis-mpc.toml")
}

/// The testbed whose ring has its centre of gravity off the pitch axis.
pub fn off_balance(moment_nm: f64) -> VehicleModel {
    let ring = CgOffset { axis: Axis::Pitch, cos_moment_nm: moment_nm, sin_moment_nm: 0.0 };
    VehicleModel { effects: vec![Effect::CgOffset(ring)], ..VehicleModel::nominal(Rig::Gimbal) }
}
