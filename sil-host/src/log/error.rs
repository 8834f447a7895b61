//! What can be wrong with a log or a map, always with its place.

use std::fmt;

use super::contradiction::Contradiction;

/// A log or a map that can't be read: file, line, column, and what was expected.
#[derive(Debug, thiserror::Error)]
pub struct LogError {
    /// The file, as the caller named it.
    pub file: String,
    /// Line, counted from 1; `None` if the matter is not one line's.
    pub line: Option<usize>,
    /// Name of the column (of a log) or key (of a map).
    pub column: Option<String>,
    /// What is wrong.
    #[source]
    pub kind: LogErrorKind,
}

impl fmt::Display for LogError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(out, ":{line}")?;
        }
        if let Some(column) = &self.column {
            write!(out, ": `{column}`")?;
        }
        write!(out, ": {}", self.kind)
    }
}

/// The ways in which a log or a map can be wrong.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message beside each variant says it")]
pub enum LogErrorKind {
    #[error("can't be opened: {0}")]
    Unreadable(std::io::Error),
    #[error("can't be written: {0}")]
    Unwritable(std::io::Error),
    #[error("the gzip stream is damaged or cut off ({reason}) after {bytes} bytes of text")]
    Gzip { reason: String, bytes: usize },
    #[error("holds more than {0} bytes of text; cut the log into parts")]
    TooLarge(u64),
    #[error("no {format} log that can be read: {reason}")]
    Damaged { format: &'static str, reason: String },
    #[error("{0}")]
    NotThisVehicle(String),
    #[error(
        "its time {}: reading {reading} at {now} s follows {before} s, {gone} readings are out of order",
        if .now < .before { "runs back" } else { "stands still" }
    )]
    TimeRunsBack { reading: usize, before: f64, now: f64, gone: usize },
    #[error("{0}: a wrong unit or a broken sensor")]
    MostlyOutOfRange(String),
    #[error("the log holds no {wanted}; it holds: {here}")]
    NoReadings { wanted: &'static str, here: String },
    #[error("expected at least {ROWS_MIN} rows with rates, angles and commands, found {rows}; it holds {streams}")]
    TooFewRowsInCommon { rows: usize, streams: String },
    #[error("{0}")]
    OtherFile(&'static str),
    #[error("not UTF-8 text; expected a CSV file")]
    NotText,
    #[error("the file is empty; expected a header line and at least {ROWS_MIN} rows")]
    Empty,
    #[error(
        "numbers stand where the names of the columns are expected: write a first line that says what each column is, \
         by the names of docs/log-format.md, or by names of your own for `sil map`"
    )]
    NoNames,
    #[error("{reason}; the header has: {present}")]
    MissingColumn { reason: String, present: String },
    #[error("given twice: as `{first}` and as `{second}`")]
    GivenTwice { first: String, second: String },
    #[error("expected {expected} fields as in the header, found {found}")]
    RaggedRow { expected: usize, found: usize },
    #[error("expected a number, found `{0}`")]
    NotANumber(String),
    #[error("expected `{before}` before a fraction, as in the lines before, found `{field}`")]
    OtherDecimalMark { before: char, field: String },
    #[error("expected a finite number, found `{0}`")]
    NotFinite(String),
    #[error("{value} is outside {min}..{max}{hint}")]
    OutOfRange { value: f64, min: f64, max: f64, hint: String },
    #[error("time must increase: {now} s follows {before} s")]
    TimeNotIncreasing { before: f64, now: f64 },
    #[error("expected at least {ROWS_MIN} rows, found {0}")]
    TooFewRows(usize),
    #[error(
        "expected at least {ROWS_MIN} rows from {from_s} s to {}, found {rows}; the log goes from {} s to {} s",
        end(*to_s),
        has_s[0],
        has_s[1]
    )]
    SpanTooShort { from_s: f64, to_s: f64, rows: usize, has_s: [f64; 2] },
    #[error("expected columns of {expected} values, found {found}")]
    UnequalColumns { expected: usize, found: usize },
    #[error("can't be what its columns say{}", listed(.0))]
    Contradictory(Vec<Contradiction>),
    #[error("{0}")]
    NotTurned(String),
    #[error("{0}")]
    MapSyntax(String),
    #[error("no such file, and no built-in map of that name; built in are: {0}")]
    NoSuchMap(String),
}

/// What a log holds, by names that are known here, and the fields of which only its owner knows what they mean.
pub(super) fn held(known: &[String], unknown: &[String]) -> String {
    let known = match known {
        [] => "nothing under a name that is known here (a --map names the fields)".to_owned(),
        known => known.join(", "),
    };
    let fields = unknown.join(", ");
    if unknown.is_empty() { known } else { format!("{known}; what these mean a map may say (--map): {fields}") }
}

/// Where a span ends.
fn end(to_s: f64) -> String {
    if to_s.is_finite() { format!("{to_s} s") } else { "the end".to_owned() }
}

fn listed(contradictions: &[Contradiction]) -> String {
    contradictions.iter().map(|contradiction| format!("\n  {contradiction}")).collect()
}

/// Fewer rows than this are not a log (docs/log-format.md).
pub const ROWS_MIN: usize = 100;
