//! Where on a card the file system lies, and what it is like.

use super::{CardError, Sector, Sectors, u16_at, u32_at};

/// Below so many clusters it is FAT12, which no card of today has ("FAT Type Determination").
const FAT16_CLUSTERS_MIN: u32 = 4085;
/// Below so many FAT16.
const FAT32_CLUSTERS_MIN: u32 = 65_525;
/// FAT32's entries have 28 bits, of which the highest values are marks.
const CLUSTERS_MAX: u32 = 0x0fff_fff0;
/// Types of a partition that has a FAT.
const FAT_PARTITIONS: [u8; 5] = [0x04, 0x06, 0x0b, 0x0c, 0x0e];

/// Which of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// 16 bits an entry, the root directory has a place of its own.
    Fat16,
    /// 32 bits an entry, the root directory is a file.
    Fat32,
}

/// A file system, in sectors of the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) kind: Kind,
    /// First sector of the first FAT.
    pub(super) fat: u32,
    /// Sectors of a FAT, and how many FATs there are, 1 or 2.
    pub(super) fat_sectors: u32,
    pub(super) fats: u32,
    /// FAT16's root directory, and how many sectors it has.
    pub(super) root: u32,
    pub(super) root_sectors: u32,
    /// FAT32's root directory.
    pub(super) root_cluster: u32,
    /// First sector of cluster 2.
    pub(super) data: u32,
    /// A cluster has 2 to this power of sectors.
    pub(super) cluster_shift: u32,
    /// The highest cluster.
    pub(super) last_cluster: u32,
    /// FAT32's sector with the count of free clusters, where there is one.
    pub(super) count_sector: Option<u32>,
}

impl Layout {
    /// Looks for it: at the card's first sector, or in the first partition that may have one.
    pub(super) fn find(card: &mut impl Sectors) -> Result<Self, CardError> {
        let mut sector = [0; 512];
        card.read(0, &mut sector)?;
        if !is_signed(&sector) {
            return Err(CardError::UnknownFormat);
        }
        if let Some(layout) = Self::of_boot_sector(&sector, 0)? {
            return Ok(layout);
        }
        let starts = [446, 462, 478, 494].map(|at| {
            let kind = sector.get(at + 4).copied().unwrap_or_default();
            FAT_PARTITIONS.contains(&kind).then(|| u32_at(&sector, at + 8))
        });
        let start = starts.into_iter().flatten().next().ok_or(CardError::UnknownFormat)?;
        card.read(start, &mut sector)?;
        if !is_signed(&sector) {
            return Err(CardError::UnknownFormat);
        }
        Self::of_boot_sector(&sector, start)?.ok_or(CardError::UnknownFormat)
    }

    /// None if it is no boot sector of a FAT.
    fn of_boot_sector(sector: &Sector, start: u32) -> Result<Option<Self>, CardError> {
        let byte = |at: usize| u32::from(sector.get(at).copied().unwrap_or_default());
        let (jump, sectors_per_cluster, fats) = (byte(0), byte(13), byte(16));
        let looks_like_one = [0xeb, 0xe9].contains(&jump)
            && u16_at(sector, 11) == 512
            && sectors_per_cluster.is_power_of_two()
            && (1..=2).contains(&fats);
        if !looks_like_one {
            return Ok(None);
        }
        let either = |short: u16, long: u32| if short == 0 { long } else { u32::from(short) };
        let reserved = u32::from(u16_at(sector, 14));
        let root_sectors = u32::from(u16_at(sector, 17)).div_ceil(16);
        let sectors = either(u16_at(sector, 19), u32_at(sector, 32));
        let fat_sectors = either(u16_at(sector, 22), u32_at(sector, 36));
        let cluster_shift = sectors_per_cluster.trailing_zeros();

        let fat = start.checked_add(reserved);
        let root = fat_sectors.checked_mul(fats).and_then(|all| fat?.checked_add(all));
        let data = root.and_then(|root| root.checked_add(root_sectors));
        let end = start.checked_add(sectors);
        let (Some(fat), Some(root), Some(data), Some(end)) = (fat, root, data, end) else {
            return Err(CardError::Damaged);
        };
        let clusters = end.checked_sub(data).ok_or(CardError::Damaged)? >> cluster_shift;
        let kind = match clusters {
            ..FAT16_CLUSTERS_MIN => return Err(CardError::UnknownFormat),
            FAT16_CLUSTERS_MIN..FAT32_CLUSTERS_MIN => Kind::Fat16,
            FAT32_CLUSTERS_MIN..CLUSTERS_MAX => Kind::Fat32,
            CLUSTERS_MAX.. => return Err(CardError::Damaged),
        };
        let count_sector = match (kind, u32::from(u16_at(sector, 48))) {
            (Kind::Fat32, number) if (1..reserved).contains(&number) => start.checked_add(number),
            _ => None,
        };
        #[rustfmt::skip]
        let layout = Self {
            kind, fat, fat_sectors, fats, root, root_sectors, root_cluster: u32_at(sector, 44), data, cluster_shift,
            last_cluster: clusters + 1, count_sector,
        };
        // a FAT that is too short for its clusters would lead into the next
        if layout.last_cluster >> layout.entries_shift() >= fat_sectors {
            return Err(CardError::Damaged);
        }
        Ok(Some(layout))
    }

    /// A sector of the FAT has 2 to this power of entries.
    pub(super) fn entries_shift(&self) -> u32 {
        match self.kind {
            Kind::Fat16 => 8,
            Kind::Fat32 => 7,
        }
    }

    /// Is it a cluster that a file may have?
    pub(super) fn has_cluster(&self, cluster: u32) -> bool {
        (2..=self.last_cluster).contains(&cluster)
    }

    /// First sector of a cluster.
    pub(super) fn sector_of(&self, cluster: u32) -> Result<u32, CardError> {
        // no overflow: the last cluster ends where the file system does
        if self.has_cluster(cluster) {
            Ok(self.data + ((cluster - 2) << self.cluster_shift))
        } else {
            Err(CardError::Damaged)
        }
    }
}

fn is_signed(sector: &Sector) -> bool {
    u16_at(sector, 510) == 0xaa55
}
