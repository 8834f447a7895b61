//! Logs on cards that another implementation of FAT has formatted and reads again: the crate `fatfs`.

extern crate std;

mod cuts;
mod nonsense;

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};
use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;

use fatfs::{FatType, FileSystem, FormatVolumeOptions, FsOptions};

use super::*;
use crate::link::LogStore;

const MEGABYTE: usize = 1 << 20;

/// A card in memory.
#[derive(Clone)]
pub(super) struct Memory {
    pub(super) bytes: Vec<u8>,
    /// All that was written, in order.
    pub(super) writes: Vec<(u32, Vec<u8>)>,
    /// After so many more writes it fails.
    pub(super) writes_left: usize,
}

impl Memory {
    /// With a file system of this type from this sector on.
    pub(super) fn formatted(fat_type: FatType, megabytes: usize, start_sector: usize) -> Self {
        let (start, cluster_bytes) = (start_sector * 512, if fat_type == FatType::Fat32 { 512 } else { 4096 });
        let mut bytes = vec![0; megabytes * MEGABYTE];
        let options = FormatVolumeOptions::new().fat_type(fat_type).bytes_per_cluster(cluster_bytes);
        fatfs::format_volume(Cursor::new(&mut bytes[start..]), options).unwrap();
        if start > 0 {
            bytes[446 + 4] = 0x0c;
            bytes[454..458].copy_from_slice(&(start_sector as u32).to_le_bytes());
            bytes[510..512].copy_from_slice(&[0x55, 0xaa]);
        }
        Self { bytes, writes: Vec::new(), writes_left: usize::MAX }
    }
}

impl Sectors for Memory {
    fn read(&mut self, number: u32, sector: &mut Sector) -> Result<(), CardError> {
        let at = number as usize * 512;
        sector.copy_from_slice(self.bytes.get(at..at + 512).ok_or(CardError::Failed)?);
        Ok(())
    }

    fn write(&mut self, number: u32, bytes: &[u8]) -> Result<(), CardError> {
        let at = number as usize * 512;
        assert!(!bytes.is_empty() && bytes.len().is_multiple_of(512));
        self.writes_left = self.writes_left.checked_sub(1).ok_or(CardError::Failed)?;
        self.bytes.get_mut(at..at + bytes.len()).ok_or(CardError::Failed)?.copy_from_slice(bytes);
        self.writes.push((number, bytes.to_vec()));
        Ok(())
    }
}

/// All files of the root directory, as `fatfs` reads them.
pub(super) fn files(bytes: &mut [u8]) -> BTreeMap<String, Vec<u8>> {
    let volume = FileSystem::new(Cursor::new(bytes), FsOptions::new()).unwrap();
    let entries = volume.root_dir().iter().map(Result::unwrap).filter(|entry| entry.is_file());
    entries
        .map(|entry| {
            let mut content = Vec::new();
            entry.to_file().read_to_end(&mut content).unwrap();
            (entry.file_name().to_string(), content)
        })
        .collect()
}

/// Bytes that say where they stand.
pub(super) fn stream(length: usize) -> Vec<u8> {
    (0..length as u32).map(|at| (at ^ at >> 8 ^ at >> 16) as u8).collect()
}

/// A log of these bytes, in pieces of `piece` bytes, flushed now and then.
fn write_log(log: &mut CardLog, card: &mut Memory, bytes: &[u8], piece: usize) -> Result<LogName, CardError> {
    let name = log.begin(card, 0)?;
    for (now, piece) in bytes.chunks(piece).enumerate() {
        log.append(card, piece)?;
        if now % 17 == 16 {
            log.flush(card, now as u64)?;
        }
    }
    log.end(card, 0)?;
    Ok(name)
}

fn kinds() -> [(FatType, usize, usize); 3] {
    [(FatType::Fat16, 24, 0), (FatType::Fat32, 40, 0), (FatType::Fat32, 41, 2048)]
}

#[test]
fn logs_are_read_by_another_implementation_and_other_files_stay() {
    for (fat_type, megabytes, start) in kinds() {
        let mut card = Memory::formatted(fat_type, megabytes, start);
        let photo = stream(70_000);
        {
            let volume = FileSystem::new(Cursor::new(&mut card.bytes[start * 512..]), FsOptions::new()).unwrap();
            let root = volume.root_dir();
            root.create_file("a photo with a long name.jpeg").unwrap().write_all(&photo).unwrap();
            root.create_dir("folder").unwrap();
        }
        let lengths = [0, 1, 511, 512, 513, 4096, 4097, 300_000, 12_345];
        for (number, length) in (1..).zip(lengths) {
            // each as after a start
            let mut log = CardLog::mount(&mut card).unwrap();
            assert_eq!(write_log(&mut log, &mut card, &stream(length), 333), Ok(LogName(number)), "{length}");
        }
        let found = files(&mut card.bytes[start * 512..]);
        assert_eq!(found["a photo with a long name.jpeg"], photo);
        for (number, length) in (1..).zip(lengths) {
            assert_eq!(found[&std::format!("LOG{number:05}.ULG")], stream(length), "{fat_type:?} {number}");
        }
        assert_eq!(found.len(), 1 + lengths.len());
    }
}

