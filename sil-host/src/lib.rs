//! The simulated vehicle, its co-simulation with the control core, and the comparison with measured logs.

pub mod report;
