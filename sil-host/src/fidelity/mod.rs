//! How far the simulation is from a measured log.
//!
//! ```text
//! log -> windows of 0.5 s -> start state from the rows around the start -> replay of the logged commands
//!     -> residuals (observed, predicted, sigma of an exact model) -> RMSE, nominal against the noise floor
//! ```
//!
//! [`replay_axes`] replays a log on single rigid axes with an input gain fitted to it (foreign benches),
//! [`replay_plant`] on the gimbal or in free flight. Both give a [`Replay`]: the windows, some of them held out from
//! every fit, and one [`Residual`] per sample and channel. [`mean_absolute_deviation`] is the thesis' measure for a
//! closed loop, table 5.1; [`Agreement`], [`Correlogram`], [`ConditionalError`] and [`amplitude_spectrum`] are the statistics that people use
//! to see how far and where a prediction is off.

mod agreement;
mod condition;
mod deviation;
mod error;
mod floor;
mod noise;
#[cfg(test)]
mod noise_source;
mod observe;
mod replay;
mod residual;
mod spectrum;
mod start;
mod vehicle;
mod whiteness;
mod window;
mod windowed_log;

pub use agreement::{Agreement, TheilSplit};
pub use condition::{Bin, ConditionalError};
pub use deviation::mean_absolute_deviation;
pub(crate) use deviation::wrapped;
pub use error::FidelityError;
pub(crate) use noise::deviations;
pub use noise::{SensorNoise, white_noise_std};
pub use replay::{Replay, ReplayOptions, replay_axes, replay_plant};
pub use residual::{Channel, ChannelErrors, Part, PredictionError, Residual};
pub use spectrum::amplitude_spectrum;
pub(crate) use vehicle::axis_commands;
pub use whiteness::{Correlogram, InputCorrelation, LjungBox, chi_square_99, input_correlation};
pub(crate) use window::windows as cut_windows;
pub use window::{WINDOW_S, Window};
pub(crate) use windowed_log::USUAL_CONTROL_RATE_HZ;
