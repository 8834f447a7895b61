//! What a computer or a cable does wrong in flight: the flight does not notice.

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Flight, Ground, MILLISECOND};
use mavlink::dialects::common::MavCmd;
use shared_control::params::Params;

use crate::{PLUGGED_MS, plug_and_open, run};

/// A flight with the port open.
fn in_the_air() -> (Flight, Ground) {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 1);
    plug_and_open(&mut flight);
    (flight, Ground::on_usb())
}

fn assert_nothing_noticed(flight: &mut Flight) {
    let delay = flight.vehicle.borrow().delays().range();
    assert_eq!(delay, Some((500 * TICKS_PER_US, 500 * TICKS_PER_US)), "pulses are late");
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    assert_eq!(flight.machine.counters().resets, 0);
}

/// The port is open and nobody reads it, for 10 s.
#[test]
fn a_computer_that_does_not_read_holds_nothing_up() {
    let (mut flight, mut ground) = in_the_air();
    flight.machine.with_usb(|computer| computer.set_reading(false));
    let before = flight.ground.heartbeats();
    run(&mut flight, &mut ground, 10_000);
    let beats = flight.ground.heartbeats() - before;
    assert!((9..=11).contains(&beats), "{beats} heartbeats on TELEM1 in 10 s");
    let dropped = flight.counter("USB_DROPPED");
    assert!(dropped > 100, "{dropped} dropped");
    assert_nothing_noticed(&mut flight);
    flight.machine.with_usb(|computer| computer.set_reading(true));
    let before = ground.heartbeats();
    run(&mut flight, &mut ground, 3000);
    assert!(ground.heartbeats() >= before + 2, "it is not heard again");
    println!("{dropped} lots of messages lost");
    assert_nothing_noticed(&mut flight);
}

/// Pulled in flight, put in again, the computer asleep and awake.
#[test]
fn a_cable_that_comes_and_goes_is_not_noticed() {
    let (mut flight, mut ground) = in_the_air();
    for _ in 0..2 {
        flight.machine.with_usb(|computer| computer.plug(false));
        flight.run_for(300 * MILLISECOND);
        flight.machine.with_usb(|computer| computer.plug(true));
        flight.run_for(PLUGGED_MS * MILLISECOND);
        flight.machine.with_usb(|computer| {
            assert!(computer.enumerated().is_some());
            computer.open();
        });
    }
    flight.machine.with_usb(|computer| computer.sleep(true));
    flight.run_for(500 * MILLISECOND);
    flight.machine.with_usb(|computer| computer.sleep(false));
    let before = ground.heartbeats();
    run(&mut flight, &mut ground, 3000);
    assert!(ground.heartbeats() >= before + 2, "it is not heard after the computer's sleep");
    assert_nothing_noticed(&mut flight);
}

/// As much as the bus carries, both ways: what it costs, and that nothing else pays for it.
#[test]
fn a_flood_is_held_back_by_the_bus() {
    let (mut flight, mut ground) = in_the_air();
    let quiet = [flight.counter("4load12HOUSEKEEPING"), flight.counter("4load4LOOP")];
    let flood: Vec<u8> = (0..1 << 20).map(|at: u32| ((at * 37) >> 3) as u8).collect();
    flight.machine.with_usb(|computer| computer.send(&flood));
    run(&mut flight, &mut ground, 3000);
    let left = flight.machine.with_usb(|computer| computer.unsent());
    let taken_bytes_s = (flood.len() - left) / 3;
    let full = [flight.counter("4load12HOUSEKEEPING"), flight.counter("4load4LOOP")];
    println!("{taken_bytes_s} bytes/s taken; worst cycles of housekeeping and loop: {quiet:?}, flooded {full:?}");
    assert!((15_000..=27_000).contains(&taken_bytes_s), "{taken_bytes_s}");
    assert_nothing_noticed(&mut flight);
}

/// A fifth of the transactions lose token, data or handshake: nothing is lost, nothing comes twice, either way.
#[test]
fn a_bus_with_errors_loses_and_doubles_nothing() {
    const COMMANDS: usize = 40;
    let (mut flight, mut ground) = in_the_air();
    flight.machine.with_usb(|computer| computer.disturb(200));
    run(&mut flight, &mut ground, 1000);
    let before = (ground.heartbeats(), ground.bytes_heard(), flight.machine.with_usb(|computer| computer.disturbed()));
    for _ in 0..COMMANDS {
        // one that no vehicle has here is answered at once
        ground.command(&mut flight.machine, MavCmd::MAV_CMD_NAV_TAKEOFF, 0.0);
        run(&mut flight, &mut ground, 100);
    }
    run(&mut flight, &mut ground, 500);
    let answers = ground.results().iter().filter(|(command, _)| *command == MavCmd::MAV_CMD_NAV_TAKEOFF).count();
    let disturbed = flight.machine.with_usb(|computer| computer.disturbed()) - before.2;
    println!("{disturbed} transactions disturbed, {} bytes heard", ground.bytes_heard() - before.1);
    assert_eq!((answers, ground.bytes_skipped()), (COMMANDS, 0), "answers, bytes of no frame");
    assert!(disturbed > 500 && ground.heartbeats() >= before.0 + 4, "{disturbed}");
    assert_eq!(flight.counter("USB_DROPPED"), 0);
    assert_nothing_noticed(&mut flight);
    // and the port is found again on such a bus
    flight.machine.with_usb(|computer| computer.disturb(50));
    flight.machine.with_usb(|computer| computer.plug(false));
    flight.run_for(300 * MILLISECOND);
    plug_and_open(&mut flight);
    let before = ground.heartbeats();
    run(&mut flight, &mut ground, 2000);
    assert!(ground.heartbeats() > before, "it is not heard on a disturbed bus");
}
