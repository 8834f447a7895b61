//! The simulated vehicle, its co-simulation with the control core, and the comparison with measured logs.

pub mod axis;
pub mod bench_mpc;
pub mod closed_loop;
pub mod comparison;
pub mod control_setup;
pub mod controller_file;
pub mod cosim;
pub mod diagnosis;
mod document;
pub mod effects;
pub mod flight;
pub mod flight_log;
pub mod hitl;
pub mod log;
pub mod margins;
pub mod metrics;
pub mod model;
pub mod planner;
pub mod plant;
pub mod prediction;
pub mod report;
pub mod scenario;
pub mod sensors;
pub mod statistics;
pub mod synthesis;
pub mod vehicle;
