//! PX4's logs (ULog): read through the crate `px4-ulog`, written for `sil fly --log`.

mod allocation;
mod messages;
mod outputs;
mod px4;
#[cfg(test)]
pub(super) mod tests;
mod write;

pub(super) use write::write;

use super::error::{LogError, LogErrorKind};
use super::map::Map;
use super::passage::Passage;
use super::recording::Recording;
use super::{Content, Format, has_extension};

/// Recognised by its first bytes, or by its name where it is damaged.
pub(super) const FORMAT: Format = Format {
    recognises: |path, bytes| bytes.starts_with(messages::MAGIC) || has_extension(path, "ulg"),
    read: |file, bytes, map, passage| recording(file, &bytes, map, passage).map(Content::Recording),
};

/// What a PX4 log recorded; with a map what that names.
fn recording(file: &str, bytes: &[u8], map: Option<&Map>, passage: &Passage<'_>) -> Result<Recording, LogError> {
    let fail = |column: Option<String>, kind| LogError { file: file.to_owned(), line: None, column, kind };
    let is_wanted = |name: &str| match map {
        Some(map) => map.names_field_of(name),
        None => px4::TOPICS.contains(&name),
    };
    let damaged = |reason| fail(None, LogErrorKind::Damaged { format: "ULog (PX4)", reason });
    let messages = messages::messages(bytes, &is_wanted, passage).map_err(damaged)?;
    match map {
        Some(map) => px4::head(&messages).by_map(file, &messages, map),
        None => px4::recording(&messages).map_err(|why| fail(None, LogErrorKind::NotThisVehicle(why))),
    }
}
