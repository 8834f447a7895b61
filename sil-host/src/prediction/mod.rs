//! The prediction of a log: one, for `sil compare` and `sil diagnose` alike.
//!
//! ```text
//! log -> windows of 0.5 s: to be fitted, to choose by, to report (window)
//!     -> channels (channel, subject), noise of each (noise), commands (commands, lost_commands)
//!     = a log that any model can be held against (windowed_log)
//! model: commands -> forces (force_track) -> rotation and flight (body) -> what the sensors report, row by row (model)
//! start state of a window from the rows around its start (start_state) -> open loop to the end of the window
//!     -> measured less predicted; the error of an exact model: the noise floor (accuracy)
//!     -> how a departure from it comes back, by the model's brakes and springs (restoring)
//!     -> a whole log (predicted_log)
//! ```
//!
//! Shared with the plant: the vehicle's numbers and propulsion, its equations of motion, its actuator and sensor chains
//! (`vehicle`), and the effects (`effects`). Its own: the integration (the motors once for a whole log, in steps of 0.4
//! ms, or in the body's where rotors are slow; the body by Runge-Kutta 4 in steps of up to 5 ms, under forces that are
//! known by their mean and first moment), and all that makes a log of many rows out of it.
//!
//! What checks it: synthetic logs are made by the plant under Dormand and Prince's method to 1e-6 of the state, and
//! every effect's log, held against the model that has it, must miss by the noise floor (`comparison::tests`): another
//! integrator and other bookkeeping of time, the same equations. Axes whose motion is known in closed form
//! (`start_state`, `diagnosis::nominal`) share nothing. Equations and effects are tested against those of the docs
//! pages, calling neither; beyond that speak the logs of real vehicles (`tests/tests/real_logs.rs`). A mistake in what
//! is shared that its own tests let pass shows in real logs only.

pub(crate) mod accuracy;
pub(crate) mod body;
mod channel;
pub(crate) mod commands;
pub(crate) mod drive;
mod drive_curve;
mod error;
pub(crate) mod force_track;
pub(crate) mod lost_commands;
pub(crate) mod model;
pub(crate) mod noise;
mod one_body;
mod past;
pub(crate) mod predicted_log;
pub(crate) mod restoring;
mod rotor_step;
mod scene;
pub(crate) mod start_state;
mod subject;
pub(crate) mod window;
pub(crate) mod windowed_log;

#[cfg(test)]
mod force_track_tests;

pub use accuracy::ChannelErrors;
pub use channel::Channel;
pub use error::NotPredictable;
pub use noise::MeasuredNoise;
pub use predicted_log::{ErrorAndFloor, PredictedLog, Sample};
pub use subject::Subject;
pub(crate) use window::Cut;
pub use window::{Part, WINDOW_S, Window};
