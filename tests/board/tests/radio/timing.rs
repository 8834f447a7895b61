//! How old the sticks are, how fast the kill switch stops the motors, how fast a lost radio is acted on.

use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{FRAME_PERIOD, Flight, IoFault, IoFirmware, MILLISECOND};
use shared_control::supervisor::Arming;

use crate::{RADIO, STOCK, board, stick};

const AGE_MAX_MS: f64 = 25.0;
const KILL_MAX: Ticks = 50 * MILLISECOND;
const LOST_MAX: Ticks = 250 * MILLISECOND;
const LOOK: Ticks = MILLISECOND / 10;

/// On the gimbal at half throttle, armed by sticks, with each of the stock firmwares; flights begin with copies.
fn in_the_air() -> [(IoFirmware, Flight); STOCK.len()] {
    STOCK.map(|firmware| {
        let mut flight = board(&RADIO, firmware);
        flight.take_off_by_radio();
        (firmware, flight)
    })
}

/// Pulses of the roll stick, each frame another.
fn roll_pulse(frame: usize) -> u16 {
    1600 + (frame % 50) as u16 * 4
}

/// Each step's set-point says which frame it was made of.
#[test]
fn sticks_are_at_most_25_ms_old() {
    let started = in_the_air();
    let whole = started.iter().map(|of| (of, None));
    for ((firmware, start), fault) in whole.chain([(&started[0], Some(IoFault::Corrupt(10)))]) {
        let mut flight = start.copy();
        flight.machine.set_io_fault(fault);
        let (mut ages_ms, mut frame) = (Vec::new(), 0);
        let end = flight.machine.now() + 3000 * MILLISECOND;
        let mut step = flight.last().step;
        while flight.machine.now() < end {
            let sent = flight.transmitter.as_ref().unwrap().sent().last().map(|(at, _)| *at);
            flight.run_for(LOOK);
            if flight.transmitter.as_ref().unwrap().sent().last().map(|(at, _)| *at) != sent {
                frame += 1;
                stick(&mut flight, 1, roll_pulse(frame));
            }
            if flight.last().step == step {
                continue;
            }
            step = flight.last().step;
            let roll_deg = f32::from_bits(flight.last().setpoint[0]).to_degrees();
            let pulse_us = (1510.0 + roll_deg / 30.0 * 490.0).round() as u16;
            let transmitter = flight.transmitter.as_ref().unwrap();
            let made_of = transmitter.sent().iter().rev().find(|(_, channels)| channels[0] == pulse_us);
            if frame > 5 {
                let (at, _) = made_of.unwrap_or_else(|| panic!("no frame with {pulse_us} us"));
                ages_ms.push((flight.machine.now() - at) as f64 / MILLISECOND as f64);
            }
        }
        ages_ms.sort_by(f64::total_cmp);
        let percentile = |share: f64| ages_ms[(share * (ages_ms.len() - 1) as f64) as usize];
        let (median, most) = (percentile(0.5), percentile(0.99));
        println!(
            "{firmware:?} {fault:?}: sticks {median:.1} ms old, 99 % within {most:.1} ms, all {:.1}",
            percentile(1.0)
        );
        assert!(ages_ms.len() > 1000 && most <= AGE_MAX_MS, "{firmware:?}: {most} ms");
    }
}

/// From the movement of the switch to the end of the last pulse at which a motor turns, at all phases of a frame.
#[test]
fn the_kill_switch_stops_the_motors_within_50_ms() {
    let mut longest = 0;
    for (place, (firmware, start)) in (0..9).zip(in_the_air().iter().cycle()) {
        let mut flight = start.copy();
        flight.run_for(FRAME_PERIOD * place / 9);
        stick(&mut flight, 5, 2000);
        let thrown = flight.machine.now();
        flight.run_for(150 * MILLISECOND);
        let stopped = flight.vehicle.borrow().pulses().last_live_end().saturating_sub(thrown);
        longest = longest.max(stopped);
        assert!(stopped <= KILL_MAX, "{firmware:?}: {} us", stopped / TICKS_PER_US);
        assert!(flight.ground.texts().iter().any(|(_, text)| text == "disarmed: kill switch"));
    }
    println!("kill switch to the end of the last live pulse: {} us at most", longest / TICKS_PER_US);
}

#[test]
fn a_lost_radio_is_acted_on_within_250_ms() {
    let faults: [fn(&mut Flight); 3] = [
        |flight| flight.transmitter.as_mut().unwrap().switch_off(),
        |flight| flight.transmitter.as_mut().unwrap().lose_to_failsafe(),
        |flight| flight.machine.set_io_fault(Some(IoFault::Silent)),
    ];
    let link_lost = Arming::LinkLost { since_us: 0 }.number();
    for ((firmware, start), lose) in in_the_air().iter().flat_map(|of| faults.map(|lose| (of, lose))) {
        let mut flight = start.copy();
        lose(&mut flight);
        let lost = flight.machine.now();
        while flight.last().arming != link_lost && flight.machine.now() < lost + 2 * LOST_MAX {
            flight.run_for(MILLISECOND);
        }
        let found = flight.machine.now() - lost;
        println!("{firmware:?}: acted on after {} ms", found / MILLISECOND);
        assert!(found <= LOST_MAX, "{firmware:?}: {} ms", found / MILLISECOND);
    }
}
