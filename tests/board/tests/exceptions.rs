//! Nested priorities, BASEPRI, PendSV and floating point in both contexts, on a program of a few instructions.
//!
//! Written as Thumb half-words, so that the order of events is known to the instruction. Each mark is a byte appended to a
//! list in RAM.

use emulated_board::thumb::{BASE, Program};
use emulated_board::time::TICKS_PER_US;
use emulated_board::{Counts, Machine, Pulse, World};

const MARKS: u32 = 0x2000_0000;

struct Nothing;

impl World for Nothing {
    fn imu(&mut self, _: u64) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}

/// Appends a mark; r6 points behind the list.
fn mark(program: &mut Program, mark: u8) {
    program.put(&[0x2100 | u16::from(mark), 0x7031, 0x3601]);
}

const SET_PENDING: u32 = 0xe000_e200;
const VTOR: u32 = 0xe000_ed08;
/// vadd.f32 s0, s0, s0: the register is spoilt.
const SPOIL_FLOAT: [u16; 2] = [0xee30, 0x0a00];

/// Marks in the order in which the program made them.
fn run() -> (Vec<u8>, [u32; 2]) {
    let mut program = Program::default();
    // interrupt 0, low: pends 1, which is above it, and PendSV, which is below; r6 survives as it is not stacked
    mark(program.handler(16), b'a');
    program.store(SET_PENDING, 1 << 1).store(0xe000_ed04, 1 << 28).settle();
    mark(program.put(&SPOIL_FLOAT), b'A');
    // interrupt 1, high
    mark(program.leave().handler(17), b'b');
    mark(program.put(&SPOIL_FLOAT).settle(), b'B');
    // interrupt 2, between the two
    mark(program.leave().handler(18), b'c');
    mark(program.leave().handler(14), b'p');
    program.put(&SPOIL_FLOAT).leave().main();
    program.load(6, MARKS + 0x100).store(VTOR, BASE).store(0xe000_ed88, 0xf0_0000);
    // priorities: 0 has 0x60, 1 has 0x20, 2 has 0x40, PendSV 0xf0
    program.store(0xe000_e400, 0x0040_2060).store(0xe000_ed20, 0x00f0_0000).store(0xe000_e100, 7);
    // s0 = s1 = 1.0
    mark(program.put(&[0xeeb7, 0x0a00, 0xeef7, 0x0a00]), b'1');
    mark(program.store(SET_PENDING, 1).settle(), b'2');
    // BASEPRI 0x40 holds back 0x40 and what is below, not 0x20
    program.put(&[0x2040, 0xf380, 0x8811]).store(SET_PENDING, 0b110).settle();
    mark(&mut program, b'3');
    mark(program.put(&[0x2000, 0xf380, 0x8811]).settle(), b'4');
    program.load(0, MARKS).put(&[0xed80, 0x0a00, 0xedc0, 0x0a01, 0x6086]).sleep();
    let mut machine = Machine::new(&program.image(), Box::new(Nothing), 1).unwrap();
    machine.run_until(10_000 * TICKS_PER_US).unwrap();
    assert!(machine.is_asleep(), "pc {:#x}", machine.program_counter());
    let end = machine.word(MARKS + 8).unwrap();
    let marks = machine.bytes(MARKS + 0x100, (end - MARKS - 0x100) as usize).unwrap();
    (marks, [machine.word(MARKS).unwrap(), machine.word(MARKS + 4).unwrap()])
}

#[test]
fn exceptions_nest_by_priority_wait_for_masks_and_keep_each_others_floats() {
    let (marks, floats) = run();
    // 0 starts, 1 preempts it, 0 ends, then PendSV; under BASEPRI 1 still comes, 2 waits until it is lifted
    assert_eq!(String::from_utf8_lossy(&marks), "1abBAp2bB3c4");
    assert_eq!(floats.map(f32::from_bits), [1.0, 1.0]);
}
