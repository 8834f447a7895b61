//! The prediction of a log: commands become forces (`force_track`), forces turn the `body` and move it through the `air`, the `sensor`
//! reports it; `model` runs all three over the rows of a window.

pub(crate) mod air;
pub(crate) mod body;
mod channel;
pub(crate) mod force_track;
pub(crate) mod model;
pub(crate) mod sensor;

pub use channel::Channel;
