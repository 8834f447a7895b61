//! The card's logs over TELEM1: listed, and bytes from anywhere.

use emulated_board::{Flight, MILLISECOND, Pauses};
use fatfs::FatType;
use mavlink::dialects::common::{LOG_ERASE_DATA, LOG_REQUEST_DATA_DATA, LOG_REQUEST_LIST_DATA, MavCmd};

use crate::card::files;
use crate::{PID, heard, with_card};

/// What was asked for, put together; pieces must lie side by side.
fn received(flight: &Flight, id: u16, first: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    for ((_, offset), piece) in flight.ground.log_data().range((id, first)..(id, u32::MAX)) {
        assert_eq!(*offset, first + bytes.len() as u32, "a gap");
        bytes.extend_from_slice(piece);
    }
    bytes
}

#[test]
fn a_log_on_the_card_can_be_fetched_over_the_link() {
    let mut flight = with_card(&PID, FatType::Fat16, Pauses::USUAL);
    flight.run_for(3500 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(700 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flight.run_for(2500 * MILLISECOND);
    let whole = files(&mut flight)["LOG00001.ULG"].clone();

    let (target_system, target_component) = (1, 1);
    let list = LOG_REQUEST_LIST_DATA { start: 0, end: u16::MAX, target_system, target_component };
    flight.ground.send(&mut flight.machine, &list);
    flight.run_for(500 * MILLISECOND);
    let listed: Vec<_> = flight.ground.log_entries().iter().map(|log| (log.id, log.num_logs, log.size)).collect();
    assert_eq!(listed, [(0, 1, whole.len() as u32)]);

    // across sectors and clusters, and the end of the log
    for (ofs, count) in [(3_900, 4_500), (whole.len() as u32 - 1_000, u32::MAX)] {
        let data = LOG_REQUEST_DATA_DATA { ofs, count, id: 0, target_system, target_component };
        flight.ground.send(&mut flight.machine, &data);
        flight.run_for(3000 * MILLISECOND);
        let first = ofs as usize;
        let wanted = &whole[first..first.saturating_add(count as usize).min(whole.len())];
        let got = received(&flight, 0, ofs);
        assert!(got.starts_with(wanted), "{} of {} bytes from {ofs} on", got.len(), wanted.len());
        assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
        if ofs == 3_900 {
            flight.ground.forget_log_data();
        }
    }
    flight.ground.send(&mut flight.machine, &LOG_ERASE_DATA { target_system, target_component });
    flight.run_for(500 * MILLISECOND);
    assert!(heard(&flight, "logs stay on the SD card"), "{:?}", flight.ground.texts());
    assert_eq!(files(&mut flight)["LOG00001.ULG"], whole);
}
