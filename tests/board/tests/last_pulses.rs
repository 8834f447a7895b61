//! What the ESCs hear when the supply or the crystal fails in flight, wherever in the pulse that falls; and a board
//! that starts without either.

use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{Flight, MILLISECOND, Machine, Pulse};
use mavlink::dialects::common::MavCmd;
use shared_control::params::Params;

const PERIOD: Ticks = 2500 * TICKS_PER_US;
const DISARMED: Ticks = 1000 * TICKS_PER_US;
/// From the fault to the last edge that may tell anything but the disarmed pulse.
const REACTION: Ticks = 50 * TICKS_PER_US;
/// So long is a dip of the supply taken for noise.
const SUPPLY_FILTER: Ticks = 55 * TICKS_PER_US;

/// Fails so long after a pulse's beginning, and gives the time of failure and what was sent from then on.
fn fail_in_flight(offset: Ticks, fail: impl Fn(&mut Machine)) -> (Ticks, Vec<Pulse>, Flight) {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 2);
    flight.run_for(100 * MILLISECOND);
    let began = flight.vehicle.borrow().pulses().last()[0].unwrap().rise;
    let elapsed = flight.machine.now() - began;
    let at = began + elapsed.div_ceil(PERIOD) * PERIOD + offset;
    flight.run_for(at - flight.machine.now());
    flight.vehicle.borrow_mut().record_pulses();
    let failure = flight.machine.now();
    fail(&mut flight.machine);
    flight.machine.run_until(failure + 100 * MILLISECOND).unwrap();
    let pulses = flight.vehicle.borrow().recorded_pulses().to_vec();
    (failure, pulses, flight)
}

/// Times after a pulse's beginning: into the part that every pulse has, into what a flying motor's pulse has beyond (it
/// hovers at 1500 us), and into the pause.
const OFFSETS_US: [u64; 6] = [3, 700, 1020, 1300, 1900, 2400];

/// The last whole pulse of each channel, and that there is one.
fn last_of(pulses: &[Pulse], channel: usize) -> Pulse {
    *pulses.iter().rfind(|pulse| pulse.channel == channel).expect("a pulse after the failure")
}

#[test]
fn a_failing_supply_ends_in_a_whole_disarmed_pulse() {
    for offset_us in OFFSETS_US {
        let (failure, pulses, flight) = fail_in_flight(offset_us * TICKS_PER_US, |machine| machine.set_supply_v(2.7));
        for pulse in &pulses {
            let disarmed = pulse.width.abs_diff(DISARMED) <= TICKS_PER_US;
            // or it was longer already, and ended at once
            let at_once = pulse.rise + pulse.width < failure + SUPPLY_FILTER + REACTION;
            let cut = pulse.rise < failure && pulse.width > DISARMED && at_once;
            assert!(disarmed || cut, "{offset_us} us: {pulse:?}, failure at {failure}");
        }
        for channel in 0..4 {
            let last = last_of(&pulses, channel);
            assert!(last.rise + DISARMED > failure && last.width.abs_diff(DISARMED) <= TICKS_PER_US, "{offset_us} us");
            assert!(
                last.rise + last.width < failure + PERIOD + SUPPLY_FILTER + REACTION,
                "{offset_us} us: more than one pulse follows"
            );
        }
        assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
        assert_eq!(flight.machine.counters().resets, 1);
    }
}

#[test]
fn without_its_crystal_the_board_still_sends_a_disarmed_pulse_and_none_that_is_too_long() {
    for offset_us in OFFSETS_US {
        let (failure, pulses, flight) = fail_in_flight(offset_us * TICKS_PER_US, Machine::stop_crystal);
        for pulse in &pulses {
            let ended_at_once = pulse.rise < failure && pulse.rise + pulse.width < failure + REACTION;
            let disarmed = (900 * TICKS_PER_US..=DISARMED).contains(&pulse.width);
            assert!(ended_at_once || disarmed, "{offset_us} us: {pulse:?}, failure at {failure}");
            assert!(pulse.width < 2000 * TICKS_PER_US);
        }
        for channel in 0..4 {
            let last = last_of(&pulses, channel);
            // with a pause before it in which an ESC can tell the two apart
            assert!(last.rise > failure + MILLISECOND && last.width < DISARMED, "{offset_us} us: {last:?}");
        }
        assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
        assert_eq!(flight.machine.counters().resets, 1);
    }
}

#[test]
fn a_board_that_starts_without_its_crystal_waits_without_pulses_and_starts_when_it_is_back() {
    let mut flight = Flight::new(&Params::DEFAULT, 1);
    flight.machine.stop_crystal();
    flight.machine.run_until(3000 * MILLISECOND).unwrap();
    assert_eq!((flight.vehicle.borrow().pulses().last_end(), flight.machine.counters().exceptions), (0, 0));
    flight.machine.mend_crystal();
    // ten seconds by its own count, on an oscillator that may be slow
    flight.run_for(17_000 * MILLISECOND);
    assert_eq!(flight.machine.counters().resets, 1);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(200 * MILLISECOND);
    assert!(!flight.is_armed());
    let told = |words: &str| flight.ground.texts().iter().any(|(_, text)| text.contains(words));
    assert!(told("crystal did not start") && told("fault record is unread"), "{:?}", flight.ground.texts());
}

#[test]
fn a_board_that_starts_with_a_low_supply_waits_for_it() {
    let mut flight = Flight::new(&Params::DEFAULT, 1);
    flight.machine.set_supply_v(2.7);
    flight.machine.run_until(1500 * MILLISECOND).unwrap();
    assert_eq!((flight.vehicle.borrow().pulses().last_end(), flight.machine.counters().exceptions), (0, 0));
    flight.machine.set_supply_v(3.3);
    flight.run_for(3500 * MILLISECOND);
    assert_eq!(flight.machine.counters().resets, 0);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(100 * MILLISECOND);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    assert!(flight.ground.texts().iter().any(|(_, text)| text.contains("waited for a supply")));
}
