//! Nested priorities, BASEPRI, PendSV and floating point in both contexts, on a program of a few instructions.
//!
//! Written as Thumb half-words, so that the order of events is known to the instruction. Each mark is a byte appended to a
//! list in RAM.

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Counts, Image, Machine, Pulse, World};

const BASE: u32 = 0x0800_4000;
const MARKS: u32 = 0x2000_0000;
/// Vectors of 16 exceptions and 32 interrupts.
const TABLE_BYTES: usize = 4 * 48;

struct Nothing;

impl World for Nothing {
    fn imu(&mut self, _: u64) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}

/// Code with literals behind it, as it grows.
#[derive(Default)]
struct Assembler {
    code: Vec<u16>,
}

impl Assembler {
    fn put(&mut self, halves: &[u16]) -> &mut Self {
        self.code.extend(halves);
        self
    }

    fn here(&self) -> u32 {
        BASE + (TABLE_BYTES + 2 * self.code.len()) as u32
    }

    /// movw, movt: a register gets a word (ARMv7-M ARM A7.7.76, A7.7.79).
    fn load(&mut self, register: u16, word: u32) -> &mut Self {
        for (opcode, half) in [(0xf240, word & 0xffff), (0xf2c0, word >> 16)] {
            let half = half as u16;
            let first = opcode | half >> 12 | (half >> 11 & 1) << 10;
            self.put(&[first, (half >> 8 & 7) << 12 | register << 8 | half & 0xff]);
        }
        self
    }

    /// Stores a word at an address.
    fn store(&mut self, address: u32, word: u32) -> &mut Self {
        self.load(0, address).load(1, word).put(&[0x6001])
    }

    /// Appends a mark; r6 points behind the list.
    fn mark(&mut self, mark: u8) -> &mut Self {
        self.put(&[0x2100 | u16::from(mark), 0x7031, 0x3601])
    }

    /// Interrupts may come between: dsb, isb, and nops up to the end of any slice.
    fn settle(&mut self) -> &mut Self {
        self.put(&[0xf3bf, 0x8f4f, 0xf3bf, 0x8f6f]).put(&[0xbf00; 300])
    }
}

const SET_PENDING: u32 = 0xe000_e200;
const BX_LR: u16 = 0x4770;

/// Marks in the order in which the program made them.
fn run() -> (Vec<u8>, [u32; 2]) {
    let mut program = Assembler::default();
    let mut vectors = [0; TABLE_BYTES / 4];
    vectors[0] = 0x2003_0000;
    // interrupt 0, low: pends 1, which is above it, and PendSV, which is below; spoils s0; r6 survives as it is not stacked
    vectors[16] = program.here() | 1;
    program.mark(b'a').store(SET_PENDING, 1 << 1).store(0xe000_ed04, 1 << 28).settle();
    program.put(&[0xee30, 0x0a00]).mark(b'A').put(&[BX_LR]);
    // interrupt 1, high
    vectors[17] = program.here() | 1;
    program.mark(b'b').put(&[0xee30, 0x0a00]).settle().mark(b'B').put(&[BX_LR]);
    // interrupt 2, between the two
    vectors[18] = program.here() | 1;
    program.mark(b'c').put(&[BX_LR]);
    vectors[14] = program.here() | 1;
    program.mark(b'p').put(&[0xee30, 0x0a00, BX_LR]);
    vectors[1] = program.here() | 1;
    program.load(6, MARKS + 0x100).store(0xe000_ed08, BASE).store(0xe000_ed88, 0xf0_0000);
    // priorities: 0 has 0x60, 1 has 0x20, 2 has 0x40, PendSV 0xf0
    program.store(0xe000_e400, 0x0040_2060).store(0xe000_ed20, 0x00f0_0000).store(0xe000_e100, 7);
    // s0 = s1 = 1.0
    program.put(&[0xeeb7, 0x0a00, 0xeef7, 0x0a00]);
    program.mark(b'1').store(SET_PENDING, 1).settle();
    // BASEPRI 0x40 holds back 0x40 and what is below, not 0x20
    program.mark(b'2').put(&[0x2040, 0xf380, 0x8811]).store(SET_PENDING, 0b110).settle();
    program.mark(b'3').put(&[0x2000, 0xf380, 0x8811]).settle().mark(b'4');
    program.load(0, MARKS).put(&[0xed80, 0x0a00, 0xedc0, 0x0a01, 0x6086]).put(&[0xbf30, 0xe7fe]);
    let mut bytes: Vec<u8> = vectors.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.extend(program.code.iter().flat_map(|half| half.to_le_bytes()));
    let mut machine = Machine::new(&Image::from_bytes(BASE, bytes), Box::new(Nothing), 1).unwrap();
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
