//! ArduPilot's logs (DataFlash): binary, read through the crate `ardupilot-binlog`, or written as text.

mod ardupilot;
mod messages;
#[cfg(test)]
pub(super) mod tests;
mod text;
#[cfg(test)]
mod text_tests;

use super::error::{LogError, LogErrorKind};
use super::map::Map;
use super::messages::Messages;
use super::passage::Passage;
use super::recording::Recording;
use super::{Content, Format, has_extension};

/// Recognised by its first definition, or by its name where it is damaged.
pub(super) const FORMAT: Format = Format {
    recognises: |path, bytes| {
        bytes.starts_with(messages::DEFINITION) || has_extension(path, "bin") || text::is_text(bytes)
    },
    read: |file, bytes, map, passage| recording(file, bytes, map, passage).map(Content::Recording),
};

/// The field that numbers the instances of a message has several names, C in the estimators' messages.
const INSTANCE: [&str; 4] = ["I", "C", "Inst", "Instance"];

/// Adds what the controller has said in words, in its order.
fn add_text(messages: &mut Messages, text: &str) {
    let number = messages.texts.len();
    messages.texts.insert(format!("{number:06}"), text.to_owned());
}

/// What an ArduPilot log recorded; with a map what that names.
fn recording(file: &str, bytes: Vec<u8>, map: Option<&Map>, passage: &Passage<'_>) -> Result<Recording, LogError> {
    let fail = |kind| LogError { file: file.to_owned(), line: None, column: None, kind };
    let is_wanted = |name: &str| match map {
        Some(map) => map.names_field_of(name),
        None => ardupilot::MESSAGES.contains(&name),
    };
    let damaged = |reason| fail(LogErrorKind::Damaged { format: "DataFlash (ArduPilot)", reason });
    let messages = match text::is_text(&bytes) {
        true => text::messages(&bytes, &is_wanted, passage),
        false => messages::messages(bytes, &is_wanted, passage).map_err(damaged)?,
    };
    match map {
        Some(map) => ardupilot::head(&messages).by_map(file, &messages, map),
        None => ardupilot::recording(&messages).map_err(|why| fail(LogErrorKind::NotThisVehicle(why))),
    }
}
