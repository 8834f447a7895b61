//! Blackbox logs of Betaflight, Cleanflight and INAV, read through the crate `blackbox-log`.

mod betaflight;
mod clock;
mod messages;
#[cfg(test)]
pub(super) mod tests;

use super::error::{LogError, LogErrorKind};
use super::map::Map;
use super::passage::Passage;
use super::recording::Recording;
use super::{Content, Format, has_extension};

/// Recognised by its first line, or by its name where it is damaged.
pub(super) const FORMAT: Format = Format {
    recognises: |path, bytes| {
        bytes.starts_with(messages::FIRST_LINE) || has_extension(path, "bbl") || has_extension(path, "bfl")
    },
    read: |file, bytes, map, passage| recording(file, &bytes, map, passage).map(Content::Recording),
};

/// What a Blackbox log recorded; with a map what that names, as fields of `main`.
fn recording(file: &str, bytes: &[u8], map: Option<&Map>, passage: &Passage<'_>) -> Result<Recording, LogError> {
    let fail = |kind| LogError { file: file.to_owned(), line: None, column: None, kind };
    let damaged = |reason| fail(LogErrorKind::Damaged { format: "Blackbox (Betaflight, INAV)", reason });
    let messages = messages::messages(bytes, passage).map_err(damaged)?;
    match map {
        Some(map) => betaflight::head(&messages).by_map(file, &messages, map),
        None => betaflight::recording(&messages).map_err(|why| fail(LogErrorKind::NotThisVehicle(why))),
    }
}
