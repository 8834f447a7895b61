//! The firmware's own ELF flies the thesis' test sequence, and the host's core repeats every step of it to the bit.

use std::time::Instant;

use emulated_board::{Flight, MILLISECOND};
use mavlink::dialects::common::MavCmd;
use shared_control::params::Params;

/// Flies the whole sequence, prints what it took; it ends on the ground.
fn fly(name: &str, params: &Params) -> Flight {
    let mut flight = Flight::in_the_air(params, 1);
    let (start, steps, counters) = (Instant::now(), flight.twin.steps(), flight.machine.counters());
    let (asleep, began) = (flight.machine.profile().asleep(), flight.machine.now());
    flight.run_for(29_700 * MILLISECOND);
    let elapsed_s = start.elapsed().as_secs_f64();
    let steps = flight.twin.steps() - steps;
    let instructions = (flight.machine.counters().instructions - counters.instructions) / steps;
    let slept = (flight.machine.profile().asleep() - asleep) as f64 / (flight.machine.now() - began) as f64;
    let (deviation_deg, planned) = (flight.deviation_deg(), flight.twin.planned());
    println!("{name}: {} steps repeated by the host, 0 bits of difference", flight.twin.steps());
    println!("{name}: mean |set-point - angle| {deviation_deg:.2?} deg");
    println!("{name}: {instructions} instructions a step, CPU {:.1} %, all tasks together", 100.0 * (1.0 - slept));
    println!("{name}: 29.7 s in {elapsed_s:.1} s, {:.1} times real time", 29.7 / elapsed_s);
    if flight.twin.has_mpc() {
        println!("{name}: {planned:?}");
    }
    // it went to all positions of 30 degrees and stayed near what was asked for; steps of 30 degrees make up most of the mean
    assert!((25.0..45.0).contains(&flight.largest_tilt_deg()), "{}", flight.largest_tilt_deg());
    assert!(deviation_deg.iter().all(|mean| *mean < 5.0), "{deviation_deg:?}");
    // over, hence disarmed
    flight.run_for(250 * MILLISECOND);
    assert!(!flight.is_armed());
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
    assert_eq!(flight.machine.counters().resets, 0);
    flight
}

#[test]
fn the_image_flies_the_test_sequence_as_the_host_does() {
    let flight = fly("PID 400 Hz", &Params::DEFAULT);
    let vehicle = flight.vehicle.borrow();
    println!("PID 400 Hz: tick to pulse {:?}", vehicle.delays());
    for interrupt in flight.machine.profile().interrupts() {
        let mut counts = flight.machine.profile().of_interrupt(interrupt).to_vec();
        counts.sort_unstable();
        println!(
            "interrupt {interrupt}: {} times, median {}, worst {:?}",
            counts.len(),
            counts[counts.len() / 2],
            counts.last()
        );
    }
}

#[test]
fn a_failing_supply_ends_the_pulses_and_the_board_comes_back_disarmed() {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 2);
    flight.run_for(500 * MILLISECOND);
    assert!(flight.vehicle.borrow().commands().iter().all(|command| *command > 0.3));
    let failure = flight.machine.now();
    flight.machine.set_supply_v(2.7);
    flight.run_for(20 * MILLISECOND);
    flight.machine.set_supply_v(3.3);
    // the pulse under way may end, cut or whole; none follows, where a healthy board would have sent seven more
    assert!(flight.vehicle.borrow().pulses().last_end() < failure + 5 * MILLISECOND / 2);
    assert!(flight.machine.counters().resets >= 1);
    // it comes back, disarmed, and does not arm: the record of the fault is unread
    flight.run_for(3000 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(100 * MILLISECOND);
    assert!(flight.last().step > 100 && !flight.is_armed(), "{:?}", flight.last());
    println!("{:?}", flight.ground.texts());
    assert_eq!(flight.last().blocks[0], 1);
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
}
