//! From a file to text: gzip by content, and a clear word about formats that are not text.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::error::{LogError, LogErrorKind};

/// An hour of a 1 kHz log is about 0.5 GB of text; more than this is no log but a gzip bomb or a mistake.
const TEXT_BYTES_MAX: u64 = 1 << 30;

const GZIP_MAGIC: &[u8] = &[0x1f, 0x8b];
/// PX4 user guide, "ULog file format", file header.
const ULOG_MAGIC: &[u8] = b"ULog\x01\x12\x35";
/// ArduPilot's AP_Logger: two head bytes, then message 128, FMT, which describes itself first.
const DATAFLASH_MAGIC: &[u8] = &[0xa3, 0x95, 0x80];

/// The text of a CSV file, decompressed if it is gzip by content.
///
/// # Errors
/// The file can't be read, its gzip stream is damaged or cut, it is a binary log, or it is not UTF-8.
pub(super) fn load_text(path: &Path) -> Result<String, LogError> {
    let file = path.display().to_string();
    let fail = |kind| LogError { file: file.clone(), line: None, column: None, kind };
    let mut opened = File::open(path).map_err(|e| fail(LogErrorKind::Unreadable(e)))?;
    let mut bytes = Vec::new();
    read_limited(&mut opened, &mut bytes).map_err(|e| fail(LogErrorKind::Unreadable(e)))?;
    if bytes.starts_with(GZIP_MAGIC) {
        bytes = decompress(&bytes).map_err(&fail)?;
    }
    if bytes.len() as u64 > TEXT_BYTES_MAX {
        return Err(fail(LogErrorKind::TooLarge(TEXT_BYTES_MAX)));
    }
    if bytes.starts_with(ULOG_MAGIC) || has_extension(path, "ulg") {
        return Err(fail(LogErrorKind::NotReadYet("ULog (PX4)")));
    }
    if bytes.starts_with(DATAFLASH_MAGIC) || has_extension(path, "bin") {
        return Err(fail(LogErrorKind::NotReadYet("DataFlash (ArduPilot)")));
    }
    let text = String::from_utf8(bytes).map_err(|e| {
        let valid = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        LogError { line: Some(line), ..fail(LogErrorKind::NotText) }
    })?;
    Ok(text)
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

fn has_extension(path: &Path, extension: &str) -> bool {
    let name = path.to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.ends_with(&format!(".{extension}"))
}
