//! The PID cascade as APM:Copter has it (thesis section 4.3.1; ArduPilot's AC_AttitudeControl).
//!
//! ```text
//!  set-point -> shaping -> attitude error -> square root P -> rate target -+- follow (after the outputs)
//!                  `----- feed-forward of rate and acceleration ---^       |
//!  gyro ----------------------------------------------------> rate PID <---'   fast (before them)
//! ```
//! [`angle::update`] runs after the outputs are written and gives the rate target that the next step's
//! [`rate::update`] uses: one sample of delay, no jitter. In acro [`acro::update`] stands in its place.

pub mod acro;
pub mod angle;
pub mod course;
pub mod rate;
pub mod shaping;
pub mod square_root;
