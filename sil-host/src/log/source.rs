//! From a file to bytes and to text: gzip is undone, by content.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::error::{LogError, LogErrorKind};
use super::other_files;

/// An hour of a 1 kHz log is about 0.5 GB of text; more than this is no log but a gzip bomb or a mistake.
const TEXT_BYTES_MAX: u64 = 1 << 30;

const GZIP_MAGIC: &[u8] = &[0x1f, 0x8b];

/// The bytes of a file, decompressed if they are gzip.
///
/// # Errors
/// The file can't be read, holds too much, or its gzip stream is damaged or cut.
pub(super) fn load(path: &Path) -> Result<Vec<u8>, LogError> {
    let mut opened = File::open(path).map_err(|e| failure(path, LogErrorKind::Unreadable(e)))?;
    load_from(path, &mut opened)
}

/// The same of a stream of this name.
///
/// # Errors
/// As [`load`].
pub(super) fn load_from(name: &Path, from: &mut impl Read) -> Result<Vec<u8>, LogError> {
    let fail = |kind| failure(name, kind);
    let mut bytes = Vec::new();
    read_limited(from, &mut bytes).map_err(|e| fail(LogErrorKind::Unreadable(e)))?;
    if bytes.starts_with(GZIP_MAGIC) {
        bytes = decompress(&bytes).map_err(&fail)?;
    }
    if bytes.len() as u64 > TEXT_BYTES_MAX {
        return Err(fail(LogErrorKind::TooLarge(TEXT_BYTES_MAX)));
    }
    Ok(bytes)
}

/// A file as text.
///
/// # Errors
/// As [`load`] and [`text`].
pub(crate) fn text_of(path: &Path) -> Result<String, LogError> {
    text(&path.display().to_string(), load(path)?)
}

fn failure(name: &Path, kind: LogErrorKind) -> LogError {
    LogError { file: name.display().to_string(), line: None, column: None, kind }
}

/// A file's bytes as text: UTF-8, or UTF-16 behind its mark, as some programs of Windows write tables.
///
/// # Errors
/// They are neither, or what is known to be no log; the message has the line.
pub(super) fn text(file: &str, bytes: Vec<u8>) -> Result<String, LogError> {
    let fail = |line, kind| LogError { file: file.to_owned(), line, column: None, kind };
    let unit: Option<fn([u8; 2]) -> u16> = match bytes.get(..2) {
        Some([0xff, 0xfe]) => Some(u16::from_le_bytes),
        Some([0xfe, 0xff]) => Some(u16::from_be_bytes),
        _ => None,
    };
    if let Some(unit) = unit {
        let units = bytes[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        return char::decode_utf16(units).collect::<Result<_, _>>().map_err(|_| fail(None, LogErrorKind::NotText));
    }
    if let Some(what) = other_files::what_it_is(&bytes) {
        return Err(fail(None, LogErrorKind::OtherFile(what)));
    }
    String::from_utf8(bytes).map_err(|e| {
        let valid = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        fail(Some(line), LogErrorKind::NotText)
    })
}

fn decompress(stored: &[u8]) -> Result<Vec<u8>, LogErrorKind> {
    let mut bytes = Vec::new();
    match read_limited(&mut MultiGzDecoder::new(stored), &mut bytes) {
        Ok(()) => Ok(bytes),
        Err(e) => Err(LogErrorKind::Gzip { reason: e.to_string(), bytes: bytes.len() }),
    }
}

/// Reads to the end, or to one byte more than may be.
fn read_limited(from: &mut impl Read, into: &mut Vec<u8>) -> io::Result<()> {
    from.take(TEXT_BYTES_MAX + 1).read_to_end(into)?;
    Ok(())
}
