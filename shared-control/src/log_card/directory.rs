//! The root directory: which logs there are, and a place for another. "FAT Directory Structure".
//!
//! Names are LOG00001.ULG and so on, of eight letters and three, so that no long names are needed. A log's number is
//! one more than the highest that is there. The vehicle knows no date: each log has the first that FAT knows, 1 January
//! 1980, and their order is that of their numbers.

use super::partition::Kind;
use super::volume::{Next, Volume};
use super::{CardError, Sectors, put, u16_at, u32_at};

/// Bytes of an entry.
const ENTRY_BYTES: usize = 32;
/// A directory may have 65,536 entries.
const SECTORS_MAX: u32 = 4096;
/// The entry was deleted.
const DELETED: u8 = 0xe5;
/// Attributes of a file, and those that an entry of another sort has: volume's label, folder, part of a long name.
const ARCHIVE: u8 = 0x20;
const NO_FILE: u8 = 0x18;
/// 1 January 1980.
const FIRST_DATE: u16 = 1 << 5 | 1;
/// Highest number of a log.
const NUMBER_MAX: u32 = 99_999;

/// The number of a log, in its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LogName(pub u32);

impl LogName {
    /// As it stands in the directory.
    fn letters(self) -> [u8; 11] {
        let mut letters = *b"LOG00000ULG";
        let mut number = self.0;
        for letter in letters.iter_mut().skip(3).take(5).rev() {
            *letter = b'0' + (number % 10) as u8;
            number /= 10;
        }
        letters
    }

    fn of_letters(letters: &[u8]) -> Option<Self> {
        let digits = letters.strip_prefix(b"LOG")?.strip_suffix(b"ULG")?;
        digits
            .iter()
            .try_fold(0_u32, |number, letter| {
                letter.is_ascii_digit().then(|| number.wrapping_mul(10).wrapping_add(u32::from(letter - b'0')))
            })
            .map(Self)
    }
}

/// Where an entry stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    sector: u32,
    at: usize,
}

/// A log as the directory has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Listed {
    pub(super) name: LogName,
    pub(super) first: u32,
    pub(super) size_bytes: u32,
}

/// What looking through the directory found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Found {
    /// The highest number of a log.
    pub(super) highest: u32,
    /// The first place without an entry.
    free: Option<Place>,
    /// The last cluster of the directory, where it is a file.
    last_cluster: u32,
}

impl Volume {
    /// Looks at all logs, in the order in which they stand.
    pub(super) fn look_through(
        &mut self,
        card: &mut impl Sectors,
        visit: &mut impl FnMut(Listed),
    ) -> Result<Found, CardError> {
        let mut found = Found::default();
        let layout = self.layout;
        if layout.kind == Kind::Fat16 {
            for sector in 0..layout.root_sectors.min(SECTORS_MAX) {
                if self.look_at(card, layout.root + sector, visit, &mut found)? {
                    break;
                }
            }
            return Ok(found);
        }
        let (mut cluster, sectors) = (layout.root_cluster, 1 << layout.cluster_shift);
        for _ in 0..SECTORS_MAX >> layout.cluster_shift {
            let first = layout.sector_of(cluster)?;
            found.last_cluster = cluster;
            for sector in first..first + sectors {
                if self.look_at(card, sector, visit, &mut found)? {
                    return Ok(found);
                }
            }
            match self.next(card, cluster)? {
                Next::Cluster(next) => cluster = next,
                Next::End => return Ok(found),
                Next::Free => return Err(CardError::Damaged),
            }
        }
        Ok(found)
    }

    /// True if the directory ends here.
    fn look_at(
        &mut self,
        card: &mut impl Sectors,
        number: u32,
        visit: &mut impl FnMut(Listed),
        found: &mut Found,
    ) -> Result<bool, CardError> {
        let sector = self.read(card, number)?;
        for (index, entry) in sector.chunks_exact(ENTRY_BYTES).enumerate() {
            let place = Place { sector: number, at: index * ENTRY_BYTES };
            let (first_letter, attributes) = (entry.first().copied(), entry.get(11).copied().unwrap_or_default());
            if let Some(0 | DELETED) = first_letter {
                found.free.get_or_insert(place);
            }
            if first_letter == Some(0) {
                return Ok(true);
            }
            let name = entry.get(..11).and_then(LogName::of_letters).filter(|_| attributes & NO_FILE == 0);
            if let Some(name) = name {
                found.highest = found.highest.max(name.0);
                let first = u32::from(u16_at(entry, 20)) << 16 | u32::from(u16_at(entry, 26));
                visit(Listed { name, first, size_bytes: u32_at(entry, 28) });
            }
        }
        Ok(false)
    }

    /// A place for another log, and its name.
    pub(super) fn place_for_log(&mut self, card: &mut impl Sectors) -> Result<(Place, LogName), CardError> {
        let found = self.look_through(card, &mut |_| ())?;
        if found.highest >= NUMBER_MAX {
            return Err(CardError::NoName);
        }
        let name = LogName(found.highest + 1);
        match found.free {
            Some(place) => Ok((place, name)),
            None if self.layout.kind == Kind::Fat32 => Ok((self.lengthen_directory(card, found.last_cluster)?, name)),
            None => Err(CardError::NoName),
        }
    }

    /// One more cluster, empty before it belongs to the directory.
    fn lengthen_directory(&mut self, card: &mut impl Sectors, last: u32) -> Result<Place, CardError> {
        let taken = self.take_clusters(card, 1)?;
        let first = self.layout.sector_of(taken.first)?;
        for sector in first..first + (1 << self.layout.cluster_shift) {
            card.write(sector, &[0; 512])?;
        }
        self.link(card, last, taken.first)?;
        Ok(Place { sector: first, at: 0 })
    }

    /// Writes the entry of a log.
    pub(super) fn write_entry(&mut self, card: &mut impl Sectors, place: Place, log: &Listed) -> Result<(), CardError> {
        let mut entry = [0; ENTRY_BYTES];
        put(&mut entry, 0, &log.name.letters());
        put(&mut entry, 11, &[ARCHIVE]);
        for at in [16, 18, 24] {
            put(&mut entry, at, &FIRST_DATE.to_le_bytes());
        }
        put(&mut entry, 20, &((log.first >> 16) as u16).to_le_bytes());
        put(&mut entry, 26, &(log.first as u16).to_le_bytes());
        put(&mut entry, 28, &log.size_bytes.to_le_bytes());
        let sector = self.read(card, place.sector)?;
        put(sector, place.at, &entry);
        self.write_back(card)
    }
}
