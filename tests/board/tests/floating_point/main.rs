//! Trust in the emulator's arithmetic: every floating-point instruction that the firmware's ELF has, on many operands,
//! against the host.

mod forms;
mod instructions;

use std::collections::BTreeSet;
use std::path::PathBuf;

use emulated_board::time::TICKS_PER_S;
use emulated_board::{Cause, Counts, Image, Machine, Pulse, World};

use crate::forms::{forms, forms_in_elf};
use crate::instructions::{INSTRUCTIONS, immediates};

const BASE: u32 = 0x0800_4000;
const RESULTS: u32 = 0x2000_0000;
/// Results of a run fill most of the 192 K of RAM.
const PAIRS_PER_RUN: usize = 40_000;
const RUNS: usize = 3;

struct Nothing;

impl World for Nothing {
    fn imu(&mut self, _: u64) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}

/// A program that takes pairs (s0, s1) from flash, runs `instructions` and stores s2, as Thumb half-words.
fn program(instructions: &[u16], pairs: &[[u32; 2]], enables_float: bool) -> Image {
    const STORE_CPACR: u16 = 0x601c;
    const NOP: u16 = 0xbf00;
    let mut code: Vec<u16> = vec![
        0x4800,
        0x4900,
        0x4a00,
        0x4b00,
        0x4c00, // ldr r0..r4, [pc, #...]
        if enables_float { STORE_CPACR } else { NOP },
        0xf3bf,
        0x8f4f,
        0xf3bf,
        0x8f6f, // dsb, isb
    ];
    let again = code.len();
    code.extend([0xecb0, 0x0a02]); // vldmia r0!, {s0, s1}
    code.extend(instructions);
    code.extend([0xeca1, 0x1a01, 0x3a01]); // vstmia r1!, {s2}; subs r2, #1
    let back = again as i32 - (code.len() as i32 + 2);
    code.extend([0xd100 | (back as u16 & 0xff), 0xbf30, 0xe7fe]); // bne; wfi; b .
    if !code.len().is_multiple_of(2) {
        code.push(NOP);
    }
    let (table_bytes, code_words) = (8, code.len() / 2);
    // a load sees pc + 4, rounded down to a word
    for (literal, load) in code[..5].iter_mut().enumerate() {
        let seen_word = (2 * literal + 4) / 4;
        *load = *load & 0xff00 | (code_words + literal - seen_word) as u16;
    }
    let source = BASE + table_bytes + 4 * (code_words as u32 + 5);
    let mut bytes: Vec<u8> = [0x2003_0000, BASE + table_bytes + 1].iter().flat_map(|w: &u32| w.to_le_bytes()).collect();
    bytes.extend(code.iter().flat_map(|half| half.to_le_bytes()));
    for literal in [source, RESULTS, pairs.len() as u32, 0xe000_ed88, 0x00f0_0000] {
        bytes.extend(literal.to_le_bytes());
    }
    bytes.extend(pairs.iter().flatten().flat_map(|word| word.to_le_bytes()));
    Image::from_bytes(BASE, bytes)
}

/// Numbers of every kind: any bits, and often the special ones.
struct Operands(u64);

impl Operands {
    fn next(&mut self) -> u32 {
        const SPECIAL: [u32; 12] = [
            0,
            0x8000_0000,
            1,
            0x8000_0001,
            0x007f_ffff,
            0x0080_0000,
            0x3f80_0000,
            0x7f7f_ffff,
            0x7f80_0000,
            0xff80_0000,
            0x7fc0_0000,
            0x4f00_0000,
        ];
        // xorshift64* (Marsaglia; Vigna)
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32) as u32;
        match bits >> 28 {
            0 => SPECIAL[(bits & 0xff) as usize % SPECIAL.len()],
            // of like size, so that sums cancel and quotients round
            1..=7 => bits & 0x80ff_ffff | 0x3f00_0000,
            // denormal
            8 => bits & 0x807f_ffff,
            _ => bits.rotate_left(7),
        }
    }
}

fn results(instructions: &[u16], pairs: &[[u32; 2]]) -> Vec<u32> {
    let mut machine = Machine::new(&program(instructions, pairs, true), Box::new(Nothing), 1).unwrap();
    machine.run_until(TICKS_PER_S).unwrap();
    assert!(machine.is_asleep());
    let bytes = machine.bytes(RESULTS, 4 * pairs.len()).unwrap();
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

#[test]
fn every_instruction_gives_the_hosts_bits() {
    let mut operands = Operands(0x1234_5678_9abc_def1);
    for _ in 0..RUNS {
        let pairs: Vec<_> = (0..PAIRS_PER_RUN).map(|_| [operands.next(), operands.next()]).collect();
        for (instructions, reference) in INSTRUCTIONS {
            for ([a, b], is) in pairs.iter().zip(results(instructions, &pairs)) {
                let expected = reference(f32::from_bits(*a), f32::from_bits(*b));
                let both_nan = f32::from_bits(expected).is_nan() && f32::from_bits(is).is_nan();
                let names = || forms(instructions).into_keys().collect::<Vec<_>>().join(", ");
                assert!(
                    is == expected || both_nan,
                    "{} of {a:#010x}, {b:#010x}: {is:#010x}, not {expected:#010x}",
                    names()
                );
            }
        }
    }
    println!("{} sequences on {} pairs of operands each: the host's bits", INSTRUCTIONS.len(), RUNS * PAIRS_PER_RUN);
}

#[test]
fn every_immediate_is_its_number() {
    for (instruction, expected) in immediates() {
        assert_eq!(results(&instruction, &[[0, 0]]), [expected], "{instruction:04x?}");
    }
}

/// What the other tests compare is all that the firmware's ELF has, and it multiplies and adds in one nowhere, which
/// the host does not.
#[test]
fn the_image_has_no_instruction_that_is_not_compared() {
    let path = firmware();
    let elf = std::fs::read(&path).unwrap_or_else(|error| panic!("run this by `cargo xtask board-test`: {error}"));
    let in_image = forms_in_elf(&elf);
    let compared =
        INSTRUCTIONS.iter().flat_map(|(code, _)| forms(code)).chain(immediates().flat_map(|(code, _)| forms(&code)));
    let compared: BTreeSet<_> = compared.map(|(form, _)| form).collect();
    let not_compared: Vec<_> = in_image.keys().filter(|form| !compared.contains(*form)).collect();
    assert!(not_compared.is_empty(), "not compared with the host: {not_compared:?}");
    for needed in ["vmul", "vadd", "vdiv", "vldr", "vmov immediate"] {
        assert!(in_image.contains_key(needed), "no {needed}: were the image's instructions read?");
    }
    for fused in ["vfma", "vfms", "vfnma", "vfnms"] {
        assert!(!in_image.contains_key(fused) && !compared.contains(fused), "{fused} rounds once");
    }
    let list: Vec<_> = in_image.iter().map(|(form, count)| format!("{form} {count}")).collect();
    println!("floating point in the image: {}", list.join(", "));
}

/// The image that `cargo xtask board-test` has built.
fn firmware() -> PathBuf {
    std::env::var_os("FIRMWARE_ELF").map(PathBuf::from).unwrap_or_else(|| {
        let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        workspace.join("target/thumbv7em-none-eabihf/release/firmware")
    })
}

#[test]
fn floating_point_before_cpacr_stops_the_run() {
    let image = program(&[0xee30, 0x1a20], &[[0, 0]], false);
    let mut machine = Machine::new(&image, Box::new(Nothing), 1).unwrap();
    assert_eq!(machine.run_until(TICKS_PER_S).unwrap_err().cause, Cause::FloatBeforeEnabled);
}
