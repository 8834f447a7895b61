//! From a stream of bytes to a log on the card: blocks that cards like, a size about once a second.

use super::directory::{Listed, LogName};
use super::log_file::LogFile;
use super::log_shelf::{LogShelf, WINDOW_BYTES, Wanted};
use super::volume::{Next, Volume};
use super::{CardError, SECTOR_BYTES, Sectors};

/// What is written at once, bytes: a card writes eight sectors in about the time of one.
pub const BLOCK_BYTES: usize = 8 * SECTOR_BYTES;
/// How often the file's size is written, us: what a power cut takes at most, and what the card's pauses last.
const FLUSH_PERIOD_US: u64 = 1_000_000;

/// The writing end of a log.
#[derive(Clone, Debug)]
pub struct CardLog {
    volume: Volume,
    file: Option<LogFile>,
    block: [u8; BLOCK_BYTES],
    filled: usize,
    flushed_us: u64,
    /// What went wrong in a place that cannot say so.
    failure: Option<CardError>,
    /// Where reading has come to: first cluster of the log, how many clusters on, which one.
    found: Option<(u32, u32, u32)>,
}

impl CardLog {
    /// With a card that is ready.
    ///
    /// # Errors
    /// If it has no file system that can be written, or no room.
    pub fn mount(card: &mut impl Sectors) -> Result<Self, CardError> {
        let volume = Volume::mount(card)?;
        Ok(Self { volume, file: None, block: [0; BLOCK_BYTES], filled: 0, flushed_us: 0, failure: None, found: None })
    }

    /// Is a log under way?
    pub fn is_open(&self) -> bool {
        self.file.is_some()
    }

    /// Begins a log.
    ///
    /// # Errors
    /// If the card is full or fails.
    pub fn begin(&mut self, card: &mut impl Sectors, now_us: u64) -> Result<LogName, CardError> {
        let file = LogFile::create(&mut self.volume, card)?;
        (self.filled, self.flushed_us) = (0, now_us);
        self.file = Some(file);
        Ok(file.name())
    }

    /// Room before the next write, bytes: never 0.
    pub fn room(&self) -> usize {
        BLOCK_BYTES.saturating_sub(self.filled).max(1)
    }

    /// Adds bytes; what fills a block is written.
    ///
    /// # Errors
    /// If the card is full or fails; then the log ends, as it was when its size was written last.
    pub fn append(&mut self, card: &mut impl Sectors, bytes: &[u8]) -> Result<(), CardError> {
        for byte in bytes {
            if let Some(place) = self.block.get_mut(self.filled) {
                *place = *byte;
                self.filled += 1;
            }
            if self.filled >= BLOCK_BYTES {
                self.filled = 0;
                let (Some(file), volume) = (&mut self.file, &mut self.volume) else { continue };
                let written = file.append(volume, card, &self.block);
                self.given_up_if(written)?;
            }
        }
        Ok(())
    }

    /// The same for a caller that cannot be told: [`Self::flush`] says so.
    pub fn put(&mut self, card: &mut impl Sectors, bytes: &[u8]) {
        if let (None, Err(error)) = (self.failure, self.append(card, bytes)) {
            self.failure = Some(error);
        }
    }

    /// Is it time to flush?
    pub fn is_due(&self, now_us: u64) -> bool {
        self.file.is_some() && now_us.saturating_sub(self.flushed_us) >= FLUSH_PERIOD_US
    }

    /// Writes all that there is, and the size.
    ///
    /// # Errors
    /// As [`Self::append`].
    pub fn flush(&mut self, card: &mut impl Sectors, now_us: u64) -> Result<(), CardError> {
        self.flushed_us = now_us;
        let written = match (self.failure.take(), &mut self.file) {
            (Some(error), _) => Err(error),
            (None, None) => Ok(()),
            (None, Some(file)) => {
                let whole = self.filled / SECTOR_BYTES * SECTOR_BYTES;
                let (full, rest) = self.block.split_at_checked(whole).unwrap_or((&[], &[]));
                let rest = rest.get(..self.filled.saturating_sub(whole)).unwrap_or_default();
                file.append(&mut self.volume, card, full).and_then(|()| file.flush(&mut self.volume, card, rest))
            }
        };
        self.given_up_if(written)?;
        self.keep_rest();
        Ok(())
    }

    /// Ends the log.
    ///
    /// # Errors
    /// As [`Self::append`].
    pub fn end(&mut self, card: &mut impl Sectors, now_us: u64) -> Result<(), CardError> {
        self.flush(card, now_us)?;
        match self.file.take() {
            Some(file) => file.close(&mut self.volume, card),
            None => Ok(()),
        }
    }

    /// Lists the card's logs.
    ///
    /// # Errors
    /// If the card fails, or makes no sense.
    pub fn list(&mut self, card: &mut impl Sectors) -> Result<LogShelf, CardError> {
        let mut shelf = LogShelf::EMPTY;
        self.volume.look_through(card, &mut |log| shelf.note(log))?;
        Ok(shelf)
    }

    /// Reads what somebody waits for; how many bytes that is.
    ///
    /// # Errors
    /// As [`Self::list`].
    pub fn fetch(
        &mut self,
        card: &mut impl Sectors,
        wanted: &Wanted,
        window: &mut [u8; WINDOW_BYTES],
    ) -> Result<usize, CardError> {
        let mut count = 0;
        for part in window.chunks_exact_mut(SECTOR_BYTES) {
            let offset = wanted.offset.saturating_add(count as u32);
            let left = wanted.log.size_bytes.saturating_sub(offset);
            if left == 0 {
                break;
            }
            let sector = self.find_sector(card, &wanted.log, offset)?;
            super::put(part, 0, self.volume.read(card, sector)?);
            count += (left as usize).min(SECTOR_BYTES);
        }
        Ok(count)
    }

    /// The sector that has a byte of a log. Who reads on begins where the last search ended.
    fn find_sector(&mut self, card: &mut impl Sectors, log: &Listed, offset: u32) -> Result<u32, CardError> {
        // a cluster has a power of two of bytes
        let within = offset & (self.volume.cluster_bytes() - 1);
        let index = (offset - within) >> self.volume.cluster_bytes().trailing_zeros();
        let (mut at, mut cluster) = match self.found {
            Some((first, at, cluster)) if first == log.first && at <= index => (at, cluster),
            _ => (0, log.first),
        };
        // a file has at most as many clusters as the card
        while at < index {
            match self.volume.next(card, cluster)? {
                Next::Cluster(next) => cluster = next,
                Next::End | Next::Free => return Err(CardError::Damaged),
            }
            at += 1;
        }
        self.found = Some((log.first, at, cluster));
        Ok(self.volume.layout.sector_of(cluster)? + within / SECTOR_BYTES as u32)
    }

    /// What does not fill a sector goes to the block's beginning.
    fn keep_rest(&mut self) {
        let whole = self.filled / SECTOR_BYTES * SECTOR_BYTES;
        let mut rest = [0; SECTOR_BYTES];
        super::put(&mut rest, 0, self.block.get(whole..self.filled).unwrap_or_default());
        self.filled = self.filled.saturating_sub(whole);
        super::put(&mut self.block, 0, &rest);
    }

    fn given_up_if(&mut self, written: Result<(), CardError>) -> Result<(), CardError> {
        if written.is_err() {
            (self.file, self.filled) = (None, 0);
        }
        written
    }
}
