//! How far the simulation is from a measured log.
//!
//! ```text
//! log -> windows of 0.5 s -> start state from the rows around the start -> replay of the logged commands
//!     -> residuals (observed, predicted, sigma of an exact model) -> RMSE, nominal against the noise floor
//! ```
//!
//! [`replay_axes`] replays a log on single rigid axes with an input gain fitted to it (foreign benches),
//! [`replay_plant`] on the gimbal or in free flight. Both give a [`Replay`]: the windows, some of them held out from
//! every fit, and one [`Residual`] per sample and channel. The statistics that people use are in [`crate::statistics`].

mod error;
mod floor;
mod noise;
mod observe;
mod replay;
mod residual;
mod start;
mod vehicle;
mod window;
mod windowed_log;

pub use error::FidelityError;
pub(crate) use noise::deviations;
pub use noise::{SensorNoise, white_noise_std};
pub use replay::{Replay, ReplayOptions, replay_axes, replay_plant};
pub use residual::{Channel, ChannelErrors, Part, PredictionError, Residual};
pub(crate) use vehicle::axis_commands;
pub(crate) use window::windows as cut_windows;
pub use window::{WINDOW_S, Window};
pub(crate) use windowed_log::USUAL_CONTROL_RATE_HZ;
