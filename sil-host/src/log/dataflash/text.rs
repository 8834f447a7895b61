//! DataFlash messages written as text: the `.log` that boards printed until 2014 and that Mission Planner makes of a
//! binary log, and what pymavlink's mavlogdump prints of one. Numbers stand there in the units of the binary log's
//! messages, already scaled.

use std::collections::BTreeMap;

use super::super::messages::{Messages, Table};
use super::super::passage::Passage;
use super::{INSTANCE, add_text};

/// So far into the file the first definition of a message stands, bytes: before it there are a board's greeting only.
const HEAD_BYTES: usize = 4096;

/// The labels of each kind of message, as the definitions before it say them.
type Definitions<'t> = BTreeMap<&'t str, Vec<&'t str>>;

/// A message: its kind, and its fields with their labels. None of these where their number is not that of the labels.
struct Line<'t> {
    kind: &'t str,
    fields: Vec<(&'t str, &'t str)>,
}

/// Whether a file begins as such a text does: a definition stands on one of its first lines.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD_BYTES)]);
    head.lines().any(|line| line.trim_start().starts_with("FMT,") || line.contains(": FMT {"))
}

/// The wanted messages of such a text, and its parameters and texts, as [`super::messages::messages`] has them.
pub(super) fn messages(bytes: &[u8], is_wanted: &dyn Fn(&str) -> bool, passage: &Passage<'_>) -> Messages {
    let text = String::from_utf8_lossy(bytes);
    let mut messages = Messages::default();
    let mut definitions = Definitions::new();
    let mut left_out = 0;
    let mut read_bytes = 0;
    for line in text.split_inclusive('\n') {
        read_bytes += line.len();
        passage.is_at(read_bytes);
        let is_cut = !line.ends_with('\n') && !line.trim().is_empty();
        let line = line.trim();
        match printed(line).or_else(|| separated(line, &mut definitions)) {
            // the digits that a number has lost do not show
            Some(_) if is_cut => left_out += 1,
            Some(line) => left_out += usize::from(!take(&mut messages, &line, is_wanted)),
            // an old board greets with its firmware, before any message
            None if line.starts_with("Ardu") || line.starts_with("APM:") => add_text(&mut messages, line),
            None => {}
        }
    }
    if left_out > 0 {
        messages.notes.push(format!("{left_out} lines are damaged or cut off, and left out"));
    }
    messages
}

/// A line of mavlogdump: the date, the kind, and `label : value` between braces.
fn printed(line: &str) -> Option<Line<'_>> {
    let (head, fields) = line.strip_suffix('}')?.split_once(" {")?;
    let (_, kind) = head.rsplit_once(": ")?;
    // a comma in a text divides it, and what stands behind has no label
    let fields = fields.split(", ").filter_map(|field| field.split_once(" : ")).collect();
    Some(Line { kind, fields })
}

/// A line of fields between commas, whose labels its definition has said; a definition is no message.
fn separated<'t>(line: &'t str, definitions: &mut Definitions<'t>) -> Option<Line<'t>> {
    let (kind, rest) = line.split_once(',')?;
    if kind == "FMT" {
        let said: Vec<&str> = rest.split(',').map(str::trim).collect();
        if let [_number, _length, name, _format, labels @ ..] = said.as_slice() {
            definitions.insert(name, labels.to_vec());
        }
        return None;
    }
    let labels = definitions.get(kind)?;
    // the last field of a text has commas of its own
    let values: Vec<&str> = rest.splitn(labels.len(), ',').map(str::trim).collect();
    let is_whole = values.len() == labels.len();
    let fields = if is_whole { labels.iter().copied().zip(values).collect() } else { Vec::new() };
    Some(Line { kind, fields })
}

/// Takes what is wanted of a message; false where it is damaged.
fn take(messages: &mut Messages, line: &Line<'_>, is_wanted: &dyn Fn(&str) -> bool) -> bool {
    let field = |label: &str| line.fields.iter().find(|(own, _)| *own == label).map(|(_, value)| *value);
    let number = |label: &str| field(label)?.parse::<f64>().ok();
    match line.kind {
        "PARM" => {
            let said = field("Name").zip(number("Value"));
            said.map(|(name, value)| messages.parameters.insert(name.to_owned(), value)).is_some()
        }
        "MSG" => field("Message").map(|text| add_text(messages, text)).is_some(),
        kind if is_wanted(kind) && line.fields.is_empty() => false,
        kind if is_wanted(kind) => {
            let instance = INSTANCE.into_iter().find_map(number).filter(|instance| *instance > 0.0);
            let name = instance.map_or_else(|| kind.to_owned(), |instance| format!("{kind}.{instance}"));
            let are_numbers = line.fields.iter().filter(|(_, value)| value.parse::<f64>().is_ok());
            let labels = are_numbers.map(|(label, _)| (*label).to_owned());
            let table = messages.tables.entry(name).or_insert_with(|| Table::with_fields(labels));
            let numbers: Option<Vec<f64>> = table.fields().map(number).collect();
            numbers.map(|numbers| table.push(numbers)).is_some()
        }
        _ => true,
    }
}
