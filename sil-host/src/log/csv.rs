//! From CSV text to a [`Log`]: the header decides what a column means, every field is checked.
//!
//! Lines are split by hand, not by a CSV library: the format has no field with a comma or a line end in it, and each
//! message must name the very line that an editor shows.

use super::error::{LogError, LogErrorKind, ROWS_MIN};
use super::map::{Map, MappedColumn};
use super::quantity::Quantity;
use super::{Content, Format, Log, note_gaps, source};
use crate::axis::Axis;

/// Whatever is no other format is taken for CSV, so that its messages say what was expected.
pub(super) const FORMAT: Format = Format {
    recognises: |_, _| true,
    read: |file, bytes, map| parse(file, &source::text(file, bytes)?, map).map(Content::Log),
};

/// Reads a log from text; `file` is for messages.
///
/// # Errors
/// Whatever docs/log-format.md calls an error, with file, line and column.
pub fn parse(file: &str, text: &str, map: Option<&Map>) -> Result<Log, LogError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(error_in(file, None, None, LogErrorKind::Empty));
    }
    if !text.ends_with('\n') {
        let last = text.lines().count();
        return Err(error_in(file, Some(last), None, LogErrorKind::CutOff));
    }
    let mut lines = (1..).zip(text.lines().map(str::trim));
    let comments: Vec<String> =
        text.lines().map_while(|line| line.strip_prefix('#')).map(|comment| comment.trim().to_owned()).collect();
    let mut header = lines.by_ref().skip(comments.len());
    let Some((header_line, header)) = header.next() else {
        return Err(error_in(file, None, None, LogErrorKind::Empty));
    };
    let names: Vec<&str> = header.split(',').map(unquoted).collect();
    let mut log = Log { path: file.to_owned(), comments, ..Log::default() };
    let fields = match map {
        Some(map) => mapped_fields(&names, map, &mut log),
        None => named_fields(&names, &mut log),
    };
    let fields = fields.map_err(|(column, kind)| error_in(file, Some(header_line), column, kind))?;
    read_rows(file, lines, &names, &fields, &mut log)?;
    note_gaps(&mut log);
    Ok(log)
}

fn error_in(file: &str, line: Option<usize>, column: Option<String>, kind: LogErrorKind) -> LogError {
    LogError { file: file.to_owned(), line, column, kind }
}

/// What is wrong with a header, and the column it is about.
type HeaderError = (Option<String>, LogErrorKind);

/// One field of each row that is read, and how it becomes a quantity.
struct Field {
    quantity: Quantity,
    index: usize,
    scale: f64,
    offset: f64,
}

/// The fields of a log whose header speaks for itself.
fn named_fields(names: &[&str], log: &mut Log) -> Result<Vec<Field>, HeaderError> {
    let mut fields: Vec<Field> = Vec::new();
    let mut ignored = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let Some((quantity, scale)) = Quantity::from_name(name) else {
            ignored.push(*name);
            continue;
        };
        if let Some(first) = fields.iter().find(|field| field.quantity == quantity) {
            let kind = LogErrorKind::GivenTwice { first: names[first.index].to_owned(), second: (*name).to_owned() };
            return Err((Some(quantity.name()), kind));
        }
        fields.push(Field { quantity, index, scale, offset: 0.0 });
    }
    let has = |quantity| fields.iter().any(|field| field.quantity == quantity);
    let by_axis =
        Axis::ALL.iter().any(|axis| has(Quantity::Command(*axis))) && !(0..4).any(|motor| has(Quantity::Motor(motor)));
    for quantity in required(by_axis) {
        if !has(quantity) {
            return Err(missing(quantity, names));
        }
    }
    let yaw = has(Quantity::Angle(Axis::Yaw)) || has(Quantity::Rate(Axis::Yaw));
    log.axes = [true, true, yaw];
    if by_axis && has(Quantity::Thrust) {
        // without collective the axis commands do nothing: the motors stand still
        log.active_when = Some(super::Threshold { quantity: Quantity::Thrust, above: 0.0 });
    }
    note_ignored(log, &ignored);
    Ok(fields)
}

fn required(by_axis: bool) -> Vec<Quantity> {
    let mut required = vec![
        Quantity::Time,
        Quantity::Angle(Axis::Roll),
        Quantity::Angle(Axis::Pitch),
        Quantity::Rate(Axis::Roll),
        Quantity::Rate(Axis::Pitch),
    ];
    if by_axis {
        required.extend([Axis::Roll, Axis::Pitch].map(Quantity::Command));
    } else {
        required.extend((0..4).map(Quantity::Motor));
    }
    required
}

/// The fields that a map names; the rest is ignored.
fn mapped_fields(names: &[&str], map: &Map, log: &mut Log) -> Result<Vec<Field>, HeaderError> {
    let mut fields = Vec::new();
    for mapped in &map.columns {
        fields.push(mapped_field(names, mapped, &map.name)?);
    }
    let is_ignored = |name: &&str| map.columns.iter().all(|mapped| mapped.column != **name);
    let ignored: Vec<&str> = names.iter().copied().filter(is_ignored).collect();
    log.axes = map.axes;
    log.active_when = map.active_when;
    log.motor_per_axis_command = map.motor_per_axis_command;
    log.notes.push(format!("read by the map {}", map.name));
    note_ignored(log, &ignored);
    Ok(fields)
}

