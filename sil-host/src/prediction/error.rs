//! Why the rows of a log can't be predicted.

/// A log that can be read, but not predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotPredictable {
    /// Nowhere do the motors run for a whole window without a gap in time.
    #[error(
        "no window of {window_s} s in which the motors run and no rows are missing \
         ({rows} rows over {duration_s:.1} s)"
    )]
    NoWindow {
        /// Length of a window, s.
        window_s: f64,
        /// Rows of the log.
        rows: usize,
        /// Its duration, s.
        duration_s: f64,
    },
    /// In no row of the log do the motors run.
    #[error("the motors run in none of the {rows} rows over {duration_s:.1} s: the vehicle was not armed, or stood")]
    MotorsStand {
        /// Rows of the log.
        rows: usize,
        /// Its duration, s.
        duration_s: f64,
    },
    /// The rows are too far apart to find a start state or judge a window.
    #[error("rows every {step_s} s are too few: a window of {window_s} s needs at least {rows_min}")]
    TooSlow {
        /// Median time between rows, s.
        step_s: f64,
        /// Length of a window, s.
        window_s: f64,
        /// Fewest rows in a window.
        rows_min: usize,
    },
    /// The prediction needs a column that the log lacks.
    #[error("the log has no column `{column}`, which {why}")]
    MissingColumn {
        /// Name in docs/log-format.md.
        column: String,
        /// What it is needed for.
        why: &'static str,
    },
    /// Even an exact model's predictions would be far from what was measured.
    #[error(
        "the log can't show what turns the vehicle: even an exact model would miss {channel} by {floor}, \
         which varies by {moved}; columns that it lacks: {lacking}"
    )]
    Unseen {
        /// The channel that it shows least of.
        channel: &'static str,
        /// Its standard deviation, with its unit.
        moved: String,
        /// An exact model's error.
        floor: String,
        /// Angles and rates that were not measured.
        lacking: String,
    },
    /// No axis' command ever changes: no gain can be found.
    #[error("the {axis} command never changes while the motors run: its input gain can't be found")]
    NoExcitation {
        /// roll, pitch or yaw.
        axis: &'static str,
    },
}
