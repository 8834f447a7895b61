//! Where a served vehicle keeps its logs: in memory, or as files of a folder, which last.
//!
//! In a folder a log is `log-0001.ulg` and so on, written as it comes, so that what was written before the program
//! ended is there. Files of other names are left alone.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use shared_control::link::LogStore;

/// Memory for logs where there is no folder, bytes; the oldest make room. An hour under the MPC is 350 MB.
const MEMORY_BYTES: usize = 128 << 20;

/// A log that is complete.
enum Kept {
    Memory(Vec<u8>),
    File(PathBuf, u32),
}

impl Kept {
    fn size_bytes(&self) -> u32 {
        match self {
            Kept::Memory(bytes) => u32::try_from(bytes.len()).unwrap_or(u32::MAX),
            Kept::File(_, size) => *size,
        }
    }
}

/// A log that is being written.
enum Open {
    Memory(Vec<u8>),
    File(PathBuf, File),
}

/// The logs, and the one under way.
pub struct LogShelf {
    folder: Option<PathBuf>,
    kept: Vec<Kept>,
    open: Option<Open>,
    /// The file that is read, which stays open from one piece to the next.
    reading: Option<(u16, File)>,
}

impl LogShelf {
    /// Logs that last as long as the program.
    pub fn in_memory() -> Self {
        Self { folder: None, kept: Vec::new(), open: None, reading: None }
    }

    /// Logs in a folder, which is made where there is none; those that lie there already are known.
    ///
    /// # Errors
    /// The folder cannot be made or read.
    pub fn in_folder(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let mut paths = Vec::new();
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if number_of(&path).is_some() {
                paths.push(path);
            }
        }
        paths.sort_by_key(|path| number_of(path));
        let kept = paths.into_iter().map(|path| Ok(Kept::File(path.clone(), file_size(&path)?)));
        let kept = kept.collect::<io::Result<_>>()?;
        Ok(Self { folder: Some(folder.to_owned()), kept, open: None, reading: None })
    }

    /// Is a log under way?
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Begins a log.
    ///
    /// # Errors
    /// There can be no such file.
    pub fn begin(&mut self) -> io::Result<()> {
        let Some(folder) = &self.folder else {
            let mut in_use: usize = self.kept.iter().map(|log| log.size_bytes() as usize).sum();
            while in_use > MEMORY_BYTES && !self.kept.is_empty() {
                in_use -= self.kept.remove(0).size_bytes() as usize;
            }
            self.open = Some(Open::Memory(Vec::new()));
            return Ok(());
        };
        let last = self.kept.iter().filter_map(|log| match log {
            Kept::File(path, _) => number_of(path),
            Kept::Memory(_) => None,
        });
        let path = folder.join(format!("log-{:04}.ulg", last.max().unwrap_or(0) + 1));
        let file = File::create_new(&path)?;
        self.open = Some(Open::File(path, file));
        Ok(())
    }

    /// Goes on with the log under way.
    ///
    /// # Errors
    /// The medium is full; the log stays as it is.
    pub fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        match &mut self.open {
            Some(Open::Memory(log)) if log.len() + bytes.len() > MEMORY_BYTES => Err(io::ErrorKind::OutOfMemory.into()),
            Some(Open::Memory(log)) => {
                log.extend_from_slice(bytes);
                Ok(())
            }
            Some(Open::File(_, file)) => file.write_all(bytes),
            None => Ok(()),
        }
    }

    /// The log under way is complete.
    ///
    /// # Errors
    /// Its file cannot be looked at.
    pub fn end(&mut self) -> io::Result<()> {
        match self.open.take() {
            Some(Open::Memory(log)) => self.kept.push(Kept::Memory(log)),
            Some(Open::File(path, _)) => {
                let size = file_size(&path)?;
                self.kept.push(Kept::File(path, size));
            }
            None => {}
        }
        Ok(())
    }

    fn read_file(&mut self, id: u16, offset: u32, piece: &mut [u8]) -> io::Result<usize> {
        let Some(Kept::File(path, _)) = self.kept.get(usize::from(id)) else { return Ok(0) };
        if self.reading.as_ref().is_none_or(|(open, _)| *open != id) {
            self.reading = Some((id, File::open(path)?));
        }
        let Some((_, file)) = &mut self.reading else { return Ok(0) };
        file.seek(SeekFrom::Start(offset.into()))?;
        let mut filled = 0;
        while filled < piece.len() {
            match file.read(&mut piece[filled..])? {
                0 => break,
                count => filled += count,
            }
        }
        Ok(filled)
    }
}

