//! The vehicle's parts, each physical fact once: read by the plant, the prediction of logs and the controllers' set-up.
//!
//! ```text
//! command -> actuator_chain -> propulsion -> lifts -> airframe: torque -> gimbal | free_body -> motion -> sensor_chain
//!                                              ^-- air: ground              ^-- air: drag        ^-- vibration
//! ```
//! Nothing here holds a state or integrates: whoever calls does, the plant in steps of its own, the prediction row by
//! row of a log. What effects may change of it stands in `Changes`.

mod actuator_chain;
mod air;
mod airframe;
mod attitude;
mod changes;
mod free_body;
mod gimbal;
mod motion;
pub mod propulsion;
mod rig;
mod scale;
mod sensor_chain;
mod vibration;

pub(crate) use actuator_chain::{ActuatorChain, CommandPath, StraightLine, on_the_way};
pub(crate) use air::Air;
pub(crate) use airframe::{Airframe, NetSpin, signed_sums, spin_sum};
pub(crate) use attitude::{Attitude, cross, euler_rad, euler_rates_rad_s, quaternion_world_from_body, rotated};
pub(crate) use changes::{BodyChange, Changes};
pub(crate) use free_body::FreeBody;
pub(crate) use gimbal::Gimbal;
pub(crate) use motion::{Moment, Motion, Onset};
pub use rig::{Mounting, Rig};
pub(crate) use rig::{NominalBody, RigidBody};
pub(crate) use scale::Scale;
pub(crate) use sensor_chain::SensorChain;
pub(crate) use vibration::{FIRST_PHASES_RAD, Turning, Vibration, turned_on};
