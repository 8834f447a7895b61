//! Cards for the emulated board, formatted and read by another implementation of FAT than the vehicle's: `fatfs`.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use emulated_board::{Content, Flight, Pauses, SdCard};
use fatfs::{FatType, FileSystem, FsOptions};

/// A card with an empty file system: 32 MB of FAT16, or 272 of FAT32, which has 65,525 clusters at least.
pub fn formatted(fat_type: FatType) -> Content {
    let megabytes = if fat_type == FatType::Fat32 { 272 } else { 32 };
    Content::formatted(fat_type, megabytes << 20)
}

/// Puts a card into the slot.
pub fn insert(flight: &mut Flight, content: Content, pauses: Pauses) {
    flight.machine.insert_card(SdCard::new(content, pauses, 1));
}

/// All files of the card's root directory.
pub fn files(flight: &mut Flight) -> BTreeMap<String, Vec<u8>> {
    let image = flight.machine.with_card(|card| card.content().image()).expect("a card");
    files_of(image)
}

/// The same of an image.
pub fn files_of(image: Vec<u8>) -> BTreeMap<String, Vec<u8>> {
    let volume = FileSystem::new(Cursor::new(image), FsOptions::new()).unwrap();
    let entries = volume.root_dir().iter().map(Result::unwrap);
    entries
        .map(|entry| {
            let mut content = Vec::new();
            entry.to_file().read_to_end(&mut content).unwrap();
            (entry.file_name(), content)
        })
        .collect()
}