impl LogStore for LogShelf {
    fn count(&mut self) -> u16 {
        u16::try_from(self.kept.len()).unwrap_or(u16::MAX)
    }

    fn size_bytes(&mut self, id: u16) -> u32 {
        self.kept.get(usize::from(id)).map_or(0, Kept::size_bytes)
    }

    fn read(&mut self, id: u16, offset: u32, piece: &mut [u8]) -> usize {
        if let Some(Kept::Memory(log)) = self.kept.get(usize::from(id)) {
            let from = log.get(offset as usize..).unwrap_or_default();
            let count = piece.len().min(from.len());
            piece[..count].copy_from_slice(&from[..count]);
            return count;
        }
        // what cannot be read ends the log for whoever reads it
        self.read_file(id, offset, piece).unwrap_or(0)
    }

    fn erase(&mut self) {
        self.reading = None;
        // what cannot be removed stays in the list
        self.kept.retain(|log| match log {
            Kept::Memory(_) => false,
            Kept::File(path, _) => fs::remove_file(path).is_err(),
        });
    }
}

/// The number in the name of a log's file; none of other files.
fn number_of(path: &Path) -> Option<u32> {
    let name = path.file_name()?.to_str()?;
    let digits = name.strip_prefix("log-")?.strip_suffix(".ulg")?;
    if digits.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit()) { digits.parse().ok() } else { None }
}

fn file_size(path: &Path) -> io::Result<u32> {
    Ok(u32::try_from(fs::metadata(path)?.len()).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_all(shelf: &mut LogShelf, id: u16) -> Vec<u8> {
        let mut bytes = vec![0; shelf.size_bytes(id) as usize];
        for (offset, piece) in (0..).step_by(7).zip(bytes.chunks_mut(7)) {
            assert_eq!(shelf.read(id, offset, piece), piece.len());
        }
        bytes
    }

    fn write(shelf: &mut LogShelf, parts: &[&[u8]]) {
        shelf.begin().unwrap();
        for part in parts {
            shelf.append(part).unwrap();
        }
        shelf.end().unwrap();
    }

    /// The same in memory and in a folder; the log under way is not listed.
    #[test]
    fn logs_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        for mut shelf in [LogShelf::in_memory(), LogShelf::in_folder(&folder.path().join("new")).unwrap()] {
            assert_eq!((shelf.count(), shelf.size_bytes(0), shelf.read(0, 0, &mut [0; 4])), (0, 0, 0));
            write(&mut shelf, &[b"one log ", b"in two parts"]);
            write(&mut shelf, &[b"another"]);
            shelf.begin().unwrap();
            shelf.append(b"under way").unwrap();
            assert_eq!(shelf.count(), 2);
            assert_eq!(read_all(&mut shelf, 0), b"one log in two parts");
            assert_eq!(read_all(&mut shelf, 1), b"another");
            assert_eq!(read_all(&mut shelf, 0), b"one log in two parts");
            assert_eq!((shelf.read(1, 4, &mut [0; 9]), shelf.read(1, 70, &mut [0; 9])), (3, 0));
            shelf.erase();
            assert_eq!(shelf.count(), 0);
            shelf.end().unwrap();
            assert_eq!(read_all(&mut shelf, 0), b"under way");
        }
    }

    /// The next program finds them, numbers go on, and what is not a log is neither listed nor erased.
    #[test]
    fn a_folder_keeps_them() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("log-notes.ulg"), "mine").unwrap();
        fs::write(folder.path().join("log-0009.ulg"), "ninth").unwrap();
        write(&mut LogShelf::in_folder(folder.path()).unwrap(), &[b"tenth"]);
        let mut shelf = LogShelf::in_folder(folder.path()).unwrap();
        assert_eq!(shelf.count(), 2);
        assert_eq!([read_all(&mut shelf, 0), read_all(&mut shelf, 1)], [b"ninth", b"tenth"]);
        assert_eq!(fs::read(folder.path().join("log-0010.ulg")).unwrap(), b"tenth");
        shelf.erase();
        let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["log-notes.ulg"]);
    }
}