fn mapped_field(names: &[&str], mapped: &MappedColumn, map: &str) -> Result<Field, HeaderError> {
    let mut indices = (0..names.len()).filter(|index| names[*index] == mapped.column);
    let Some(index) = indices.next() else {
        let kind = LogErrorKind::MissingColumn {
            reason: format!("column is missing, which the map {map} takes for {}", mapped.quantity.name()),
            present: names.join(", "),
        };
        return Err((Some(mapped.column.clone()), kind));
    };
    if indices.next().is_some() {
        let kind = LogErrorKind::GivenTwice { first: mapped.column.clone(), second: mapped.column.clone() };
        return Err((Some(mapped.column.clone()), kind));
    }
    Ok(Field { quantity: mapped.quantity, index, scale: mapped.scale, offset: mapped.offset })
}

fn missing(quantity: Quantity, names: &[&str]) -> HeaderError {
    let hint = if names.len() == 1 && names[0].contains([';', '\t']) {
        " (fields must be separated by commas)"
    } else {
        " (for other names use --map)"
    };
    let kind =
        LogErrorKind::MissingColumn { reason: format!("required column is missing{hint}"), present: names.join(", ") };
    (Some(quantity.name()), kind)
}

fn note_ignored(log: &mut Log, ignored: &[&str]) {
    if !ignored.is_empty() {
        log.notes.push(format!("columns ignored: {}", ignored.join(", ")));
    }
}

/// All rows into the columns of the log; empty lines at the end of the file are no rows.
fn read_rows<'a>(
    file: &str,
    lines: impl Iterator<Item = (usize, &'a str)>,
    names: &[&str],
    fields: &[Field],
    log: &mut Log,
) -> Result<(), LogError> {
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); fields.len()];
    let time = fields.iter().position(|f| f.quantity == Quantity::Time);
    let mut lines = lines.peekable();
    while let Some((line, text)) = lines.next() {
        if text.is_empty() && lines.peek().is_none_or(|(_, next)| next.is_empty()) {
            continue;
        }
        let row: Vec<&str> = text.split(',').map(unquoted).collect();
        if row.len() != names.len() {
            let kind =
                LogErrorKind::RaggedRow { expected: names.len(), found: if text.is_empty() { 0 } else { row.len() } };
            return Err(error_in(file, Some(line), None, kind));
        }
        for (field, column) in fields.iter().zip(&mut columns) {
            let value = value_of(row[field.index], field)
                .map_err(|kind| error_in(file, Some(line), Some(names[field.index].to_owned()), kind))?;
            column.push(value);
        }
        if let Some(time) = time
            && let [.., before, now] = columns[time][..]
            && now <= before
        {
            let name = names[fields[time].index].to_owned();
            let kind = LogErrorKind::TimeNotIncreasing { before, now };
            return Err(error_in(file, Some(line), Some(name), kind));
        }
    }
    let rows = columns.first().map_or(0, Vec::len);
    if rows < ROWS_MIN {
        return Err(error_in(file, None, None, LogErrorKind::TooFewRows(rows)));
    }
    for (field, column) in fields.iter().zip(columns) {
        log.set_column(field.quantity, column);
    }
    Ok(())
}

fn value_of(text: &str, field: &Field) -> Result<f64, LogErrorKind> {
    let raw: f64 = text.parse().map_err(|_| LogErrorKind::NotANumber(text.to_owned()))?;
    let value = field.scale * raw + field.offset;
    if !value.is_finite() {
        return Err(LogErrorKind::NotFinite(text.to_owned()));
    }
    let range = field.quantity.range();
    if !range.contains(&value) {
        return Err(LogErrorKind::OutOfRange {
            value,
            min: *range.start(),
            max: *range.end(),
            hint: hint(value, field.quantity),
        });
    }
    Ok(value)
}

/// What a value out of range most likely is.
fn hint(value: f64, quantity: Quantity) -> String {
    let is_command = matches!(quantity, Quantity::Motor(_) | Quantity::Command(_) | Quantity::Thrust);
    if is_command && (800.0..=2200.0).contains(&value) {
        return " (a pulse width in us? give scale and offset in a --map)".to_owned();
    }
    let plausible_in_other_unit = !is_command || value.abs() <= 105.0;
    match quantity.names().nth(1) {
        Some((name, _)) if plausible_in_other_unit => {
            format!(" (another unit? a column named {name} is converted)")
        }
        _ => String::new(),
    }
}

fn unquoted(field: &str) -> &str {
    let field = field.trim();
    let inner = field.strip_prefix('"').and_then(|f| f.strip_suffix('"'));
    inner.unwrap_or(field)
}
