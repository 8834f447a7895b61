//! What a block of instructions costs the core by itself. Cortex-M4 technical reference manual (DDI 0439), tables 3-1
//! and 7-1; where a table gives a range its upper end is taken, but for loads, which are not counted as pipelined.

/// Refilling the pipeline after a jump: 1 to 3 cycles, by alignment.
pub(crate) const REFILL: u64 = 2;
const DIVIDE: u64 = 12;
const FLOAT_DIVIDE: u64 = 14;
const FLOAT_MULTIPLY_ADD: u64 = 3;

/// A block of code.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Block {
    pub(crate) length: u32,
    pub(crate) instructions: u32,
    pub(crate) cycles: u64,
    /// Addresses of its literals.
    pub(crate) literals: Vec<u32>,
}

impl Block {
    /// The block that these bytes at `start` are.
    pub(crate) fn decode(start: u32, bytes: &[u8]) -> Self {
        let mut block = Self { length: bytes.len() as u32, ..Self::default() };
        let half = |at: usize| bytes.get(at..at + 2).map_or(0, |two| u16::from_le_bytes([two[0], two[1]]));
        let mut at = 0;
        while at + 1 < bytes.len() {
            let (first, address) = (half(at), start + at as u32);
            let is_long = is_long(first);
            let (cycles, literal) = if is_long { long(first, half(at + 2), address) } else { short(first, address) };
            block.cycles += cycles;
            block.literals.extend(literal);
            block.instructions += 1;
            at += if is_long { 4 } else { 2 };
        }
        block
    }
}

/// A half-word, or two if its top five bits say so (ARMv7-M ARM A5.1).
fn is_long(first: u16) -> bool {
    first >> 11 >= 0b11101
}

fn short(half: u16, address: u32) -> (u64, Option<u32>) {
    let listed = u64::from((half & 0xff).count_ones());
    match half >> 11 {
        0b01001 => (2, Some(literal(address, u32::from(half & 0xff) * 4, true))),
        // register offset: stores are 000 to 010
        0b01010 => (if half >> 9 & 0b11 == 0b11 { 2 } else { 1 }, None),
        0b01011 | 0b01101 | 0b01111 | 0b10001 | 0b10011 => (2, None),
        0b10110 | 0b10111 if half >> 9 & 0b11 == 0b10 => (1 + listed + u64::from(half >> 8 & 1), None),
        0b11000 | 0b11001 => (1 + listed, None),
        _ => (1, None),
    }
}

fn long(first: u16, second: u16, address: u32) -> (u64, Option<u32>) {
    let loads = first >> 4 & 1 != 0;
    let (adds, imm8) = (first >> 7 & 1 != 0, u32::from(second & 0xff));
    match first >> 8 {
        0xe8 | 0xe9 if first >> 6 & 1 == 0 => (1 + u64::from(second.count_ones()), None),
        0xe8 | 0xe9 => (3, None),
        0xf8 | 0xf9 if loads && first & 0xf == 0xf => (2, Some(literal(address, u32::from(second & 0xfff), adds))),
        0xf8 | 0xf9 => (if loads { 2 } else { 1 }, None),
        0xfb if first >> 4 & 0xf == 0x9 || first >> 4 & 0xf == 0xb => (DIVIDE, None),
        0xfb if first >> 4 & 0xf == 0 && second >> 12 != 0xf => (2, None),
        0xec | 0xed if first & 0xf == 0xf && first >> 8 == 0xed => (2, Some(literal(address, imm8 * 4, adds))),
        0xed if first >> 5 & 1 == 0 => (2, None),
        0xec | 0xed => (1 + u64::from(imm8), None),
        0xee => (floating_point(first, second), None),
        _ => (1, None),
    }
}

/// Data processing: opc1 in bits 7 to 4 of the first half-word, opc2 in bits 3 to 0 (A6.4).
fn floating_point(first: u16, second: u16) -> u64 {
    let is_data_processing = second >> 4 & 1 == 0;
    match first >> 4 & 0b1011 {
        _ if !is_data_processing => 1,
        0b1000 => FLOAT_DIVIDE,
        // VSQRT: opc2 0001, opc3 11
        0b1011 if first & 0xf == 1 && second >> 6 & 0b11 == 0b11 => FLOAT_DIVIDE,
        0b0000 | 0b0001 | 0b1001 | 0b1010 => FLOAT_MULTIPLY_ADD,
        _ => 1,
    }
}

fn literal(address: u32, offset: u32, adds: bool) -> u32 {
    let base = (address + 4) & !3;
    if adds { base.wrapping_add(offset) } else { base.wrapping_sub(offset) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycles(halves: &[u16]) -> u64 {
        let bytes = halves.iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<_>>();
        Block::decode(0x0800_4000, &bytes).cycles
    }

    #[test]
    fn instructions_cost_what_the_manual_says() {
        for (name, halves, expected) in [
            ("adds r0, r0, r1", &[0x1840][..], 1),
            ("ldr r0, [r1]", &[0x6808], 2),
            ("str r0, [r1]", &[0x6008], 1),
            ("push {r4, r5, lr}", &[0xb530], 4),
            ("pop {r4, r5, pc}", &[0xbd30], 4),
            ("stmia r0!, {r1, r2, r3}", &[0xc00e], 4),
            ("ldmdb / pop.w {r4-r11}", &[0xe8bd, 0x0ff0], 9),
            ("ldrd r0, r1, [r2]", &[0xe9d2, 0x0100], 3),
            ("ldr.w r0, [r1, #4]", &[0xf8d1, 0x0004], 2),
            ("str.w r0, [r1, #4]", &[0xf8c1, 0x0004], 1),
            ("udiv r0, r1, r2", &[0xfbb1, 0xf0f2], 12),
            ("mul r0, r1, r2", &[0xfb01, 0xf002], 1),
            ("mla r0, r1, r2, r3", &[0xfb01, 0x3002], 2),
            ("vadd.f32 s0, s1, s2", &[0xee30, 0x0a81], 1),
            ("vmul.f32 s0, s1, s2", &[0xee20, 0x0a81], 1),
            ("vdiv.f32 s0, s1, s2", &[0xee80, 0x0a81], 14),
            ("vsqrt.f32 s0, s1", &[0xeeb1, 0x0ae0], 14),
            ("vmov.f32 s0, s1", &[0xeeb0, 0x0a60], 1),
            ("vmla.f32 s0, s1, s2", &[0xee00, 0x0a81], 3),
            ("vldr s0, [r0]", &[0xed90, 0x0a00], 2),
            ("vpush {s16-s23}", &[0xed2d, 0x8a08], 9),
            ("b.", &[0xe7fe], 1),
        ] {
            assert_eq!(cycles(halves), expected, "{name}");
        }
    }

    #[test]
    fn literals_lie_where_the_program_counter_says() {
        let bytes = [0x4801_u16, 0xbf00, 0xf8df, 0x0008].iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<_>>();
        let block = Block::decode(0x0800_4000, &bytes);
        assert_eq!((block.instructions, block.literals), (3, vec![0x0800_4008, 0x0800_4010]));
    }
}
