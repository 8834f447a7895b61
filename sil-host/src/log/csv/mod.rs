//! From CSV text to a [`Log`]: the header decides what a column means, every field is checked.
//!
//! What is certain is read, with a note where something was left out: any of comma, semicolon and tab between fields,
//! decimal commas where the comma does not separate fields, any line end, repeated lines, a last line that may be cut
//! off. Blank fields are missing values, as logs have them that were merged from several rates: such a log is brought
//! to rows as a flight controller's is (`recording.rs`).
//!
//! Lines are split by hand, not by a CSV library: the format has no field with a separator or a line end in it, and
//! each message must name the very line that an editor shows.

mod fields;

use self::fields::{Field, mapped_fields, named_fields, required};
use super::error::{LogError, LogErrorKind, ROWS_MIN};
use super::map::Map;
use super::mapped_column::Made;
use super::messages::Table;
use super::passage::Passage;
use super::quantity::Quantity;
use super::rate_of_change::rate_of_change;
use super::recording::{Stream, StreamColumn};
use super::style::Style;
use super::{Content, Format, Log, note_gaps, outside, source, time_base};

/// Whatever is no other format is taken for CSV, so that its messages say what was expected.
pub(super) const FORMAT: Format = Format {
    recognises: |_, _| true,
    read: |file, bytes, map, passage| {
        let text = source::text(file, bytes)?;
        parse_observed(file, &text, map, passage).map(|log| Content::Log(Box::new(log)))
    },
};

/// Reads a log from text; `file` is for messages.
///
/// # Errors
/// Whatever docs/log-format.md calls an error, with file, line and column.
pub fn parse(file: &str, text: &str, map: Option<&Map>) -> Result<Log, LogError> {
    parse_observed(file, text, map, &Passage::through(text.len(), &|_, _| ()))
}

fn parse_observed(file: &str, text: &str, map: Option<&Map>, passage: &Passage<'_>) -> Result<Log, LogError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(error_in(file, None, None, LogErrorKind::Empty));
    }
    // without any line feed, carriage returns end lines
    let line_end = if text.contains('\n') { '\n' } else { '\r' };
    let (text, cut) = whole_lines(text, line_end);
    let mut lines = (1..).zip(text.split_terminator(line_end).map(|line| line.trim_matches([' ', '\r'])));
    let is_comment = |line: &&str| line.starts_with('#');
    let comments: Vec<String> =
        lines.clone().map(|(_, line)| line).take_while(is_comment).map(|line| line[1..].trim().to_owned()).collect();
    let mut header = lines.by_ref().skip(comments.len());
    let Some((header_line, header)) = header.next() else {
        return Err(error_in(file, None, None, LogErrorKind::Empty));
    };
    let mut style = Style::of(header);
    let names: Vec<&str> = header.split(style.separator).map(unquoted).collect();
    let mut log = Log { path: file.to_owned(), comments, ..Log::default() };
    let fields = match map {
        Some(map) => mapped_fields(&names, map, &mut log),
        None => named_fields(&names, &mut log),
    };
    let fields = fields.map_err(|(column, kind)| error_in(file, Some(header_line), column, kind))?;
    let turn_deg = map.map_or(0.0, |map| map.frame_turn_deg);
    let mut read_bytes = 0;
    let observed = lines.clone().inspect(|(_, line)| {
        read_bytes += line.len() + 1;
        passage.is_at(read_bytes);
    });
    let rows = read_rows(file, observed, &names, &fields, &mut style)?;
    if let Some(cut) = cut {
        log.notes.push(format!("line {cut} left out: it has no line end and may be cut off"));
    }
    log.notes.extend(rows.repeated.notes());
    if rows.blanks > 0 {
        if map.is_none()
            && let Some((name, kind)) = all_blank(&names, &fields, &rows)
        {
            return Err(error_in(file, Some(header_line), Some(name), kind));
        }
        log.notes.push(format!("{} blank fields are missing values", rows.blanks));
    }
    let has_blanks = rows.blanks > 0;
    let mut stream = stream_of(&names, &fields, rows);
    outside::settle(&mut stream, &mut log.notes);
    if let Some((row, column)) = outside::first(&stream) {
        let kind = outside::out_of_range(column.quantity, column.value[row]);
        return Err(error_in(file, line_of(row, lines), Some(column.source.clone()), kind));
    }
    if has_blanks || time_base::has_repeats(&stream) {
        return time_base::log_of_rows(file, stream, log)?.turned(turn_deg);
    }
    log.set_column(Quantity::Time, stream.time_s);
    for column in stream.columns {
        log.set_column(column.quantity, column.value);
    }
    if log.rows() < ROWS_MIN {
        return Err(error_in(file, None, None, LogErrorKind::TooFewRows(log.rows())));
    }
    note_gaps(&mut log);
    log.turned(turn_deg)
}

