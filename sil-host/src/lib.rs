//! The simulated vehicle, its co-simulation with the control core, and the comparison with measured logs.

pub mod model;
pub mod plant;
pub mod sensors;
