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
mod lines;
mod rows;
mod table;

use self::fields::{Field, mapped_fields, named_fields, required};
use self::lines::{Lines, unquoted};
use self::rows::{Rows, line_of, read_rows};
pub(super) use self::table::table;
use super::error::{LogError, LogErrorKind, ROWS_MIN};
use super::map::Map;
use super::passage::Passage;
use super::quantity::Quantity;
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
    let empty = || error_in(file, None, None, LogErrorKind::Empty);
    let text = Lines::of(text).ok_or_else(empty)?;
    let mut lines = text.numbered();
    let is_comment = |line: &&str| line.starts_with('#');
    let comments: Vec<String> =
        lines.clone().map(|(_, line)| line).take_while(is_comment).map(|line| line[1..].trim().to_owned()).collect();
    let mut header = lines.by_ref().skip(comments.len());
    let (header_line, header) = header.next().ok_or_else(empty)?;
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
    if let Some(cut) = text.cut {
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
    let mut stream = stream_of(&fields, rows);
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

/// A required column without any value.
fn all_blank(names: &[&str], fields: &[Field], rows: &Rows) -> Option<(String, LogErrorKind)> {
    let by_axis = fields.iter().all(|field| !matches!(field.column.quantity, Quantity::Motor(_)));
    let mut required = required(by_axis).into_iter();
    let is_blank = |quantity: &Quantity| {
        let of_it = fields.iter().zip(&rows.columns).find(|(field, _)| field.column.quantity == *quantity);
        of_it.is_some_and(|(_, values)| values.iter().all(|value| value.is_nan()))
    };
    let quantity = required.find(is_blank)?;
    let reason = "required column has no value in any row".to_owned();
    Some((quantity.name(), LogErrorKind::MissingColumn { reason, present: names.join(", ") }))
}

/// The rows as readings at their times.
fn stream_of(fields: &[Field], rows: Rows) -> Stream {
    let all = fields.iter().map(|field| &field.column).zip(rows.columns);
    let (times, others): (Vec<_>, Vec<_>) = all.partition(|(column, _)| column.quantity == Quantity::Time);
    let mut stream = Stream::at("rows", times.into_iter().flat_map(|(_, time_s)| time_s).collect());
    for (column, values) in others {
        let value = column.over_time(&stream.time_s, values);
        stream.columns.push(StreamColumn { quantity: column.quantity, source: column.called(), value });
    }
    stream
}

fn error_in(file: &str, line: Option<usize>, column: Option<String>, kind: LogErrorKind) -> LogError {
    LogError { file: file.to_owned(), line, column, kind }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_every_column_of_a_quantity_and_says_what_it_makes_of_them() {
        let map = "description = \"\"\nframe = \"FRD\"\naxes = [\"roll\"]\n[quantities]\ntime_s = { column = \"t\" }\n\
                   roll_rad = { euler_of = [\"qw\", \"qx\", \"qy\", \"qz\"] }\n\
                   roll_cmd = { columns = { left = 0.5, right = -1.5 } }\n";
        let map = Map::parse("m", map).unwrap();
        for (row, said) in [
            ("0,1,x,0,0,0.5,0.5", "`qw, qx, qy, qz`: expected a number, found `x`"),
            ("0,1,0,0,inf,0.5,0.5", "`qw, qx, qy, qz`: expected a finite number, found `inf`"),
            ("0,1,0,0,0,0.5,y", "`left + right`: expected a number, found `y`"),
            ("0,1,0,0,0,1e308,-1.7e308", "`left + right`: expected a finite number, found `1e308 + -1.7e308`"),
        ] {
            let text = format!("t,qw,qx,qy,qz,left,right\n{row}\n");
            let error = parse("log.csv", &text, Some(&map)).unwrap_err().to_string();
            assert!(error.starts_with("log.csv:2: ") && error.contains(said), "{error}");
        }
    }
}
