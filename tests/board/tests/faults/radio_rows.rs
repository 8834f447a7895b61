//! Faults of the radio and of the IO chip that it comes through.

use emulated_board::{FRAME_PERIOD, Flight, IoFault, IoFirmware, MILLISECOND};

use crate::free_rows::climb;
use crate::rows::{BRANCH_TO_SELF, End, LINK_LOST_MS, LOOP, NOTHING, RESTART_MS, Row, WATCHDOG_MS, break_code};

/// A lost radio is acted on after 250 ms instead of a lost link's 3 s.
const RADIO_LOST_MS: u64 = LINK_LOST_MS - 3000 + 250;
const WATCH_LOST_RADIO_MS: u64 = RADIO_LOST_MS + 300;
const KILL_MS: u64 = 50;
const KILL: usize = 5;

/// From the loss to the descent.
const HELD_MS: u64 = 250 + 2000;
/// From the ground to the end of the motors.
const LANDED_MS: u64 = 3000;
/// From two metres down with nine tenths of the lift.
const DOWN_MS: u64 = 4000;

const RADIO: Row = Row { radio: true, ..NOTHING };
const FLIES_ON: Row = Row { end: End::FliesOn, watch_ms: 2500, ..RADIO };
const LOST: Row = Row {
    within_ms: RADIO_LOST_MS,
    says: &["radio lost", "link lost: level, then down", "disarmed: link lost"],
    watch_ms: WATCH_LOST_RADIO_MS,
    ..RADIO
};
const COMES_BACK: Row =
    Row { says: &["radio lost", "link lost: level, then down", "radio heard", "link back"], ..FLIES_ON };
const KILLED: Row = Row {
    within_ms: KILL_MS,
    says: &["disarmed: kill switch"],
    inject: |flight| flight.set_stick(KILL, 2000),
    ..RADIO
};

pub const RADIO_ROWS: &[Row] = &[
    Row { fault: "radio: transmitter off", inject: switch_off, ..LOST },
    Row {
        fault: "radio, free flight: transmitter off in the air",
        free: true,
        fly: climb,
        inject: switch_off,
        within_ms: HELD_MS + DOWN_MS + LANDED_MS,
        watch_ms: HELD_MS + DOWN_MS + LANDED_MS + 300,
        ..LOST
    },
    Row {
        fault: "radio, free flight: transmitter off on the ground, throttle half up",
        free: true,
        inject: switch_off,
        within_ms: HELD_MS + LANDED_MS,
        watch_ms: HELD_MS + LANDED_MS + 300,
        ..LOST
    },
    Row {
        fault: "radio: transmitter off for 1 s",
        inject: |flight| {
            switch_off(flight);
            flight.run_for(1000 * MILLISECOND);
            flight.transmitter.as_mut().unwrap().switch_on();
        },
        ..COMES_BACK
    },
    Row {
        fault: "radio: transmitter off for 0.15 s",
        inject: |flight| {
            switch_off(flight);
            flight.run_for(150 * MILLISECOND);
            flight.transmitter.as_mut().unwrap().switch_on();
        },
        ..FLIES_ON
    },
    Row {
        fault: "radio: receiver says that it hears nothing",
        inject: |flight| flight.transmitter.as_mut().unwrap().lose_to_failsafe(),
        ..LOST
    },
    Row { fault: "radio: kill switch, IO chip with PX4 v4", ..KILLED },
    Row {
        fault: "radio: kill switch, IO chip with PX4 v5",
        before: |flight| flight.machine.set_io_firmware(IoFirmware::Px4V5),
        ..KILLED
    },
    Row {
        fault: "radio: kill switch, IO chip with ArduPilot",
        before: |flight| flight.machine.set_io_firmware(IoFirmware::ArduPilot),
        ..KILLED
    },
    Row {
        fault: "radio: one wrong frame of the kill switch",
        inject: |flight| {
            flight.set_stick(KILL, 2000);
            flight.run_for(FRAME_PERIOD);
            flight.set_stick(KILL, 1000);
        },
        ..FLIES_ON
    },
    Row { fault: "radio flies: nobody on TELEM1", inject: Flight::mute, watch_ms: 4000, ..FLIES_ON },
    Row { fault: "radio flies: IO chip starts anew", inject: |flight| flight.machine.restart_io(), ..COMES_BACK },
    Row {
        fault: "radio flies: IO chip falls silent",
        inject: |flight| flight.machine.set_io_fault(Some(IoFault::Silent)),
        says: &["IO chip is silent", "radio lost", "disarmed: link lost"],
        ..LOST
    },
    Row {
        fault: "radio flies: IO chip answers later than its slot",
        inject: |flight| flight.machine.set_io_fault(Some(IoFault::Slow(5500))),
        ..LOST
    },
    Row {
        fault: "radio flies: IO chip answers after 2 ms",
        inject: |flight| flight.machine.set_io_fault(Some(IoFault::Slow(2000))),
        ..FLIES_ON
    },
    Row {
        fault: "radio flies: 1 % of the IO chip's packets corrupt",
        inject: |flight| flight.machine.set_io_fault(Some(IoFault::Corrupt(10))),
        ..FLIES_ON
    },
    Row {
        fault: "radio flies: 10 % of the IO chip's packets corrupt",
        inject: |flight| flight.machine.set_io_fault(Some(IoFault::Corrupt(100))),
        ..FLIES_ON
    },
    Row {
        fault: "radio flies: another IO chip, of unknown firmware",
        inject: |flight| flight.machine.set_io_firmware(IoFirmware::Unknown(6, 2)),
        says: &["IO chip: unknown firmware", "radio lost", "disarmed: link lost"],
        ..LOST
    },
    Row {
        fault: "radio flies: safety button held",
        inject: |flight| flight.machine.press_safety_button(true),
        ..FLIES_ON
    },
    Row {
        fault: "radio flies: loop hung, the IO chip stays armed with MAIN driven",
        within_ms: WATCHDOG_MS,
        may_cut: true,
        says: &["started by watchdog"],
        inject: |flight| {
            flight.machine.leave_io_armed();
            break_code(flight, LOOP, &BRANCH_TO_SELF);
        },
        watch_ms: RESTART_MS,
        ..RADIO
    },
    Row {
        fault: "IO chip silent from the start, flown over the link",
        end: End::FliesOn,
        before: |flight| flight.machine.set_io_fault(Some(IoFault::Silent)),
        ..NOTHING
    },
    Row {
        fault: "IO chip of unknown firmware from the start, flown over the link",
        end: End::FliesOn,
        before: |flight| flight.machine.set_io_firmware(IoFirmware::Unknown(4, 3)),
        ..NOTHING
    },
];

fn switch_off(flight: &mut Flight) {
    flight.transmitter.as_mut().unwrap().switch_off();
}
