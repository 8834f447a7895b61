//! A mounted file system: its FAT, read and written a sector at a time.

use super::partition::{Kind, Layout};
use super::{CardError, Sector, Sectors, put, u16_at, u32_at};

/// Marks the last cluster of a file.
const END: u32 = 0x0fff_ffff;
/// The FAT32 bits of an entry; the others are to be left as they are.
const ENTRY_BITS: u32 = 0x0fff_ffff;

/// What follows a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Nothing: the cluster is free.
    Free,
    /// Another of the same file.
    Cluster(u32),
    /// Nothing: the file ends.
    End,
}

/// Clusters that were taken together, in a chain that ends: the first and the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Taken {
    pub(super) first: u32,
    pub(super) last: u32,
}

/// A file system of a card.
#[derive(Clone, Debug)]
pub struct Volume {
    pub(super) layout: Layout,
    /// A sector, and which one it is.
    sector: Sector,
    held: Option<u32>,
    /// Below this sector of the FAT no cluster is free.
    search_from: u32,
    /// The count of free clusters was set to "not known".
    count_is_cleared: bool,
}

impl Volume {
    /// Finds the file system of a card and the first sector of its FAT that has a free cluster.
    ///
    /// # Errors
    /// If there is none, the card fails, or it is full.
    pub fn mount(card: &mut impl Sectors) -> Result<Self, CardError> {
        let layout = Layout::find(card)?;
        let mut volume = Self {
            layout,
            sector: [0; 512],
            held: None,
            search_from: 0,
            count_is_cleared: layout.count_sector.is_none(),
        };
        volume.search_from = volume.fat_sector_with_room(card)?;
        Ok(volume)
    }

    /// Bytes of a cluster.
    pub(super) fn cluster_bytes(&self) -> u32 {
        512 << self.layout.cluster_shift
    }

    /// A sector of the card, kept until another is read.
    pub(super) fn read(&mut self, card: &mut impl Sectors, number: u32) -> Result<&mut Sector, CardError> {
        if self.held != Some(number) {
            self.held = None;
            card.read(number, &mut self.sector)?;
            self.held = Some(number);
        }
        Ok(&mut self.sector)
    }

    /// Writes the sector that was read last, as it has been changed since.
    pub(super) fn write_back(&mut self, card: &mut impl Sectors) -> Result<(), CardError> {
        let number = self.held.take().ok_or(CardError::Failed)?;
        card.write(number, &self.sector)?;
        self.held = Some(number);
        Ok(())
    }

    /// What follows a cluster.
    pub(super) fn next(&mut self, card: &mut impl Sectors, cluster: u32) -> Result<Next, CardError> {
        if !self.layout.has_cluster(cluster) {
            return Err(CardError::Damaged);
        }
        let shift = self.layout.entries_shift();
        self.read(card, self.layout.fat + (cluster >> shift))?;
        let entry = self.entry(cluster & ((1 << shift) - 1));
        let end_min = match self.layout.kind {
            Kind::Fat16 => 0xfff8,
            Kind::Fat32 => 0x0fff_fff8,
        };
        if entry == 0 {
            Ok(Next::Free)
        } else if entry >= end_min {
            Ok(Next::End)
        } else if self.layout.has_cluster(entry) {
            Ok(Next::Cluster(entry))
        } else {
            Err(CardError::Damaged)
        }
    }

    /// Takes free clusters, at most so many, that stand in one sector of the FAT, and chains them. Nobody has them yet.
    pub(super) fn take_clusters(&mut self, card: &mut impl Sectors, most: u32) -> Result<Taken, CardError> {
        self.clear_count(card)?;
        self.search_from = self.fat_sector_with_room(card)?;
        let sector = self.search_from;
        self.read(card, self.layout.fat + sector)?;
        let first_here = sector << self.layout.entries_shift();
        let mut taken: Option<Taken> = None;
        let mut count = 0;
        for place in 0..1 << self.layout.entries_shift() {
            let cluster = first_here + place;
            if count == most || !self.layout.has_cluster(cluster) || self.entry(place) != 0 {
                continue;
            }
            count += 1;
            self.set_entry(place, END);
            taken = match taken {
                None => Some(Taken { first: cluster, last: cluster }),
                Some(Taken { first, last }) => {
                    self.set_entry(last - first_here, cluster);
                    Some(Taken { first, last: cluster })
                }
            };
        }
        self.write_fat(card, sector)?;
        taken.ok_or(CardError::Damaged)
    }

