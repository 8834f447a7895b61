//! The rows of a CSV as columns: every field of every line is checked, and what is wrong is named by line and column.

use super::super::error::{LogError, LogErrorKind};
use super::super::quantity::Quantity;
use super::super::style::Style;
use super::error_in;
use super::fields::Field;
use super::lines::unquoted;

/// The fields of all rows, column by column.
pub(super) struct Rows {
    pub(super) columns: Vec<Vec<f64>>,
    /// Fields without a value, which are NaN.
    pub(super) blanks: usize,
    pub(super) repeated: Repeated,
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

/// All rows; empty lines at the end of the file are no rows.
pub(super) fn read_rows<'a>(
    file: &str,
    lines: impl Iterator<Item = (usize, &'a str)>,
    names: &[&str],
    fields: &[Field],
    style: &mut Style,
) -> Result<Rows, LogError> {
    let mut rows = Rows { columns: vec![Vec::new(); fields.len()], blanks: 0, repeated: Repeated::default() };
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
        let row: Vec<&str> = text.split(style.separator).map(unquoted).collect();
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
            && now <= before
        {
            let name = fields[time].column.called();
            let kind = LogErrorKind::TimeNotIncreasing { before, now };
            return Err(error_in(file, Some(line), Some(name), kind));
        }
    }
    Ok(rows)
}
