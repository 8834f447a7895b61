//! The key and the clock of signed frames, kept in two files: the key as its owner writes it, the clock beside it.
//!
//! A line of 64 hexadecimal digits is the key itself, any other line a passphrase whose SHA-256 is the key, as ground
//! stations make it. The clock is a whole number, 10 us since 2015, in a file of the same name with `.clock` behind it.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use shared_control::link::signing::{Key, SigningRecord};

use super::SigningStore;

/// Key and clock in their files.
pub struct SigningFile {
    key: PathBuf,
    clock: PathBuf,
    kept: SigningRecord,
}

impl SigningFile {
    /// Reads what is there; without a file there is no key.
    ///
    /// # Errors
    /// In words, with the file: it cannot be read, or holds no key or no clock.
    pub fn open(path: &Path) -> Result<Self, String> {
        let mut clock = path.to_path_buf().into_os_string();
        clock.push(".clock");
        let clock = PathBuf::from(clock);
        let key = match text_of(path)? {
            None => None,
            Some(text) => {
                let empty = || format!("{}: expected 64 hexadecimal digits or a passphrase", path.display());
                Some(key_of(text.trim()).ok_or_else(empty)?)
            }
        };
        let ceiling = match text_of(&clock)? {
            None => 0,
            Some(text) => {
                let wrong = |_| format!("{}: expected a whole number, 10 us since 2015", clock.display());
                text.trim().parse().map_err(wrong)?
            }
        };
        Ok(Self { key: path.to_path_buf(), clock, kept: SigningRecord { serial: 0, key, ceiling } })
    }

    /// The clock first: a key never stands beside a clock that is behind it.
    fn write(&self, record: &SigningRecord) -> std::io::Result<()> {
        replace(&self.clock, &format!("{}\n", record.ceiling))?;
        if record.key == self.kept.key {
            return Ok(());
        }
        match record.key {
            Some(key) => {
                let digits: String = key.bytes().iter().map(|byte| format!("{byte:02x}")).collect();
                replace(&self.key, &format!("{digits}\n"))
            }
            None => std::fs::remove_file(&self.key),
        }
    }
}

impl SigningStore for SigningFile {
    fn kept(&self) -> SigningRecord {
        self.kept
    }

    fn keep(&mut self, record: &SigningRecord) -> bool {
        let kept = self.write(record).is_ok();
        if kept {
            self.kept = *record;
        }
        kept
    }
}

/// None where there is no such file.
fn text_of(path: &Path) -> Result<Option<String>, String> {
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(format!("{}: cannot be read: {error}", path.display())),
    }
}

/// None for an empty line and for a key of zeros, which means none.
fn key_of(line: &str) -> Option<Key> {
    if line.is_empty() || line.contains('\n') {
        return None;
    }
    let digits = line.as_bytes();
    if digits.len() != 64 || !digits.iter().all(u8::is_ascii_hexdigit) {
        return Key::new(Sha256::digest(digits).into());
    }
    let mut key = [0; 32];
    for (byte, pair) in key.iter_mut().zip(digits.chunks(2)) {
        let pair = std::str::from_utf8(pair).ok()?;
        *byte = u8::from_str_radix(pair, 16).ok()?;
    }
    Key::new(key)
}

/// As a whole: a reader finds what was there before or the new text. For the owner's eyes alone, where files can be.
fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let mut beside = path.to_path_buf().into_os_string();
    beside.push(".new");
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    std::io::Write::write_all(&mut options.open(&beside)?, text.as_bytes())?;
    std::fs::rename(&beside, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_hexadecimal_or_the_hash_of_a_passphrase() {
        let digits = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeef0";
        let key = key_of(digits).unwrap();
        assert_eq!((key.bytes()[1], key.bytes()[31]), (0x11, 0xf0));
        // FIPS 180-4's example: SHA-256 of "abc" begins with ba7816bf
        assert_eq!(key_of("abc").unwrap().bytes()[..4], [0xba, 0x78, 0x16, 0xbf]);
        assert!([&"0".repeat(64), "", "two\nlines"].map(key_of).iter().all(Option::is_none));
    }

    #[test]
    fn what_is_kept_is_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        let mut file = SigningFile::open(&path).unwrap();
        assert_eq!(file.kept(), SigningRecord::default());
        let record = SigningRecord { serial: 0, key: key_of("abc"), ceiling: 7_000_000 };
        assert!(file.keep(&record) && file.kept() == record);
        let mut found = SigningFile::open(&path).unwrap();
        assert_eq!(found.kept(), record);
        assert!(found.keep(&SigningRecord { key: None, ..record }) && !path.exists());
        assert_eq!(SigningFile::open(&path).unwrap().kept(), SigningRecord { key: None, ..record });
        std::fs::write(&path, "\n").unwrap();
        assert!(SigningFile::open(&path).is_err_and(|words| words.contains("expected 64")));
        assert!(!SigningFile::open(&folder.path().join("no/such")).unwrap().keep(&record));
    }
}
