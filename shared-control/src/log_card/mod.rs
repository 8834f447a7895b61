//! Flight logs as files on a card with FAT16 or FAT32: bytes to sectors, whatever moves the sectors.
//!
//! ```text
//!   onboard_log's ring -> CardLog -> LogFile (clusters, size) -> Volume (FAT, root directory) -> Sectors: the card
//! ```
//! Written for a card that is pulled, fails or loses power at any moment:
//!
//! - Clusters are taken before data goes there, the data are written before the file's size says so. Whatever write was
//!   the last, the file system can be read, and so is the log up to the size that was written last, a second earlier at
//!   most. What such an end leaves behind is clusters that belong to nobody or stand behind the end of a file, as any
//!   camera whose battery is pulled leaves them.
//! - Nothing of the card is believed: every number that was read is checked, each search has its bound, and a file
//!   system that makes no sense is an error in words. Nothing here panics.
//! - Nothing of the card is removed, and no log is written over: the next one has the next number. A full card keeps
//!   what it has.
//!
//! FAT: Microsoft, "FAT32 File System Specification" 1.03.

mod card_log;
mod directory;
mod log_file;
mod log_shelf;
mod partition;
mod volume;

pub use card_log::{BLOCK_BYTES, CardLog};
pub use directory::LogName;
pub use log_file::LogFile;
pub use log_shelf::{LogShelf, WINDOW_BYTES, Wanted};
pub use volume::Volume;

/// Bytes of a sector, the only size that cards have.
pub const SECTOR_BYTES: usize = 512;
/// Its bytes.
pub type Sector = [u8; SECTOR_BYTES];

/// What moves sectors. Calls return when it is done, or has failed.
pub trait Sectors {
    /// Reads one.
    ///
    /// # Errors
    /// [`CardError::Failed`] or [`CardError::Absent`].
    fn read(&mut self, number: u32, sector: &mut Sector) -> Result<(), CardError>;

    /// Writes one or more that follow each other; `bytes` is a whole number of sectors.
    ///
    /// # Errors
    /// As [`Self::read`].
    fn write(&mut self, number: u32, bytes: &[u8]) -> Result<(), CardError>;
}

/// Why there is no log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardError {
    /// No card answers.
    Absent,
    /// A card did not do what it was to do, or not in time.
    Failed,
    /// It has neither FAT16 nor FAT32, cards of more than 32 GB mostly exFAT.
    UnknownFormat,
    /// Its file system contradicts itself.
    Damaged,
    /// No cluster is free.
    Full,
    /// The root directory has no room for another name, or the numbers are used up.
    NoName,
}

impl CardError {
    /// For a person, in 50 characters at most.
    pub fn words(self) -> &'static str {
        match self {
            Self::Absent => "no SD card: no log",
            Self::Failed => "SD card failed: no log",
            Self::UnknownFormat => "SD card not FAT16 or FAT32: no log",
            Self::Damaged => "SD card's file system is damaged: no log",
            Self::Full => "SD card full: no log",
            Self::NoName => "SD card's directory full: no log",
        }
    }
}

/// A number of two bytes in a sector; 0 beyond its end.
fn u16_at(sector: &[u8], at: usize) -> u16 {
    let byte = |at| sector.get(at).copied().unwrap_or_default();
    u16::from_le_bytes([byte(at), byte(at.saturating_add(1))])
}

/// A number of four.
fn u32_at(sector: &[u8], at: usize) -> u32 {
    u32::from(u16_at(sector, at)) | u32::from(u16_at(sector, at.saturating_add(2))) << 16
}

/// Puts bytes into a sector; what would lie beyond its end is left out.
fn put(sector: &mut [u8], at: usize, bytes: &[u8]) {
    for (place, byte) in sector.iter_mut().skip(at).zip(bytes) {
        *place = *byte;
    }
}

#[cfg(test)]
mod tests;
