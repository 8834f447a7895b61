//! The messages of a DataFlash file, by the crate `ardupilot-binlog`.
//!
//! The crate (0.2.0) finds the next message behind damaged bytes by itself. It takes for granted that a definition says
//! a length of at least its own head, stops in silence after many damages, and does not say how many bytes it left out;
//! definitions are therefore checked here before, and what it read is held against the file's length.

use ardupilot_binlog::{Entry, Reader};

use super::super::messages::{Messages, Table};
use super::super::passage::Passage;
use super::{INSTANCE, add_text};

/// The head of a definition: two bytes before each message, and the number of the message `FMT`.
pub(super) const DEFINITION: &[u8] = &[0xa3, 0x95, 0x80];
/// Length of a definition, head included.
const DEFINITION_BYTES: usize = 89;
/// Length of every message's head.
const HEAD_BYTES: u8 = 3;

/// PX4's first log has ArduPilot's frames, and one time before each round of messages in place of one in each.
const OF_PX4: &str = "it is PX4's log of before 2017 (sdlog2), which is not read: PX4's sdlog2_dump.py makes a CSV of \
                      it, `sil map` a map of that";

/// The wanted messages of a file, and its parameters and texts; instance 1 of a message that has several is `name.1`.
///
/// # Errors
/// In words: it is no DataFlash file.
pub(super) fn messages(
    mut bytes: Vec<u8>,
    is_wanted: &dyn Fn(&str) -> bool,
    passage: &Passage<'_>,
) -> Result<Messages, String> {
    if !bytes.starts_with(DEFINITION) {
        return Err("it does not begin with a definition of messages".to_owned());
    }
    let spoiled = spoil_bad_definitions(&mut bytes);
    let mut messages = Messages::default();
    let mut read_bytes = 0;
    let mut reader = Reader::new(bytes.as_slice());
    while let Some(entry) = reader.next() {
        let entry = entry.map_err(|error| error.to_string())?;
        read_bytes += reader.formats().get(&entry.msg_type).map_or(0, |format| usize::from(format.msg_len));
        passage.is_at(read_bytes);
        take(&mut messages, &entry, is_wanted);
    }
    let mut definitions = reader.formats().values();
    if definitions.any(|format| format.name == "TIME" && format.labels.iter().any(|label| label == "StartTime")) {
        return Err(OF_PX4.to_owned());
    }
    let left_out = bytes.len().saturating_sub(read_bytes);
    if left_out > 0 {
        let share_pct = 100.0 * left_out as f64 / bytes.len() as f64;
        let of = bytes.len();
        messages
            .notes
            .push(format!("{left_out} of {of} bytes ({share_pct:.1} %) are damaged or cut off, and left out"));
    }
    if spoiled > 0 {
        messages.notes.push(format!("{spoiled} definitions of messages are damaged"));
    }
    Ok(messages)
}

/// Overwrites the heads of definitions of messages that would be shorter than their own head; how many. From the end
/// on: where damaged definitions overlap, the head that is overwritten may be the length that an earlier one says.
fn spoil_bad_definitions(bytes: &mut [u8]) -> usize {
    let mut spoiled = 0;
    for at in (0..bytes.len().saturating_sub(DEFINITION_BYTES - 1)).rev() {
        if bytes[at..].starts_with(DEFINITION) && bytes[at + DEFINITION.len() + 1] < HEAD_BYTES {
            bytes[at] = 0;
            spoiled += 1;
        }
    }
    spoiled
}

fn take(messages: &mut Messages, entry: &Entry, is_wanted: &dyn Fn(&str) -> bool) {
    match entry.name.as_str() {
        "PARM" => {
            if let (Some(name), Some(value)) = (entry.get_str("Name"), entry.get_f64("Value")) {
                messages.parameters.insert(name.to_owned(), value);
            }
        }
        "MSG" => {
            if let Some(text) = entry.get_str("Message") {
                add_text(messages, text);
            }
        }
        name if is_wanted(name) => {
            let instance = INSTANCE.into_iter().find_map(|label| entry.get_i64(label));
            let name = match instance {
                Some(instance) if instance > 0 => format!("{name}.{instance}"),
                _ => name.to_owned(),
            };
            let fields =
                || entry.fields().filter(|(_, value)| value.as_f64().is_some()).map(|(label, _)| label.to_owned());
            let table = messages.tables.entry(name).or_insert_with(|| Table::with_fields(fields()));
            let numbers: Vec<f64> = table.fields().map(|label| entry.get_f64(label).unwrap_or(f64::NAN)).collect();
            table.push(numbers);
        }
        _ => {}
    }
}
