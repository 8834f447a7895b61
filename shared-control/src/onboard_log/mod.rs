//! The vehicle's own log: what a step was given and what it gave out, as ULog with PX4's topics.
//!
//! ```text
//!   StepInput, StepOutput -> Recorder (loop) -> ring of bytes -> whoever has the memory (where there is time)
//!                                                 head -------->  file: head, then the ring's bytes
//! ```
//! The loop copies a few hundred bytes a step and never waits: where the ring has no room, the whole step is left out,
//! counted, and its time stands in the log as a dropout. Whoever empties the ring writes [`head`] first. Board and
//! simulator have one writer, and `sil fly --log` writes the same topics by it.
//!
//! | topic | written | bytes |
//! |---|---|---|
//! | `sensor_combined` | every step with a sample: mean of the samples since the last step | 49 |
//! | `vehicle_angular_velocity` | every step | 33 |
//! | `vehicle_attitude` | every step | 37 |
//! | `actuator_motors` | every step | 71 |
//! | `mpc_status`, this project's own | every step with a plan, or with the cascade in the MPC's place | 41 |
//! | `vehicle_attitude_setpoint` | where angles are flown: when it changes, and ten times a second | 45 |
//! | `vehicle_rates_setpoint` | 50 times a second | 37 |
//! | `input_rc` | ten times a second, where there is a receiver | 51 |
//! | `battery_status` | five times a second, where it is measured | 29 |
//! | `vehicle_status` | when it changes, and twice a second | 19 |
//! | `failure_detector_status` | where `MOTOR_LOSS` is 1: when it changes, and twice a second | 16 |
//!
//! The bytes are those of a whole message. Only the last six rows are thinned. At 400 steps a second that is 79 kB/s
//! under the cascade and 95 kB/s under the MPC.
//!
//! Formats: <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>, topics: PX4 1.14, "uORB Message Reference".

mod head;
mod recorder;
mod ring;
pub mod topics;
pub mod ulog;

pub use head::head;
pub use recorder::{Recorder, Stage};

#[cfg(test)]
mod tests;