/// Every column of numbers under its own name, a field that is no number as NaN; and the names of the columns that have
/// fields which are neither numbers nor blank.
///
/// # Errors
/// There is no line.
pub(super) fn table(file: &str, text: &str) -> Result<(Table, Vec<String>), LogError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let line_end = if text.contains('\n') { '\n' } else { '\r' };
    let (text, _) = whole_lines(text, line_end);
    let mut lines = text.split_terminator(line_end).map(|line| line.trim_matches([' ', '\r']));
    let header = lines.find(|line| !line.starts_with('#') && !line.is_empty());
    let header = header.ok_or_else(|| error_in(file, None, None, LogErrorKind::Empty))?;
    let mut style = Style::of(header);
    let names: Vec<String> = header.split(style.separator).map(|name| unquoted(name).to_owned()).collect();
    let mut has_words = vec![false; names.len()];
    let mut table = Table::with_fields(names.iter().cloned());
    for line in lines.filter(|line| !line.is_empty()) {
        let fields = line.split(style.separator).map(unquoted).enumerate();
        let numbers: Vec<f64> = fields
            .map(|(place, field)| {
                let number = style.number(field);
                let is_there = number.as_ref().is_ok_and(|number| number.is_finite());
                if let (false, false, Some(has_words)) = (is_there, field.is_empty(), has_words.get_mut(place)) {
                    *has_words = true;
                }
                number.unwrap_or(f64::NAN)
            })
            .collect();
        table.push(numbers);
    }
    let with_words = names.into_iter().zip(has_words).filter(|(_, has_words)| *has_words).map(|(name, _)| name);
    Ok((table, with_words.collect()))
}

/// The text up to its last line end, and the number of the line that has none; the whole text if it is one line.
fn whole_lines(text: &str, line_end: char) -> (&str, Option<usize>) {
    match text.rfind(line_end) {
        Some(last) if !text[last + 1..].trim().is_empty() => {
            let whole = &text[..=last];
            (whole, Some(1 + whole.matches(line_end).count()))
        }
        _ => (text, None),
    }
}

/// A required column without any value.
fn all_blank(names: &[&str], fields: &[Field], rows: &Rows) -> Option<(String, LogErrorKind)> {
    let by_axis = fields.iter().all(|field| !matches!(field.quantity, Quantity::Motor(_)));
    let mut required = required(by_axis).into_iter();
    let is_blank = |quantity: &Quantity| {
        let column = fields.iter().position(|field| field.quantity == *quantity).map(|place| &rows.columns[place]);
        column.is_some_and(|column| column.iter().all(|value| value.is_nan()))
    };
    let quantity = required.find(is_blank)?;
    let reason = "required column has no value in any row".to_owned();
    Some((quantity.name(), LogErrorKind::MissingColumn { reason, present: names.join(", ") }))
}

/// The rows as readings at their times.
fn stream_of(names: &[&str], fields: &[Field], rows: Rows) -> Stream {
    let (mut stream, mut columns) = (Stream::at("rows", Vec::new()), Vec::new());
    for (field, value) in fields.iter().zip(rows.columns) {
        match field.quantity {
            Quantity::Time => stream.time_s = value,
            quantity => columns.push(StreamColumn { quantity, source: field.called(names), value }),
        }
    }
    Stream { columns, ..stream }
}

fn error_in(file: &str, line: Option<usize>, column: Option<String>, kind: LogErrorKind) -> LogError {
    LogError { file: file.to_owned(), line, column, kind }
}

/// The fields of all rows, column by column.
struct Rows {
    columns: Vec<Vec<f64>>,
    /// Fields without a value, which are NaN.
    blanks: usize,
    repeated: Repeated,
}

/// Lines that say the same as the one before, number of the first.
#[derive(Default)]
struct Repeated {
    count: usize,
    first: usize,
}

impl Repeated {
    fn notes(&self) -> Option<String> {
        (self.count > 0).then(|| format!("{} lines repeat the one before, the first line {}", self.count, self.first))
    }
}

/// The number of the line that a row was read from: lines that repeat the one before are no rows.
fn line_of<'a>(row: usize, lines: impl Iterator<Item = (usize, &'a str)>) -> Option<usize> {
    let mut before = "";
    let mut own = lines.filter(|(_, text)| std::mem::replace(&mut before, text) != *text);
    own.nth(row).map(|(line, _)| line)
}

/// All rows; empty lines at the end of the file are no rows.
fn read_rows<'a>(
    file: &str,
    lines: impl Iterator<Item = (usize, &'a str)>,
    names: &[&str],
    fields: &[Field],
    style: &mut Style,
) -> Result<Rows, LogError> {
    let mut rows = Rows { columns: vec![Vec::new(); fields.len()], blanks: 0, repeated: Repeated::default() };
    let time = fields.iter().position(|f| f.quantity == Quantity::Time);
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
            let value = value.map_err(|kind| error_in(file, Some(line), Some(field.called(names)), kind))?;
            rows.blanks += usize::from(value.is_nan());
            column.push(value);
        }
        if let Some(time) = time
            && let [.., before, now] = rows.columns[time][..]
            && now <= before
        {
            let name = fields[time].called(names);
            let kind = LogErrorKind::TimeNotIncreasing { before, now };
            return Err(error_in(file, Some(line), Some(name), kind));
        }
    }
    for place in (0..fields.len()).filter(|place| fields[*place].made == Made::RateOf) {
        rows.columns[place] = time.map_or(Vec::new(), |time| rate_of_change(&rows.columns[time], &rows.columns[place]));
    }
    Ok(rows)
}

fn unquoted(field: &str) -> &str {
    let field = field.trim();
    let inner = field.strip_prefix('"').and_then(|f| f.strip_suffix('"'));
    inner.unwrap_or(field)
}
