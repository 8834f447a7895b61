//! The prediction of a log: commands become forces (`force_track`), forces turn and move the vehicle (`body`), `model` runs both over
//! the rows of a window and reports what the sensors make of it. The vehicle's equations and the effects are those of `vehicle` and
//! `effects`, which the plant takes too; what is the prediction's own is the integration: forces once for a whole log, windows in
//! steps of the log's rows.

pub(crate) mod body;
pub(crate) mod force_track;
pub(crate) mod model;
