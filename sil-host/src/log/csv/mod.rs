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
use self::lines::{Lines, are_names, unquoted};
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
    let names: Vec<&str> = style.fields(header).into_iter().map(unquoted).collect();
    if !are_names(names.iter().copied()) {
        return Err(error_in(file, Some(header_line), None, LogErrorKind::NoNames));
    }
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
    log.notes.extend(rows.one_time.notes());
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

    const HEADER: &str = "time_s,roll_rad,pitch_rad,p_rad_s,q_rad_s,motor1,motor2,motor3,motor4";

    /// So many rows; their times, then numbers that no row repeats.
    fn rows(count: usize, time_s: impl Fn(usize) -> f64) -> String {
        let row = |row: usize| format!("{},{},0,0,0,0.5,0.5,0.5,0.5\n", time_s(row), 1e-3 * row as f64);
        (0..count).map(row).collect()
    }

    #[test]
    fn fields_between_blanks_are_fields() {
        let table = format!("{HEADER}\n{}", rows(120, |row| 0.01 * row as f64));
        let blanks = parse("log.csv", &table.replace(',', "  "), None).unwrap();
        assert_eq!(blanks, parse("log.csv", &table, None).unwrap());
    }

    #[test]
    fn a_table_without_names_is_told_from_one_of_other_names() {
        for text in
            [rows(120, |row| 0.01 * row as f64), "1 2.5 -3e4\n1 2 3\n".to_owned(), "4000,mag,0.2,-0.1\n".repeat(120)]
        {
            let error = parse("log.csv", &text, None).unwrap_err();
            assert!(matches!(error.kind, LogErrorKind::NoNames) && error.line == Some(1), "{error}");
        }
    }

    /// Batches of four rows that are stamped when they arrive, every 0.01 s.
    #[test]
    fn rows_of_one_time_are_spread_up_to_the_next() {
        let batches = format!("{HEADER}\n{}", rows(200, |row| (row / 4) as f64 * 0.01));
        let log = parse("log.csv", &batches, None).unwrap();
        for (row, time_s) in log.time_s.iter().enumerate() {
            assert!((time_s - 0.0025 * row as f64).abs() < 1e-12, "{row}: {time_s}");
        }
        assert!(log.notes.iter().any(|note| note.starts_with("150 rows have the time of the row before")));
        // a few are mistakes, and many in a run a clock that stands still
        for time_s in [|row| (row - usize::from(row == 50)) as f64, |row: usize| row.clamp(60, 140) as f64] {
            let error = parse("log.csv", &format!("{HEADER}\n{}", rows(200, time_s)), None).unwrap_err();
            assert!(matches!(error.kind, LogErrorKind::TimeNotIncreasing { .. }), "{error}");
        }
    }

    #[test]
    fn what_is_given_twice_matters_to_whom_has_the_other_columns() {
        let twice = format!("{HEADER},p_deg_s\n{}", rows(120, |row| row as f64).replace(".5\n", ".5,1\n"));
        let error = parse("log.csv", &twice, None).unwrap_err();
        assert!(matches!(error.kind, LogErrorKind::GivenTwice { .. }), "{error}");
        let error = parse("log.csv", "t,roll_ref_rad,roll_ref_deg\n0,1,1\n", None).unwrap_err();
        assert!(matches!(error.kind, LogErrorKind::MissingColumn { .. }), "{error}");
    }

    #[test]
    fn a_fifth_motor_is_another_vehicles() {
        let six = format!("{HEADER},motor5,motor6\n{}", rows(120, |row| row as f64).replace(".5\n", ".5,0.5,0.5\n"));
        let error = parse("log.csv", &six, None).unwrap_err().to_string();
        assert!(error.contains("`motor5`: only quadrotors are simulated"), "{error}");
    }
}
