//! A copy of a board in flight goes on as the board itself does: what tests have in common need not be flown twice.

use emulated_board::{Flight, MILLISECOND, Sensor, SensorFault};
use mavlink::dialects::common::MavCmd;
use shared_control::params::Params;

/// What the two must have in common, down to the cycle: memory, time, pulses, and what the ground has heard.
fn state(flight: &mut Flight) -> (String, Vec<u8>, [f64; 4], [f64; 2]) {
    let seen = format!(
        "{:?} {:?} {:?} {:?} {:#x}",
        flight.machine.now(),
        flight.machine.counters(),
        flight.last(),
        flight.ground.texts(),
        flight.machine.program_counter(),
    );
    let ram = flight.machine.bytes(0x2000_0000, 0x3_0000).unwrap();
    let vehicle = flight.vehicle.borrow();
    (seen, ram, vehicle.commands(), vehicle.tilt_rad())
}

#[test]
fn a_copy_flies_on_as_the_board_it_was_made_of() {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 1);
    flight.run_for(300 * MILLISECOND);
    // anywhere: asleep, in an interrupt, in the middle of a transfer
    for microseconds in [0, 137, 1311] {
        flight.run_for(microseconds * MILLISECOND / 1000);
        let mut copy = flight.copy();
        assert!(state(&mut copy) == state(&mut flight), "after {microseconds} us");
        for both in [&mut flight, &mut copy] {
            both.run_for(200 * MILLISECOND);
        }
        assert!(state(&mut copy) == state(&mut flight), "after {microseconds} us and 0.2 s");
    }
}

#[test]
fn what_happens_to_a_copy_does_not_happen_to_the_other() {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 1);
    let mut copy = flight.copy();
    copy.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    copy.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff));
    copy.run_for(200 * MILLISECOND);
    flight.run_for(200 * MILLISECOND);
    assert!(flight.is_armed() && !copy.is_armed());
    assert!(flight.vehicle.borrow().commands().iter().all(|command| *command > 0.2));
    let texts = |flight: &Flight| flight.ground.texts().len();
    assert!(texts(&copy) > texts(&flight), "{:?}", copy.ground.texts());
}
