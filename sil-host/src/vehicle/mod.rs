//! The vehicle's parts, each physical fact once: read by the plant, the prediction of logs and the controllers' set-up.

mod actuator_chain;
mod euler;
pub mod propulsion;
mod sensor_chain;

pub(crate) use actuator_chain::ActuatorChain;
pub(crate) use euler::{euler_rad, quaternion_world_from_body};
pub(crate) use sensor_chain::SensorChain;
