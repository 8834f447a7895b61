//! The rows of a CSV as columns: every field of every line is checked, and what is wrong is named by line and column.

use super::super::error::{LogError, LogErrorKind};
use super::super::quantity::Quantity;
use super::super::runs::runs;
use super::super::style::Style;
use super::error_in;
use super::fields::Field;
use super::lines::unquoted;

/// The fields of all rows, column by column.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) columns: Vec<Vec<f64>>,
    /// Fields without a value, which are NaN.
    pub(super) blanks: usize,
    pub(super) repeated: Repeated,
    pub(super) one_time: OneTime,
}

/// Rows that have the time of the row before: of a clock that is coarser than they are, or of a batch that was stamped
/// when it arrived.
#[derive(Default)]
pub(super) struct OneTime {
    count: usize,
    /// One after the other, here and at most.
    run: usize,
    longest: usize,
    /// Line and time of the first.
    first: Option<(usize, f64)>,
}

impl OneTime {
    /// Fewer than this share of all rows are mistakes, each by itself.
    const SHARE_MIN: f64 = 0.05;
    /// More of them in a run are a clock that stands still.
    const RUN_MAX: usize = 50;

    /// Takes a row.
    fn take(&mut self, line: usize, before: f64, now: f64) {
        let is_one = now == before;
        self.run = if is_one { self.run + 1 } else { 0 };
        self.longest = self.longest.max(self.run);
        self.count += usize::from(is_one);
        self.first = self.first.or_else(|| is_one.then_some((line, now)));
    }

    pub(super) fn notes(&self) -> Option<String> {
        let count = self.count;
        let note = || {
            format!("{count} rows have the time of the row before: those of one time are spread evenly up to the next")
        };
        (count > 0).then(note)
    }

    /// The first of them, where they are mistakes.
    fn mistake(&self, rows: usize) -> Option<(usize, f64)> {
        let are_few = (self.count as f64) < Self::SHARE_MIN * rows as f64;
        self.first.filter(|_| are_few || self.longest > Self::RUN_MAX)
    }
}

/// Spreads the rows of one time evenly up to the next time; the last ones take the step before.
fn spread(time_s: &mut [f64]) {
    let mut step_s = 0.0;
    for run in runs(time_s.len(), |row| time_s[row] == time_s[row - 1]) {
        let [from_s, count] = [time_s[run.start], run.len() as f64];
        step_s = time_s.get(run.end).map_or(step_s, |next_s| (next_s - from_s) / count);
        (0..).zip(&mut time_s[run]).for_each(|(place, time_s)| *time_s = from_s + f64::from(place) * step_s);
    }
}

/// Lines that say the same as the one before, number of the first.
#[derive(Default)]
pub(super) struct Repeated {
    count: usize,
    first: usize,
}

impl Repeated {
    pub(super) fn notes(&self) -> Option<String> {
        (self.count > 0).then(|| format!("{} lines repeat the one before, the first line {}", self.count, self.first))
    }
}

/// The number of the line that a row was read from: lines that repeat the one before are no rows.
pub(super) fn line_of<'a>(row: usize, lines: impl Iterator<Item = (usize, &'a str)>) -> Option<usize> {
    let mut before = "";
    let mut own = lines.filter(|(_, text)| std::mem::replace(&mut before, text) != *text);
    own.nth(row).map(|(line, _)| line)
}

fn standing_still(file: &str, line: usize, time: &Field, [before, now]: [f64; 2]) -> LogError {
    let kind = LogErrorKind::TimeNotIncreasing { before, now };
    error_in(file, Some(line), Some(time.column.called()), kind)
}

/// All rows; empty lines at the end of the file are no rows.
pub(super) fn read_rows<'a>(
    file: &str,
    lines: impl Iterator<Item = (usize, &'a str)>,
    names: &[&str],
    fields: &[Field],
    style: &mut Style,
) -> Result<Rows, LogError> {
    let mut rows = Rows { columns: vec![Vec::new(); fields.len()], ..Rows::default() };
    let time = fields.iter().position(|field| field.column.quantity == Quantity::Time);
    let mut lines = lines.peekable();
    let mut before = "";
    while let Some((line, text)) = lines.next() {
        if text.is_empty() && lines.peek().is_none_or(|(_, next)| next.is_empty()) {
            continue;
        }
        if text == before {
            let first = if rows.repeated.count == 0 { line } else { rows.repeated.first };
            rows.repeated = Repeated { count: rows.repeated.count + 1, first };
            continue;
        }
        before = text;
        let row: Vec<&str> = style.fields(text).into_iter().map(unquoted).collect();
        if row.len() != names.len() {
            let kind =
                LogErrorKind::RaggedRow { expected: names.len(), found: if text.is_empty() { 0 } else { row.len() } };
            return Err(error_in(file, Some(line), None, kind));
        }
        for (field, column) in fields.iter().zip(&mut rows.columns) {
            let value = field.value(&row, style);
            let value = value.map_err(|kind| error_in(file, Some(line), Some(field.column.called()), kind))?;
            rows.blanks += usize::from(value.is_nan());
            column.push(value);
        }
        if let Some(time) = time
            && let [.., before, now] = rows.columns[time][..]
        {
            if now < before {
                return Err(standing_still(file, line, &fields[time], [before, now]));
            }
            rows.one_time.take(line, before, now);
        }
    }
    let Some(time) = time else { return Ok(rows) };
    if let Some((line, time_s)) = rows.one_time.mistake(rows.columns[time].len()) {
        return Err(standing_still(file, line, &fields[time], [time_s; 2]));
    }
    if rows.one_time.count > 0 {
        spread(&mut rows.columns[time]);
    }
    Ok(rows)
}
