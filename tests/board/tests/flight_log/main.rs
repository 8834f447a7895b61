//! The flight log on the emulated board's SD card: what is on the card is what was flown, and whatever the card does
//! the flight does not notice.

mod card;
mod cost;
mod download;
mod faults;

use std::path::Path;

use card::{files, formatted, insert};
use emulated_board::time::TICKS_PER_US;
use emulated_board::{Flight, MILLISECOND, Pauses};
use fatfs::FatType;
use mavlink::dialects::common::MavCmd;
use shared_control::config::Controller;
use shared_control::onboard_log::Recorder;
use shared_control::params::Params;

const MPC: Params = Params { controller: Controller::Mpc, ..Params::DEFAULT };
const PID: Params = Params::DEFAULT;

/// At power-on, with a card.
pub fn with_card(params: &Params, fat_type: FatType, pauses: Pauses) -> Flight {
    let mut flight = Flight::new(params, 1);
    insert(&mut flight, formatted(fat_type), pauses);
    flight
}

/// Flies for so long and ends the flight, so that the log is complete.
pub fn fly(flight: &mut Flight, duration_ms: u64) {
    flight.take_off();
    flight.run_for(duration_ms * MILLISECOND);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flight.run_for(2500 * MILLISECOND);
    assert!(!flight.is_armed());
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
    assert_eq!(flight.machine.counters().resets, 0, "{:?}", flight.ground.texts());
}

/// Has the board said that?
pub fn heard(flight: &Flight, words: &str) -> bool {
    flight.ground.texts().iter().any(|(_, text)| text.contains(words))
}

/// With a card's usual pauses, up to 250 ms, every byte of every step is there, as the host's core has recorded it.
#[test]
fn the_log_on_the_card_is_what_was_flown() {
    for (params, fat_type) in [(MPC, FatType::Fat16), (PID, FatType::Fat32)] {
        let mut flight = with_card(&params, fat_type, Pauses::USUAL);
        fly(&mut flight, 4000);
        assert!(heard(&flight, "log 1 on the SD card"), "{:?}", flight.ground.texts());
        assert_eq!(flight.counter("LOG_STEPS_LEFT_OUT"), 0);
        let found = files(&mut flight);
        let (log, steps) = (&found["LOG00001.ULG"], flight.twin.recorded());
        println!("{} bytes on the card, {} of steps", log.len(), steps.len());
        assert!(log.ends_with(steps), "the card's log does not end with the host's");
        let head = &log[..log.len() - steps.len()];
        for topic in Recorder::<1024>::TOPICS {
            let named = head.windows(topic.name.len()).filter(|name| *name == topic.name.as_bytes()).count();
            assert!(named >= 2, "{} is not described and subscribed", topic.name);
        }
        // as whoever opens the file reads it
        let read = sil_host::log::parse_bytes(Path::new("log.ulg"), log.clone(), None).unwrap();
        let logged_s = read.time_s[read.time_s.len() - 1] - read.time_s[0];
        let rate_hz = read.time_s.len() as f64 / logged_s;
        println!("{} rows in {logged_s:.3} s", read.time_s.len());
        assert!((rate_hz - 400.0).abs() < 1.0 && logged_s > 5.4 && read.axes == [true; 3], "{rate_hz} Hz");
        let delay = flight.vehicle.borrow().delays().range();
        assert_eq!(delay, Some((500 * TICKS_PER_US, 500 * TICKS_PER_US)), "pulses are late");
        println!("stack {} bytes", flight.stack_used_bytes());
    }
}

/// A board that starts again goes on with the next number, on the ground where a card is put in later, too.
#[test]
fn logs_are_numbered_on_and_a_card_may_come_later() {
    let mut flight = Flight::new(&PID, 1);
    flight.run_for(3500 * MILLISECOND);
    insert(&mut flight, formatted(FatType::Fat16), Pauses::USUAL);
    flight.run_for(2500 * MILLISECOND);
    for number in 1..=2 {
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        flight.run_for(700 * MILLISECOND);
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
        flight.run_for(2500 * MILLISECOND);
        assert!(heard(&flight, &format!("log {number} on the SD card")), "{:?}", flight.ground.texts());
    }
    flight.restart_board();
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(700 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flight.run_for(2500 * MILLISECOND);
    let found = files(&mut flight);
    assert_eq!(found.keys().collect::<Vec<_>>(), ["LOG00001.ULG", "LOG00002.ULG", "LOG00003.ULG"]);
    assert!(found.values().all(|log| log.starts_with(b"ULog")));
}
