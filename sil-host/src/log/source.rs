//! From a file to bytes and to text: gzip is undone, by content.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::error::{LogError, LogErrorKind};
use super::other_files;
use super::passage::{Passage, ReadObserver, UNOBSERVED};

/// An hour of a 1 kHz log is about 0.5 GB of text; more than this is no log but a gzip bomb or a mistake.
const TEXT_BYTES_MAX: u64 = 1 << 30;

const GZIP_MAGIC: &[u8] = &[0x1f, 0x8b];

/// The bytes of a file, decompressed if they are gzip.
///
/// # Errors
/// The file can't be read, holds too much, or its gzip stream is damaged or cut.
pub(super) fn load(path: &Path) -> Result<Vec<u8>, LogError> {
    load_observed(path, UNOBSERVED)
}

/// The same, and says on the way how much of the stored bytes is decompressed.
///
/// # Errors
/// As [`load`].
pub(super) fn load_observed(path: &Path, observer: ReadObserver<'_>) -> Result<Vec<u8>, LogError> {
    let mut opened = File::open(path).map_err(|e| failure(path, LogErrorKind::Unreadable(e)))?;
    loaded(path, &mut opened, observer)
}

/// The same of a stream of this name.
///
/// # Errors
/// As [`load`].
pub(super) fn load_from(name: &Path, from: &mut impl Read) -> Result<Vec<u8>, LogError> {
    loaded(name, from, UNOBSERVED)
}

fn loaded(name: &Path, from: &mut impl Read, observer: ReadObserver<'_>) -> Result<Vec<u8>, LogError> {
    let fail = |kind| failure(name, kind);
    let mut bytes = Vec::new();
    read_limited(from, &mut bytes).map_err(|e| fail(LogErrorKind::Unreadable(e)))?;
    if bytes.starts_with(GZIP_MAGIC) {
        bytes = decompress(&bytes, observer).map_err(&fail)?;
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

/// A file's bytes as text: UTF-8, or as some programs of Windows write tables: UTF-16 behind its mark, or a byte a
/// character, whose degree signs and umlauts are Latin-1's.
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
    String::from_utf8(bytes).or_else(|e| {
        let valid = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        let is_letter = |byte: &u8| !byte.is_ascii_control() || byte.is_ascii_whitespace();
        match e.as_bytes().iter().all(is_letter) {
            true => Ok(e.as_bytes().iter().copied().map(char::from).collect()),
            false => Err(fail(Some(line), LogErrorKind::NotText)),
        }
    })
}

fn decompress(stored: &[u8], observer: ReadObserver<'_>) -> Result<Vec<u8>, LogErrorKind> {
    let mut bytes = Vec::new();
    let watched = Watched { left: stored, passage: Passage::through(stored.len(), observer) };
    match read_limited(&mut MultiGzDecoder::new(watched), &mut bytes) {
        Ok(()) => Ok(bytes),
        Err(e) => Err(LogErrorKind::Gzip { reason: e.to_string(), bytes: bytes.len() }),
    }
}

/// Stored bytes, and how many of them have been taken.
struct Watched<'a> {
    left: &'a [u8],
    passage: Passage<'a>,
}

impl Read for Watched<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let taken = self.left.read(into)?;
        self.passage.is_before(self.left.len());
        Ok(taken)
    }
}

/// Reads to the end, or to one byte more than may be.
fn read_limited(from: &mut impl Read, into: &mut Vec<u8>) -> io::Result<()> {
    from.take(TEXT_BYTES_MAX + 1).read_to_end(into)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;
    use crate::sensors::random::RandomStream;

    #[test]
    fn decompressing_says_how_far_it_is() {
        // numbers that gzip can do nothing about: some twenty of its pieces of 32 kB
        let mut random = RandomStream::new(6, "noise");
        let bytes: Vec<u8> = (0..600_000).map(|_| (256.0 * random.uniform()) as u8).collect();
        let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(&bytes).unwrap();
        let packed = packed.finish().unwrap();
        let reports = RefCell::new(Vec::new());
        let unpacked = decompress(&packed, &|done, of| reports.borrow_mut().push((done, of))).unwrap();
        assert!(unpacked == bytes);
        let reports = reports.into_inner();
        assert!(reports.len() > 15 && reports.windows(2).all(|pair| pair[0].0 < pair[1].0), "{reports:?}");
        assert_eq!(reports[reports.len() - 1], (packed.len(), packed.len()));
    }
}
