//! Power is cut at every write, in the middle of a sector too: the file system can be read and the log is as far as its
//! size says.

extern crate std;

use std::vec::Vec;

use fatfs::FatType;

use super::{Memory, files, stream};
use crate::log_card::CardLog;

const LENGTH: usize = 180_000;
const PIECE: usize = 700;
/// Pieces between two flushes.
const FLUSHED: usize = 23;

/// A log on top of another, with a directory that becomes longer; after each write how much of it was flushed before.
fn flight(card: &mut Memory) -> Vec<usize> {
    let mut log = CardLog::mount(card).unwrap();
    for _ in 0..15 {
        log.begin(card, 0).unwrap();
        log.append(card, b"before").unwrap();
        log.end(card, 0).unwrap();
    }
    card.writes.clear();
    let bytes = stream(LENGTH);
    let mut flushed = Vec::new();
    log.begin(card, 0).unwrap();
    flushed.resize(card.writes.len(), 0);
    for (number, piece) in (1..).zip(bytes.chunks(PIECE)) {
        log.append(card, piece).unwrap();
        let before = flushed.last().copied().unwrap_or_default();
        flushed.resize(card.writes.len(), before);
        if number % FLUSHED == 0 {
            log.flush(card, 0).unwrap();
            // during the flush only what was there before is promised
            flushed.resize(card.writes.len(), before);
            if let Some(last) = flushed.last_mut() {
                *last = (number * PIECE).min(LENGTH);
            }
        }
    }
    let before = flushed.last().copied().unwrap_or_default();
    log.end(card, 0).unwrap();
    flushed.resize(card.writes.len(), before);
    flushed
}

fn check(bytes: &mut [u8], promised: usize, whole: &[u8], about: &str) {
    let found = files(bytes);
    for number in 1..=15 {
        assert_eq!(found[&std::format!("LOG{number:05}.ULG")], b"before", "{about}");
    }
    match found.get("LOG00016.ULG") {
        None => assert_eq!(promised, 0, "{about}"),
        Some(log) => {
            assert!(log.len() >= promised, "{about}: {} of {promised} bytes", log.len());
            assert!(whole.starts_with(log), "{about}: {} bytes, and not those of the log", log.len());
        }
    }
}

#[test]
fn power_may_be_cut_at_any_byte_of_any_write() {
    for (fat_type, megabytes) in [(FatType::Fat16, 24), (FatType::Fat32, 40)] {
        let mut card = Memory::formatted(fat_type, megabytes, 0);
        let before = card.bytes.clone();
        let flushed = flight(&mut card);
        let (writes, whole) = (std::mem::take(&mut card.writes), stream(LENGTH));
        assert!(writes.len() > 60 && flushed.len() == writes.len());
        // what was there before the log
        card.bytes = before;
        flight_before(&mut card);
        let mut promised = 0;
        for (number, (sector, bytes)) in writes.iter().enumerate() {
            let at = *sector as usize * 512;
            // the card keeps so many bytes of it: about a dozen places of each sector, and its ends
            let cuts = (0..bytes.len()).filter(|cut| cut % 41 == 0 || cut % 512 < 2 || cut % 512 > 510);
            let old = card.bytes[at..at + bytes.len()].to_vec();
            // a write of many sectors is data, whose size is not written yet: a few cuts show it
            for cut in cuts.step_by(if bytes.len() > 512 { 16 } else { 1 }) {
                card.bytes[at..at + cut].copy_from_slice(&bytes[..cut]);
                let about = std::format!("{fat_type:?}, write {number} to sector {sector}, cut at byte {cut}");
                check(&mut card.bytes, promised, &whole, &about);
                card.bytes[at..at + cut].copy_from_slice(&old[..cut]);
            }
            card.bytes[at..at + bytes.len()].copy_from_slice(bytes);
            promised = flushed[number];
            check(&mut card.bytes, promised, &whole, &std::format!("{fat_type:?}, after write {number}"));
        }
        assert_eq!(files(&mut card.bytes)["LOG00016.ULG"], whole);
    }
}

fn flight_before(card: &mut Memory) {
    let mut log = CardLog::mount(card).unwrap();
    for _ in 0..15 {
        log.begin(card, 0).unwrap();
        log.append(card, b"before").unwrap();
        log.end(card, 0).unwrap();
    }
}

/// After the cut the vehicle starts again and writes another log beside the one that was cut off.
#[test]
fn after_a_cut_the_next_start_logs_on() {
    let mut card = Memory::formatted(FatType::Fat32, 40, 0);
    let mut log = CardLog::mount(&mut card).unwrap();
    log.begin(&mut card, 0).unwrap();
    log.append(&mut card, &stream(50_000)).unwrap();
    log.flush(&mut card, 0).unwrap();
    let mut again = CardLog::mount(&mut card).unwrap();
    again.begin(&mut card, 0).unwrap();
    again.append(&mut card, b"again").unwrap();
    again.end(&mut card, 0).unwrap();
    let found = files(&mut card.bytes);
    assert_eq!(found["LOG00001.ULG"], stream(50_000));
    assert_eq!(found["LOG00002.ULG"], b"again");
}
