//! What the log costs the loop, the processor and the stack.

use emulated_board::time::seconds;
use emulated_board::{Flight, MILLISECOND, Pauses};
use fatfs::FatType;

use crate::{MPC, with_card};

const LOOP: u8 = 29;
/// A step at 400 Hz, cycles.
const STEP_CYCLES: u32 = 420_000;

/// Median and worst cycles of the loop's task, share of the time awake, 1/1000, and the stack, bytes.
fn cost(mut flight: Flight) -> ([u32; 2], u32, usize) {
    flight.take_off();
    let begin = flight.machine.now();
    flight.run_for(2000 * MILLISECOND);
    let passed_s = seconds(flight.machine.now() - begin);
    let profile = flight.machine.profile();
    let mut cycles = profile.cycles_of_interrupt(LOOP).to_vec();
    cycles.sort_unstable();
    let awake_permille = 1000.0 * (1.0 - seconds(profile.asleep()) / passed_s);
    ([cycles[cycles.len() / 2], cycles[cycles.len() - 1]], awake_permille as u32, flight.stack_used_bytes())
}

#[test]
fn the_log_takes_a_small_part_of_a_step() {
    let (without, awake_without, stack_without) = cost(Flight::new(&MPC, 1));
    let (with, awake_with, stack_with) = cost(with_card(&MPC, FatType::Fat16, Pauses::USUAL));
    println!("loop, median and worst cycles: {without:?} without a log, {with:?} with one");
    println!("awake {awake_without} and {awake_with} permille, stack {stack_without} and {stack_with} bytes");
    for (with, without) in with.into_iter().zip(without) {
        // a twentieth of a step
        assert!(with < without + STEP_CYCLES / 20, "{with} cycles instead of {without}");
    }
    // seven eighths of the stack's 64 Kbyte, most of which is the MPC's
    assert!(stack_with < 56 << 10, "{stack_with} bytes");
}
