//! What a card holds: sectors, and the order in which they were written.

use std::collections::BTreeMap;
use std::io::Cursor;

use fatfs::{FatType, FormatVolumeOptions};

/// A sector, the only block that a high capacity card knows.
pub const SECTOR_BYTES: usize = 512;
/// Its bytes.
pub type Sector = [u8; SECTOR_BYTES];

/// Cards in use have clusters of 4 Kbyte and more.
const CLUSTER_BYTES: u32 = 4096;

/// The sectors of a card. What was never written reads as zeros.
#[derive(Clone, Debug)]
pub struct Content {
    sectors: u32,
    held: BTreeMap<u32, Sector>,
    /// Every write since [`Content::forget_writes`], oldest first.
    writes: Vec<(u32, Sector)>,
}

impl Content {
    /// A blank one of so many sectors.
    pub fn blank(sectors: u32) -> Self {
        Self { sectors, held: BTreeMap::new(), writes: Vec::new() }
    }

    /// One that holds an image, whose length is a whole number of sectors.
    ///
    /// # Panics
    /// If it isn't, or the image has more sectors than a card can.
    pub fn of_image(image: &[u8]) -> Self {
        let (sectors, rest) = image.as_chunks::<SECTOR_BYTES>();
        assert!(rest.is_empty(), "{} bytes are no whole number of sectors", image.len());
        let held = (0..).zip(sectors).filter(|(_, sector)| sector.iter().any(|byte| *byte != 0));
        let held = held.map(|(number, sector)| (number, *sector)).collect();
        Self { sectors: u32::try_from(sectors.len()).expect("a card's size"), held, writes: Vec::new() }
    }

    /// One of so many bytes with an empty file system, made by another implementation of FAT than the vehicle's.
    ///
    /// # Panics
    /// If a file system of that type has no such size.
    pub fn formatted(fat_type: FatType, bytes: usize) -> Self {
        let mut image = vec![0; bytes];
        let options = FormatVolumeOptions::new().fat_type(fat_type).bytes_per_cluster(CLUSTER_BYTES);
        fatfs::format_volume(Cursor::new(&mut image), options).expect("a size that the file system has");
        Self::of_image(&image)
    }

    /// How many sectors there are.
    pub fn sectors(&self) -> u32 {
        self.sectors
    }

    /// One of them.
    pub fn read(&self, number: u32) -> Sector {
        self.held.get(&number).copied().unwrap_or([0; SECTOR_BYTES])
    }

    pub(super) fn write(&mut self, number: u32, sector: &Sector) {
        self.held.insert(number, *sector);
        self.writes.push((number, *sector));
    }

    /// All of it.
    pub fn image(&self) -> Vec<u8> {
        (0..self.sectors).flat_map(|number| self.read(number)).collect()
    }

    /// The writes since the last call of [`Content::forget_writes`], oldest first.
    pub fn writes(&self) -> &[(u32, Sector)] {
        &self.writes
    }

    /// What is written from here on counts as the first.
    pub fn forget_writes(&mut self) {
        self.writes.clear();
    }
}
