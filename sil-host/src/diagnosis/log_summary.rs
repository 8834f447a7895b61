//! What was diagnosed.

use serde::Serialize;

use crate::log::Log;

/// The log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogSummary {
    /// As the caller named it.
    pub path: String,
    /// Rows.
    pub rows: usize,
    /// Time from first to last, s.
    pub duration_s: f64,
    /// Rows per second.
    pub rate_hz: f64,
    /// What its reading took, assumed, left out and checked.
    pub notes: Vec<String>,
}

impl LogSummary {
    pub(super) fn of(log: &Log) -> LogSummary {
        LogSummary {
            path: log.path.clone(),
            rows: log.rows(),
            duration_s: log.duration_s(),
            rate_hz: log.rate_hz(),
            notes: log.notes.clone(),
        }
    }
}
