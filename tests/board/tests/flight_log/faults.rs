//! What may happen to a card: the flight goes on, and it is said in words.

use emulated_board::{CardFault, Flight, MILLISECOND, Pauses, SECTOR_BYTES, SdCard, Sector};
use fatfs::FatType;
use mavlink::dialects::common::MavCmd;
use shared_control::params::Params;

use crate::card::{files, files_of, formatted, insert};
use crate::{PID, fly, heard, with_card};

/// What happens to a card.
type Event = fn(&mut SdCard);

/// In flight for two seconds, then this happens to the card, then two seconds more.
fn flown_through(params: &Params, event: impl FnOnce(&mut SdCard)) -> Flight {
    let mut flight = with_card(params, FatType::Fat16, Pauses { long_one_in: 0, ..Pauses::USUAL });
    flight.take_off();
    flight.run_for(2000 * MILLISECOND);
    flight.machine.with_card(event);
    flight.run_for(2000 * MILLISECOND);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
    let delay = flight.vehicle.borrow().delays().range();
    assert_eq!(delay.map(|(shortest, longest)| longest - shortest), Some(0), "pulses are late");
    flight
}

/// Bytes of whole steps and the head, from which a log that ends early may still be read.
fn begins_like(log: &[u8], flight: &Flight, least: usize) {
    let steps = flight.twin.recorded();
    let at = log.windows(64).position(|window| window == &steps[..64]).expect("the first step");
    assert!(log.len() - at >= least, "{} bytes of steps", log.len() - at);
    assert!(steps.starts_with(&log[at..]), "other bytes than the host's");
}

#[test]
fn a_card_that_fails_in_flight_ends_the_log_in_words_and_nothing_else() {
    let faults: [(&str, Event); 4] = [
        ("removed", SdCard::remove),
        ("write error", |card| card.set_fault(Some(CardFault::WriteError))),
        ("refused", |card| card.set_fault(Some(CardFault::BlocksRefused))),
        ("busy", |card| card.set_fault(Some(CardFault::BusyForEver))),
    ];
    for (name, fault) in faults {
        let mut flight = flown_through(&PID, fault);
        assert!(heard(&flight, "SD card failed: no log"), "{name}: {:?}", flight.ground.texts());
        let found = files(&mut flight);
        // the size was written in the second before, at 79 kB/s and more
        begins_like(&found["LOG00001.ULG"], &flight, 80_000);
    }
}

/// Each write takes 250 ms: far too slow for the log. What is on the card says what is missing.
#[test]
fn a_card_that_is_too_slow_loses_steps_that_are_counted() {
    let mut flight = with_card(&PID, FatType::Fat16, Pauses { long_one_in: 0, ..Pauses::USUAL });
    flight.run_for(3000 * MILLISECOND);
    flight.machine.with_card(|card| card.set_pauses(Pauses::SLOWEST));
    fly_slowly(&mut flight);
    let left_out = flight.counter("LOG_STEPS_LEFT_OUT");
    assert!(left_out > 100, "{left_out}");
    assert!(heard(&flight, &format!("SD card too slow: {left_out} steps not in log")), "{:?}", flight.ground.texts());
    let log = &files(&mut flight)["LOG00001.ULG"];
    // a dropout, section "Dropout message" of the format: length 2, type O
    assert!(log.windows(3).any(|window| window == [2, 0, b'O']));
    sil_host::log::parse_bytes(std::path::Path::new("log.ulg"), log.clone(), None).unwrap();
}

fn fly_slowly(flight: &mut Flight) {
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(4000 * MILLISECOND);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    // 64 Kbyte at 16 per second
    flight.run_for(9000 * MILLISECOND);
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
}

/// No card, and one that has no file system that is known.
#[test]
fn without_a_card_that_can_be_written_it_flies_all_the_same() {
    let mut none = Flight::new(&PID, 1);
    fly(&mut none, 500);
    let said = none.ground.texts().iter().filter(|(_, text)| text == "no SD card: no log").count();
    assert_eq!(said, 1, "{:?}", none.ground.texts());
    let mut blank = Flight::new(&PID, 1);
    insert(&mut blank, emulated_board::Content::blank(65_536), Pauses::USUAL);
    fly(&mut blank, 500);
    assert!(heard(&blank, "SD card not FAT16 or FAT32: no log"), "{:?}", blank.ground.texts());
}

/// Power is cut after each write to the card: the file system can be read, and the log as far as a second before.
#[test]
fn power_may_be_cut_after_any_write() {
    let before = formatted(FatType::Fat16);
    let mut flight = with_card(&PID, FatType::Fat16, Pauses::USUAL);
    flight.run_for(3000 * MILLISECOND);
    flight.machine.with_card(|card| card.content_mut().forget_writes());
    fly(&mut flight, 1500);
    let writes: Vec<(u32, Sector)> = flight.machine.with_card(|card| card.content().writes().to_vec()).unwrap();
    let whole = files(&mut flight)["LOG00001.ULG"].clone();
    let mut image = before.image();
    let mut longest = 0;
    for (number, (sector, bytes)) in writes.iter().enumerate() {
        let at = *sector as usize * SECTOR_BYTES;
        // in the middle of the sector, then all of it
        for cut in [SECTOR_BYTES / 2, SECTOR_BYTES] {
            image[at..at + cut].copy_from_slice(&bytes[..cut]);
            if number % 20 != 0 && bytes[0] != b'L' {
                continue;
            }
            let found = files_of(image.clone());
            let log = found.get("LOG00001.ULG").cloned().unwrap_or_default();
            assert!(whole.starts_with(&log), "write {number}: {} bytes, and not the log's", log.len());
            assert!(log.len() >= longest, "write {number}: the log became shorter");
            longest = log.len();
        }
    }
    assert_eq!(longest, whole.len());
    println!("{} sector writes, {} bytes", writes.len(), whole.len());
}