    /// Makes a cluster the successor of another.
    pub(super) fn link(&mut self, card: &mut impl Sectors, last: u32, next: u32) -> Result<(), CardError> {
        let shift = self.layout.entries_shift();
        self.read(card, self.layout.fat + (last >> shift))?;
        self.set_entry(last & ((1 << shift) - 1), next);
        self.write_fat(card, last >> shift)
    }

    /// Ends a file with this cluster, and frees those that follow and stand in the same sector of the FAT: of a log's
    /// clusters all that are not needed do, but for the first.
    pub(super) fn end_with(&mut self, card: &mut impl Sectors, last: u32) -> Result<(), CardError> {
        let shift = self.layout.entries_shift();
        let Next::Cluster(mut next) = self.next(card, last)? else { return Ok(()) };
        if next >> shift != last >> shift {
            // a whole sector's clusters in reserve: they stay behind the file's end
            return Ok(());
        }
        self.set_entry(last & ((1 << shift) - 1), END);
        for _ in 0..1_u32 << shift {
            let place = next & ((1 << shift) - 1);
            let after = self.entry(place);
            self.set_entry(place, 0);
            if after >> shift != next >> shift {
                break;
            }
            next = after;
        }
        self.write_fat(card, last >> shift)
    }

    fn fat_sector_with_room(&mut self, card: &mut impl Sectors) -> Result<u32, CardError> {
        let shift = self.layout.entries_shift();
        for sector in self.search_from..self.layout.fat_sectors {
            let first = sector << shift;
            if first > self.layout.last_cluster {
                break;
            }
            self.read(card, self.layout.fat + sector)?;
            if (0..1 << shift).any(|place| self.layout.has_cluster(first + place) && self.entry(place) == 0) {
                return Ok(sector);
            }
        }
        Err(CardError::Full)
    }

    /// An entry of the sector of the FAT that is held.
    fn entry(&self, place: u32) -> u32 {
        match self.layout.kind {
            Kind::Fat16 => u32::from(u16_at(&self.sector, 2 * place as usize)),
            Kind::Fat32 => u32_at(&self.sector, 4 * place as usize) & ENTRY_BITS,
        }
    }

    fn set_entry(&mut self, place: u32, value: u32) {
        match self.layout.kind {
            Kind::Fat16 => put(&mut self.sector, 2 * place as usize, &(value as u16).to_le_bytes()),
            Kind::Fat32 => {
                let at = 4 * place as usize;
                let kept = u32_at(&self.sector, at) & !ENTRY_BITS;
                put(&mut self.sector, at, &(kept | value & ENTRY_BITS).to_le_bytes());
            }
        }
    }

    /// Writes the sector that is held to all FATs.
    fn write_fat(&mut self, card: &mut impl Sectors, sector: u32) -> Result<(), CardError> {
        self.write_back(card)?;
        if self.layout.fats == 2 {
            card.write(self.layout.fat + self.layout.fat_sectors + sector, &self.sector)?;
        }
        Ok(())
    }

    /// Free clusters are not counted here: a count that is wrong would be worse than none (FAT32's FSInfo sector allows
    /// both numbers to be unknown).
    fn clear_count(&mut self, card: &mut impl Sectors) -> Result<(), CardError> {
        let Some(number) = self.layout.count_sector.filter(|_| !self.count_is_cleared) else { return Ok(()) };
        let sector = self.read(card, number)?;
        if u32_at(sector, 0) == 0x4161_5252 && u32_at(sector, 484) == 0x6141_7272 {
            put(sector, 488, &[0xff; 8]);
            self.write_back(card)?;
        }
        self.count_is_cleared = true;
        Ok(())
    }
}
