//! Exceptions: one program, whose trace must be the same here and on QEMU's model of a Cortex-M4F (`mps2-an386`), which
//! shares with this board's no more than how it executes single instructions.
//!
//! `trace.txt` is what QEMU wrote. Where `qemu-system-arm` is installed, it has to write the same again.

mod assembler;
mod program;
mod qemu;

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Counts, Image, Machine, Pulse, World};

use crate::program::{Ending, TRACE, TRACE_END, program};

const FLASH: u32 = 0x0800_4000;

struct Nothing;

impl World for Nothing {
    fn imu(&mut self, _: u64) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}

fn trace_of_the_board() -> Vec<u8> {
    let image = Image::from_bytes(FLASH, program(FLASH, Ending::Sleep));
    let mut machine = Machine::new(&image, Box::new(Nothing), 1).unwrap();
    machine.run_until(10_000 * TICKS_PER_US).unwrap();
    assert!(machine.is_asleep(), "pc {:#x}", machine.program_counter());
    let end = machine.word(TRACE_END).unwrap();
    machine.bytes(TRACE, (end - TRACE) as usize).unwrap()
}

/// A line a note: letter and word.
fn in_words(trace: &[u8]) -> String {
    let words: Vec<_> = trace.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let lines = words.chunks_exact(2).map(|note| format!("{} {:08x}\n", note[0] as u8 as char, note[1]));
    lines.collect()
}

/// What the architecture demands, letter by letter: who notes something after whom. Capitals are a handler's end.
const ORDER: &str = concat!(
    "01",
    // 0 is interrupted by 1, 2 follows 1 without 0 in between; then 2 interrupts it again; 3, its equal, waits; PendSV
    // is last
    "abBcCacCaAdpP1",
    "2abBcCacCaAdpP2",
    // from the process stack, by software, by SVC, with floating point
    "bB3v3bB3",
    // BASEPRI: 1 comes; nobody; 1 comes as the mask falls; 2 as it is lifted
    "bB4bB4cC4",
    // PRIMASK: WFI ends, then 2 and SysTick follow each other; FAULTMASK
    "5cCs5",
    "6bB6",
    // SVC twice, and once as HardFault
    "v7v7h7",
    // pends itself twice
    "cCcCcC8",
    // 0 has been raised above BASEPRI, and above 2, which now waits for its end
    "9abBaAcC9dpP9",
    // pending is cleared; then kept until enabled
    "xdx"
);

#[test]
fn exceptions_come_in_the_order_that_the_architecture_demands() {
    let mut letters: Vec<_> = in_words(&trace_of_the_board()).lines().filter_map(|line| line.chars().next()).collect();
    letters.dedup();
    assert_eq!(letters.into_iter().collect::<String>(), ORDER);
}

#[test]
fn the_board_takes_exceptions_as_qemu_does() {
    let kept = include_str!("trace.txt");
    match qemu::trace(&program(qemu::BASE, Ending::Semihosting)) {
        Some(trace) => {
            assert_eq!(in_words(&trace), kept, "QEMU differs from what it wrote before");
            println!("{} notes on exceptions, equal on QEMU's mps2-an386", kept.lines().count());
        }
        None => eprintln!("WARNING: no qemu-system-arm here: compared with what it wrote elsewhere, trace.txt"),
    }
    assert_eq!(in_words(&trace_of_the_board()), kept);
}
