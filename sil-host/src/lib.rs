//! The simulated vehicle, its co-simulation with the control core, and the comparison with measured logs.

pub mod fidelity;
pub mod log;
pub mod model;
pub mod plant;
