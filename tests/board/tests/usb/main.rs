//! USB: the board as a computer's operating system and a ground station on it meet it, and what the flight notices of
//! that.

mod enumeration;
mod faults;
mod link;

use emulated_board::{Flight, Ground, MILLISECOND};
use mavlink::dialects::common::{HEARTBEAT_DATA, MavType};
use shared_control::params::Params;

/// From the plug to a port that can be opened: bouncing contacts, two resets, a dozen requests of 10 ms a stage.
const PLUGGED_MS: u64 = 1000;

/// Puts the plug in, waits until the device is known, and opens the port.
fn plug_and_open(flight: &mut Flight) {
    flight.machine.with_usb(|computer| computer.plug(true));
    flight.run_for(PLUGGED_MS * MILLISECOND);
    flight.machine.with_usb(|computer| {
        assert!(computer.enumerated().is_some(), "{computer:?}");
        computer.open();
    });
    flight.run_for(100 * MILLISECOND);
}

/// At power-on with a cable and a program that has the port open.
fn with_usb(params: &Params) -> (Flight, Ground) {
    let mut flight = Flight::new(params, 1);
    // sensors have their supply, the loop runs
    flight.run_for(500 * MILLISECOND);
    plug_and_open(&mut flight);
    (flight, Ground::on_usb())
}

/// Runs on, with a heartbeat from each ground station.
fn run(flight: &mut Flight, ground: &mut Ground, duration_ms: u64) {
    for _ in 0..duration_ms.div_ceil(100) {
        ground.send(&mut flight.machine, &HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT });
        flight.run_for(100 * MILLISECOND);
        ground.listen(&mut flight.machine);
    }
}
