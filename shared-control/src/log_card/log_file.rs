//! A log that is being written: clusters before data, data before the size.

use super::directory::{Listed, LogName, Place};
use super::volume::{Next, Volume};
use super::{CardError, SECTOR_BYTES, Sectors};

/// The longest file that FAT can have, less what one more write may add.
const SIZE_MAX: u32 = u32::MAX - (1 << 16);

/// A file that grows.
#[derive(Clone, Copy, Debug)]
pub struct LogFile {
    place: Place,
    log: Listed,
    /// Where the next sector goes: this cluster, behind so many of its sectors.
    cluster: u32,
    used_sectors: u32,
    /// The last that belongs to the file.
    last: u32,
    /// Bytes in whole sectors so far.
    whole_bytes: u32,
}

impl LogFile {
    /// A new one, empty, with the next number.
    ///
    /// # Errors
    /// If the card is full or fails.
    pub fn create(volume: &mut Volume, card: &mut impl Sectors) -> Result<Self, CardError> {
        let (place, name) = volume.place_for_log(card)?;
        let taken = volume.take_clusters(card, u32::MAX)?;
        let log = Listed { name, first: taken.first, size_bytes: 0 };
        volume.write_entry(card, place, &log)?;
        Ok(Self { place, log, cluster: taken.first, used_sectors: 0, last: taken.last, whole_bytes: 0 })
    }

    /// Its number.
    pub fn name(&self) -> LogName {
        self.log.name
    }

    /// Adds whole sectors, without the file's size.
    ///
    /// # Errors
    /// If the card is full or fails.
    pub fn append(&mut self, volume: &mut Volume, card: &mut impl Sectors, bytes: &[u8]) -> Result<(), CardError> {
        let mut left = bytes;
        // each turn takes a sector at least
        for _ in 0..bytes.len() / SECTOR_BYTES {
            let room = self.find_room(volume, card)?;
            let count = (left.len() / SECTOR_BYTES).min(room as usize);
            let Some((now, later)) = left.split_at_checked(count * SECTOR_BYTES) else { break };
            if now.is_empty() {
                break;
            }
            card.write(volume.layout.sector_of(self.cluster)? + self.used_sectors, now)?;
            self.used_sectors += count as u32;
            self.whole_bytes += now.len() as u32;
            left = later;
        }
        Ok(())
    }

    /// Writes what does not fill a sector yet behind those that are full, and then the size. The sector will be written
    /// again when it is full.
    ///
    /// # Errors
    /// As [`Self::append`].
    pub fn flush(&mut self, volume: &mut Volume, card: &mut impl Sectors, rest: &[u8]) -> Result<(), CardError> {
        let mut sector = [0; SECTOR_BYTES];
        super::put(&mut sector, 0, rest);
        if !rest.is_empty() {
            self.find_room(volume, card)?;
            card.write(volume.layout.sector_of(self.cluster)? + self.used_sectors, &sector)?;
        }
        let size_bytes = self.whole_bytes + rest.len().min(SECTOR_BYTES) as u32;
        if size_bytes != self.log.size_bytes {
            self.log.size_bytes = size_bytes;
            volume.write_entry(card, self.place, &self.log)?;
        }
        Ok(())
    }

    /// Gives back what was taken and not needed; the size has been written.
    ///
    /// # Errors
    /// As [`Self::append`].
    pub fn close(self, volume: &mut Volume, card: &mut impl Sectors) -> Result<(), CardError> {
        volume.end_with(card, self.cluster)
    }

    /// How many sectors the cluster has left, which becomes the next one if that is none.
    fn find_room(&mut self, volume: &mut Volume, card: &mut impl Sectors) -> Result<u32, CardError> {
        let sectors = volume.cluster_bytes() / SECTOR_BYTES as u32;
        if self.used_sectors < sectors {
            return Ok(sectors - self.used_sectors);
        }
        if self.whole_bytes >= SIZE_MAX {
            return Err(CardError::Full);
        }
        self.cluster = match volume.next(card, self.cluster)? {
            Next::Cluster(next) => next,
            Next::End => {
                let taken = volume.take_clusters(card, u32::MAX)?;
                volume.link(card, self.last, taken.first)?;
                self.last = taken.last;
                taken.first
            }
            Next::Free => return Err(CardError::Damaged),
        };
        self.used_sectors = 0;
        Ok(sectors)
    }
}
