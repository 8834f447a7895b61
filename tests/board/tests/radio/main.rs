//! The radio through the IO chip, in its three stock firmwares and with one that nobody knows: what the firmware's own
//! image makes of sticks, switches and the safety button, and in what time.

mod timing;

use emulated_board::{Flight, IoFirmware, MILLISECOND, Transmitter};
use mavlink::dialects::common::MavCmd;
use shared_control::params::Params;
use shared_control::params::radio::RadioParams;

const STOCK: [IoFirmware; 3] = [IoFirmware::Px4V4, IoFirmware::Px4V5, IoFirmware::ArduPilot];
/// Boot and gyro calibration.
const START_MS: u64 = 3500;

/// With the kill switch on channel 5.
const RADIO: Params =
    Params { radio: RadioParams { flies: true, kill_channel: 5, ..RadioParams::DEFAULT }, ..Params::DEFAULT };

/// At power-on, the transmitter on.
fn board(params: &Params, firmware: IoFirmware) -> Flight {
    let mut flight = Flight::new(params, 1);
    flight.machine.set_io_firmware(firmware);
    flight.transmitter = Some(Transmitter::new());
    flight
}

fn stick(flight: &mut Flight, channel: usize, pulse_us: u16) {
    flight.transmitter.as_mut().unwrap().set(channel, pulse_us);
}

fn heard(flight: &Flight, words: &str) -> bool {
    flight.ground.texts().iter().any(|(_, text)| text.contains(words))
}

#[test]
fn each_firmware_is_known_and_safe_within_a_tenth_of_a_second() {
    for firmware in STOCK {
        let mut flight = board(&RADIO, firmware);
        flight.machine.leave_io_armed();
        while flight.twin.steps() == 0 {
            flight.run_for(MILLISECOND);
        }
        flight.run_for(100 * MILLISECOND);
        assert!(flight.machine.io_is_made_safe(), "{firmware:?}");
        assert!(flight.machine.main_outputs_us().iter().all(|pulse_us| *pulse_us <= 1000), "{firmware:?}");
        // with safety off the gate of the older ones opens
        flight.machine.press_safety_button(true);
        flight.run_for(1200 * MILLISECOND);
        assert!(flight.machine.io_safety_is_off(), "{firmware:?}");
        assert!(flight.machine.main_outputs_us().iter().all(|pulse_us| *pulse_us <= 1000), "{firmware:?}");
        assert!(heard(&flight, "radio heard"), "{firmware:?}: {:?}", flight.ground.texts());
    }
}

/// The model stops the run at the first write.
#[test]
fn an_unknown_firmware_is_said_and_flown_without() {
    let mut flight = board(&Params::DEFAULT, IoFirmware::Unknown(6, 2));
    flight.take_off();
    assert!(heard(&flight, "IO chip: unknown firmware"), "{:?}", flight.ground.texts());
    assert!(flight.is_armed());
}

#[test]
fn sticks_arm_fly_and_disarm() {
    let mut flight = board(&RADIO, IoFirmware::Px4V5);
    flight.run_for(START_MS * MILLISECOND);
    // never with throttle up: not by the sticks, not by a command
    stick(&mut flight, 3, 1100);
    stick(&mut flight, 4, 2000);
    flight.run_for(1300 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(300 * MILLISECOND);
    assert!(!flight.is_armed() && heard(&flight, "refused: throttle is not at zero"), "{:?}", flight.ground.texts());
    stick(&mut flight, 3, 1000);
    flight.run_for(900 * MILLISECOND);
    assert!(!flight.is_armed(), "not yet a second");
    flight.run_for(200 * MILLISECOND);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    stick(&mut flight, 4, 1500);
    stick(&mut flight, 3, 1500);
    flight.run_for(500 * MILLISECOND);
    let now = flight.machine.now();
    flight.vehicle.borrow_mut().release(now);
    stick(&mut flight, 1, 1755);
    flight.run_for(1500 * MILLISECOND);
    // half of 30 degrees
    let roll_deg = flight.vehicle.borrow().tilt_rad()[0].to_degrees();
    assert!((13.0..17.0).contains(&roll_deg), "{roll_deg}");
    // the ground's sticks move nothing, and in the air the corner ends nothing
    flight.hold_throttle(0);
    stick(&mut flight, 1, 1500);
    stick(&mut flight, 3, 1000);
    stick(&mut flight, 4, 1000);
    flight.run_for(900 * MILLISECOND);
    assert!(flight.is_armed());
}

#[test]
fn the_safety_button_has_to_be_held() {
    for firmware in STOCK {
        let mut flight = board(&Params { safety_button: true, ..RADIO }, firmware);
        flight.run_for(START_MS * MILLISECOND);
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        flight.run_for(200 * MILLISECOND);
        assert!(!flight.is_armed() && heard(&flight, "refused: hold the safety button"), "{firmware:?}");
        flight.machine.press_safety_button(true);
        flight.run_for(1200 * MILLISECOND);
        flight.machine.press_safety_button(false);
        assert!(flight.machine.io_safety_is_off(), "{firmware:?}: its light says so");
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        flight.run_for(200 * MILLISECOND);
        assert!(flight.is_armed(), "{firmware:?}: {:?}", flight.ground.texts());
        // in flight it takes nothing away
        flight.machine.press_safety_button(true);
        flight.run_for(1200 * MILLISECOND);
        assert!(flight.is_armed(), "{firmware:?}");
    }
}

#[test]
fn nonsense_is_said_and_does_not_arm() {
    let mut radio = RADIO.radio;
    radio.sticks[0].trim_us = 1000;
    let mut flight = board(&Params { radio, ..RADIO }, IoFirmware::ArduPilot);
    flight.run_for(START_MS * MILLISECOND);
    assert!(heard(&flight, "radio: RC_ROLL: not MIN < TRIM < MAX"), "{:?}", flight.ground.texts());
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(200 * MILLISECOND);
    assert!(!flight.is_armed() && heard(&flight, "refused: radio calibration makes no sense"));
}
