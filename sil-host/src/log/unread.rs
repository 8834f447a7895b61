//! Formats that are recognised, so that the message says what to do, and not read yet.

use std::path::Path;

use super::{Format, Log, LogError, LogErrorKind};

/// PX4's logs; PX4 user guide, "ULog file format", file header.
pub(super) const ULOG: Format = Format {
    recognises: |path, bytes| bytes.starts_with(b"ULog\x01\x12\x35") || has_extension(path, "ulg"),
    read: |file, _, _| not_read_yet(file, "ULog (PX4)"),
};

/// ArduPilot's logs; AP_Logger: two head bytes, then message 128, FMT, which describes itself first.
pub(super) const DATAFLASH: Format = Format {
    recognises: |path, bytes| bytes.starts_with(&[0xa3, 0x95, 0x80]) || has_extension(path, "bin"),
    read: |file, _, _| not_read_yet(file, "DataFlash (ArduPilot)"),
};

fn not_read_yet(file: &str, format: &'static str) -> Result<Log, LogError> {
    Err(LogError { file: file.to_owned(), line: None, column: None, kind: LogErrorKind::NotReadYet(format) })
}

fn has_extension(path: &Path, extension: &str) -> bool {
    let name = path.to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.ends_with(&format!(".{extension}"))
}