#[test]
fn what_was_taken_and_not_needed_is_free_again() {
    for (fat_type, megabytes, start) in kinds() {
        let mut card = Memory::formatted(fat_type, megabytes, start);
        let free = |card: &mut Memory| {
            let volume = FileSystem::new(Cursor::new(&mut card.bytes[start * 512..]), FsOptions::new()).unwrap();
            let stats = volume.stats().unwrap();
            (stats.free_clusters(), stats.cluster_size())
        };
        let (before, cluster_bytes) = free(&mut card);
        let mut log = CardLog::mount(&mut card).unwrap();
        write_log(&mut log, &mut card, &stream(100_000), 1000).unwrap();
        let (after, _) = free(&mut card);
        assert_eq!(before - after, 100_000_u32.div_ceil(cluster_bytes), "{fat_type:?}");
        // the second FAT is as the first
        let boot = &card.bytes[start * 512..];
        let (short, long) = (u16_at(boot, 22), u32_at(boot, 36));
        let bytes = 512 * if short == 0 { long } else { u32::from(short) } as usize;
        let fat = 512 * usize::from(u16_at(boot, 14));
        assert_eq!(boot[16], 2);
        assert!(boot[fat..fat + bytes] == boot[fat + bytes..fat + 2 * bytes], "{fat_type:?}");
    }
}

#[test]
fn a_full_card_says_so_and_keeps_what_it_has() {
    let mut card = Memory::formatted(FatType::Fat16, 24, 0);
    let mut log = CardLog::mount(&mut card).unwrap();
    let bytes = stream(25 * MEGABYTE);
    assert_eq!(write_log(&mut log, &mut card, &bytes, 4000), Err(CardError::Full));
    let kept = &files(&mut card.bytes)["LOG00001.ULG"];
    assert!(kept.len() > 22 * MEGABYTE && bytes.starts_with(kept), "{}", kept.len());
    assert_eq!(CardLog::mount(&mut card).err(), Some(CardError::Full));
}

#[test]
fn a_directory_that_is_full_becomes_longer_where_it_can() {
    let mut card = Memory::formatted(FatType::Fat32, 40, 0);
    let mut log = CardLog::mount(&mut card).unwrap();
    // 16 entries in a cluster of one sector
    for number in 1..=40 {
        assert_eq!(write_log(&mut log, &mut card, b"log", 1), Ok(LogName(number)));
    }
    assert_eq!(files(&mut card.bytes).len(), 40);
    let mut card = Memory::formatted(FatType::Fat16, 24, 0);
    let mut log = CardLog::mount(&mut card).unwrap();
    let refused = (1..=513).find_map(|_| write_log(&mut log, &mut card, b"log", 1).err());
    assert_eq!(refused, Some(CardError::NoName));
}

#[test]
fn the_number_is_one_more_than_the_highest() {
    let mut card = Memory::formatted(FatType::Fat16, 24, 0);
    {
        let volume = FileSystem::new(Cursor::new(&mut card.bytes), FsOptions::new()).unwrap();
        for name in ["LOG00007.ULG", "LOG00003.ULG", "LOG99.ULG", "LOG0000X.ULG"] {
            volume.root_dir().create_file(name).unwrap();
        }
    }
    let mut log = CardLog::mount(&mut card).unwrap();
    assert_eq!(write_log(&mut log, &mut card, b"log", 1), Ok(LogName(8)));
}

#[test]
fn cards_without_fat16_or_fat32_are_named() {
    let mut blank = Memory { bytes: vec![0; MEGABYTE], writes: Vec::new(), writes_left: usize::MAX };
    assert_eq!(CardLog::mount(&mut blank).err(), Some(CardError::UnknownFormat));
    // exFAT has a boot sector with its signature and no bytes per sector
    blank.bytes[..11].copy_from_slice(b"\xeb\x76\x90EXFAT   ");
    blank.bytes[510..512].copy_from_slice(&[0x55, 0xaa]);
    assert_eq!(CardLog::mount(&mut blank).err(), Some(CardError::UnknownFormat));
    let mut small = Memory::formatted(FatType::Fat12, 2, 0);
    assert_eq!(CardLog::mount(&mut small).err(), Some(CardError::UnknownFormat));
}

#[test]
fn logs_are_listed_by_age_and_read_from_anywhere() {
    for (fat_type, megabytes, start) in kinds() {
        let mut card = Memory::formatted(fat_type, megabytes, start);
        let mut log = CardLog::mount(&mut card).unwrap();
        let lengths = [100_001, 5, 0];
        for length in lengths {
            write_log(&mut log, &mut card, &stream(length), 777).unwrap();
        }
        let mut shelf = log.list(&mut card).unwrap();
        assert_eq!(shelf.count(), 3);
        assert_eq!([0, 1, 2, 3].map(|id| shelf.size_bytes(id)), [100_001, 5, 0, 0]);
        for offset in [0, 1, 450, 511, 512, 90_000, 7, 99_999, 100_000, 100_001, 200_000] {
            let whole = stream(100_001);
            let expected = &whole[offset.min(100_001)..(offset + 90).min(100_001)];
            let mut window = [0; WINDOW_BYTES];
            if !shelf.is_ready(0, offset as u32) {
                let wanted = shelf.wanted().unwrap();
                let count = log.fetch(&mut card, &wanted, &mut window).unwrap();
                shelf.bring(wanted, &window[..count]);
            }
            let mut piece = [0; 90];
            assert!(shelf.is_ready(0, offset as u32));
            let count = shelf.read(0, offset as u32, &mut piece);
            assert_eq!(&piece[..count], expected, "{fat_type:?} {offset}");
        }
    }
}

#[test]
fn of_many_logs_the_newest_are_listed() {
    let mut card = Memory::formatted(FatType::Fat32, 40, 0);
    let mut log = CardLog::mount(&mut card).unwrap();
    for number in 1..=70 {
        write_log(&mut log, &mut card, &stream(number), 9).unwrap();
    }
    let mut shelf = log.list(&mut card).unwrap();
    assert_eq!((shelf.count(), shelf.size_bytes(0), shelf.size_bytes(63)), (64, 7, 70));
}
