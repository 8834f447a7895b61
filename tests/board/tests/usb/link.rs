//! MAVLink over USB: heartbeats, parameters, a flight's log, the key.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use emulated_board::{Content, Flight, Ground, MILLISECOND, Pauses, SdCard};
use fatfs::{FatType, FileSystem, FsOptions};
use mavlink::dialects::common::{LOG_REQUEST_DATA_DATA, MavCmd, PARAM_REQUEST_READ_DATA, SETUP_SIGNING_DATA};
use shared_control::params::Params;

use crate::{run, with_usb};

fn heard(ground: &Ground, words: &str) -> bool {
    ground.texts().iter().any(|(_, text)| text.contains(words))
}

#[test]
fn both_ports_hear_and_answer() {
    let (mut flight, mut ground) = with_usb(&Params::DEFAULT);
    run(&mut flight, &mut ground, 3000);
    let before = (ground.heartbeats(), flight.ground.heartbeats());
    run(&mut flight, &mut ground, 3000);
    let beats = (ground.heartbeats() - before.0, flight.ground.heartbeats() - before.1);
    assert!((2..=4).contains(&beats.0) && (2..=4).contains(&beats.1), "{beats:?}");
    let request = PARAM_REQUEST_READ_DATA {
        param_index: -1,
        target_system: 1,
        target_component: 1,
        param_id: "LOOP_RATE_HZ".into(),
    };
    ground.send(&mut flight.machine, &request);
    run(&mut flight, &mut ground, 500);
    assert_eq!(ground.parameter("LOOP_RATE_HZ"), Some(400.0), "{:?}", ground.texts());
    // a command over USB moves the vehicle, as one over TELEM1 does
    ground.command(&mut flight.machine, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    run(&mut flight, &mut ground, 500);
    assert!(flight.is_armed(), "{:?}", ground.texts());
    assert_eq!((flight.counter("LOOP_OVERRUNS"), flight.counter("USB_DROPPED")), (0, 0));
}

fn card() -> SdCard {
    SdCard::new(Content::formatted(FatType::Fat16, 32 << 20), Pauses::USUAL, 1)
}

fn file(flight: &mut Flight, name: &str) -> Vec<u8> {
    let image = flight.machine.with_card(|card| card.content().image()).expect("a card");
    let volume = FileSystem::new(Cursor::new(image), FsOptions::new()).unwrap();
    let mut content = Vec::new();
    volume.root_dir().open_file(name).unwrap().read_to_end(&mut content).unwrap();
    content
}

/// As a ground station does it: all of it, and then what has not come, until there is no gap.
#[test]
fn a_flights_log_is_fetched_whole() {
    let (mut flight, mut ground) = with_usb(&Params::DEFAULT);
    flight.machine.insert_card(card());
    run(&mut flight, &mut ground, 4000);
    ground.command(&mut flight.machine, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    run(&mut flight, &mut ground, 700);
    ground.command(&mut flight.machine, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    run(&mut flight, &mut ground, 2500);
    let whole = file(&mut flight, "LOG00001.ULG");
    let (target_system, target_component) = (1, 1);
    let from = LOG_REQUEST_DATA_DATA { ofs: 0, count: u32::MAX, id: 0, target_system, target_component };
    ground.send(&mut flight.machine, &from);
    let begin = flight.machine.now();
    let mut got: BTreeMap<u32, Vec<u8>> = BTreeMap::new();
    for _ in 0..200 {
        run(&mut flight, &mut ground, 100);
        got = ground.log_data().iter().map(|((_, offset), piece)| (*offset, piece.clone())).collect();
        if got.values().map(Vec::len).sum::<usize>() >= whole.len() {
            break;
        }
    }
    let took_ms = (flight.machine.now() - begin) / MILLISECOND;
    let fetched: Vec<u8> = got.into_values().flatten().collect();
    println!("{} bytes in {took_ms} ms: {} bytes/s", fetched.len(), 1000 * fetched.len() as u64 / took_ms);
    assert!(fetched == whole, "{} of {} bytes", fetched.len(), whole.len());
    assert!(flight.ground.log_data().is_empty(), "TELEM1 got what USB asked for");
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
}

/// TELEM1 may be a radio, whoever is on it; a cable is somebody beside the vehicle.
#[test]
fn a_key_is_taken_over_usb_alone() {
    let (mut flight, mut ground) = with_usb(&Params::DEFAULT);
    run(&mut flight, &mut ground, 3000);
    let setup = |key: u8| SETUP_SIGNING_DATA {
        initial_timestamp: 37_500_000_000_000,
        target_system: 1,
        target_component: 1,
        secret_key: [key; 32],
    };
    flight.ground.send(&mut flight.machine, &setup(1));
    run(&mut flight, &mut ground, 500);
    assert!(heard(&ground, "signing not changed: only by cable"), "{:?}", ground.texts());
    let arms = |flight: &mut Flight, ground: &mut Ground| {
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        run(flight, ground, 500);
        flight.is_armed()
    };
    assert!(arms(&mut flight, &mut ground));
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    run(&mut flight, &mut ground, 500);
    ground.send(&mut flight.machine, &setup(2));
    run(&mut flight, &mut ground, 500);
    assert!(heard(&ground, "key stored"), "{:?}", ground.texts());
    assert!(!arms(&mut flight, &mut ground), "without a signature");
    // without the key: another one, by the cable alone
    flight.ground.send(&mut flight.machine, &setup(3));
    run(&mut flight, &mut ground, 500);
    ground.send(&mut flight.machine, &SETUP_SIGNING_DATA { secret_key: [0; 32], ..setup(0) });
    run(&mut flight, &mut ground, 500);
    assert!(heard(&ground, "signing ended"), "{:?}", ground.texts());
    assert!(arms(&mut flight, &mut ground));
}
