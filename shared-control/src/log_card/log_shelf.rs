//! The card's logs for whoever asks over the link: what there is, and bytes from anywhere, read ahead of being sent.
//!
//! Who sends does not wait for the card: what is not there yet is noted as wanted, whoever has the card fetches it, and
//! the sender asks again.

use heapless::Vec;

use super::SECTOR_BYTES;
use super::directory::Listed;
use crate::link::LogStore;

/// Logs that are listed: the newest.
pub const LISTED_MAX: usize = 64;
/// Bytes that are fetched at once: a piece that begins in the first sector lies in them whole.
pub const WINDOW_BYTES: usize = 2 * SECTOR_BYTES;
/// They begin with a sector.
const SECTOR_MASK: u32 = !(SECTOR_BYTES as u32 - 1);

/// Bytes of a log that somebody waits for, from a sector's beginning on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    pub(super) log: Listed,
    pub(super) offset: u32,
}

/// What is known of the card's logs.
#[derive(Clone, Debug)]
pub struct LogShelf {
    logs: Vec<Listed, LISTED_MAX>,
    window: [u8; WINDOW_BYTES],
    held: Option<(Wanted, usize)>,
    wanted: Option<Wanted>,
}

impl Default for LogShelf {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl LogShelf {
    /// Without a card.
    pub const EMPTY: Self = Self { logs: Vec::new(), window: [0; WINDOW_BYTES], held: None, wanted: None };

    /// Takes note of a log. Of too many the oldest are left out.
    pub(super) fn note(&mut self, log: Listed) {
        let Err(log) = self.logs.push(log) else { return };
        let oldest = self.logs.iter_mut().min_by_key(|other| other.name);
        if let Some(oldest) = oldest.filter(|oldest| oldest.name < log.name) {
            *oldest = log;
        }
    }

    /// What somebody waits for.
    pub fn wanted(&self) -> Option<Wanted> {
        self.wanted
    }

    /// Here it is; none where it can't be read, so that nobody waits for it any more.
    pub fn bring(&mut self, wanted: Wanted, bytes: &[u8]) {
        super::put(&mut self.window, 0, bytes);
        self.held = Some((wanted, bytes.len().min(WINDOW_BYTES)));
        self.wanted = None;
    }

    /// The log that has so many older ones.
    fn log(&self, id: u16) -> Option<Listed> {
        let older = |log: &Listed| self.logs.iter().filter(|other| other.name < log.name).count();
        self.logs.iter().find(|log| older(log) == usize::from(id)).copied()
    }

    /// Where the window has these bytes.
    fn place(&self, id: u16, offset: u32) -> Option<&[u8]> {
        let log = self.log(id)?;
        let (held, length) = self.held.filter(|(held, _)| held.log == log)?;
        let begin = offset.checked_sub(held.offset)? as usize;
        // a place at the log's end has no bytes
        (begin < SECTOR_BYTES || offset >= log.size_bytes).then(|| self.window.get(begin..length).unwrap_or_default())
    }
}

impl LogStore for LogShelf {
    fn count(&mut self) -> u16 {
        self.logs.len() as u16
    }

    fn size_bytes(&mut self, id: u16) -> u32 {
        self.log(id).map_or(0, |log| log.size_bytes)
    }

    fn is_ready(&mut self, id: u16, offset: u32) -> bool {
        let Some(log) = self.log(id).filter(|log| offset < log.size_bytes) else { return true };
        let is_ready = self.place(id, offset).is_some();
        self.wanted = (!is_ready).then_some(Wanted { log, offset: offset & SECTOR_MASK });
        is_ready
    }

    fn read(&mut self, id: u16, offset: u32, piece: &mut [u8]) -> usize {
        let found = self.place(id, offset).unwrap_or_default();
        for (place, byte) in piece.iter_mut().zip(found) {
            *place = *byte;
        }
        found.len().min(piece.len())
    }

    /// Nothing of the card is removed.
    fn erase(&mut self) {}
}
