//! As much of Thumb-2 as it takes to see where control may go, and which addresses a program builds in registers.
//!
//! Encodings: ARMv7-M Architecture Reference Manual, DDI 0403, sections A5.1 to A5.3 and A7.7.

/// An instruction's part in the flow of control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// None: it goes on behind it, or returns.
    None,
    /// May go to this address, for good or as a call.
    Branch(u32),
    /// Goes to an address in a register or in memory.
    Indirect,
    /// `movw`: a register gets this number.
    SetLow { register: u8, half: u16 },
    /// `movt`: the upper half of a register gets this number.
    SetHigh { register: u8, half: u16 },
}

const LR: u16 = 14;
const SP: u16 = 13;

/// Whether an instruction that begins with this half-word has a second one.
pub(crate) fn is_wide(first: u16) -> bool {
    first >= 0xe800
}

/// What the instruction at `address` does.
pub(crate) fn effect(address: u32, first: u16, second: u16) -> Effect {
    if is_wide(first) { wide(address, first, second) } else { narrow(address, first) }
}

fn narrow(address: u32, code: u16) -> Effect {
    let immediate = u32::from(code);
    match code {
        // b<c>: condition 14 is udf, 15 is svc
        0xd000..=0xddff => branch(address, sign_extended(immediate << 1, 9)),
        // b
        0xe000..=0xe7ff => branch(address, sign_extended(immediate << 1, 12)),
        // cbz, cbnz
        _ if code & 0xf500 == 0xb100 => branch(address, (immediate >> 3 & 0x40) | (immediate >> 2 & 0x3e)),
        // bx, blx; by the link register it is a return
        _ if code & 0xff00 == 0x4700 => {
            let is_return = code & 0x80 == 0 && code >> 3 & 0xf == LR;
            if is_return { Effect::None } else { Effect::Indirect }
        }
        // add pc, mov pc
        _ if code & 0xfd87 == 0x4487 => Effect::Indirect,
        _ => Effect::None,
    }
}

fn wide(address: u32, first: u16, second: u16) -> Effect {
    let base = first & 0xf;
    match (first, second) {
        // b.w and bl; b<c>.w has no condition 14 or 15
        _ if first & 0xf800 == 0xf000 && second & 0x9000 == 0x9000 => branch(address, far(first, second)),
        _ if first & 0xf800 == 0xf000 && second & 0xd000 == 0x8000 && first & 0x0380 != 0x0380 => {
            branch(address, far_conditional(first, second))
        }
        _ if first & 0xfbf0 == 0xf240 && second & 0x8000 == 0 => {
            Effect::SetLow { register: destination(second), half: half(first, second) }
        }
        _ if first & 0xfbf0 == 0xf2c0 && second & 0x8000 == 0 => {
            Effect::SetHigh { register: destination(second), half: half(first, second) }
        }
        // ldr.w pc and ldm with pc; from the stack they are returns
        _ if first & 0xff70 == 0xf850 && second >> 12 == 15 && base != SP => Effect::Indirect,
        _ if first & 0xfe50 == 0xe810 && second & 0x8000 != 0 && base != SP => Effect::Indirect,
        _ => Effect::None,
    }
}

/// Offsets count from two half-words on.
fn branch(address: u32, offset: u32) -> Effect {
    Effect::Branch(address.wrapping_add(4).wrapping_add(offset))
}

fn sign_extended(value: u32, bits: u32) -> u32 {
    let unused = 32 - bits;
    ((value << unused) as i32 >> unused) as u32
}

/// Encoding T4 of B, T1 of BL: 25 bits, two of them disguised by the sign.
fn far(first: u16, second: u16) -> u32 {
    let (first, second) = (u32::from(first), u32::from(second));
    let sign = first >> 10 & 1;
    let bit_23 = !(second >> 13 ^ sign) & 1;
    let bit_22 = !(second >> 11 ^ sign) & 1;
    let offset = sign << 24 | bit_23 << 23 | bit_22 << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    sign_extended(offset, 25)
}

/// Encoding T3 of B: 21 bits.
fn far_conditional(first: u16, second: u16) -> u32 {
    let (first, second) = (u32::from(first), u32::from(second));
    let upper = (first >> 10 & 1) << 20 | (second >> 11 & 1) << 19 | (second >> 13 & 1) << 18;
    sign_extended(upper | (first & 0x3f) << 12 | (second & 0x7ff) << 1, 21)
}

fn destination(second: u16) -> u8 {
    (second >> 8 & 0xf) as u8
}

/// The 16 bits of movw and movt, in four pieces.
fn half(first: u16, second: u16) -> u16 {
    (first & 0xf) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where each stands. The half-words come from GNU as, for a Cortex-M4.
    const AT: u32 = 0x0800_4000;

    #[test]
    fn branches_and_calls_give_their_target() {
        for (first, second, offset) in [
            (0xe7fe, 0, 0),               // b .
            (0xe000, 0, 4),               // b .+4
            (0xd1fd, 0, -2),              // bne .-2
            (0xb108, 0, 6),               // cbz r0, .+6
            (0xb908, 0, 6),               // cbnz r0, .+6
            (0xbbf9, 0, 0x82),            // cbnz r1, .+130
            (0xf000, 0xf800, 4),          // bl .+4
            (0xf7ff, 0xfffe, 0),          // bl .
            (0xf7ff, 0xbffe, 0),          // b.w .
            (0xf3ff, 0xd7ff, 0x100_0002), // bl .+0x1000002
            (0xf400, 0xd000, -0xff_fffc), // bl .-0xfffffc
            (0xf43f, 0xaffe, 0),          // beq.w .
            (0xf040, 0x8000, 4),          // bne.w .+4
        ] {
            let expected = Effect::Branch(AT.wrapping_add_signed(offset));
            assert_eq!(effect(AT, first, second), expected, "{first:#06x} {second:#06x}");
        }
    }

    #[test]
    fn ways_through_a_register_are_seen_returns_are_none() {
        // blx r3; bx r3; blx lr; mov pc, r0; add pc, r0; ldr.w pc, [r0]; ldr.w pc, [pc, #4]; ldmia.w r0, {r1, pc}
        for (first, second) in [
            (0x4798, 0),
            (0x4718, 0),
            (0x47f0, 0),
            (0x4687, 0),
            (0x4487, 0),
            (0xf8d0, 0xf000),
            (0xf8df, 0xf004),
            (0xe890, 0x8002),
        ] {
            assert_eq!(effect(AT, first, second), Effect::Indirect, "{first:#06x} {second:#06x}");
        }
        // bx lr; pop {r7, pc}; ldmia.w sp!, {r4, pc}; ldr.w pc, [sp], #4
        for (first, second) in [(0x4770, 0), (0xbd80, 0), (0xe8bd, 0x8010), (0xf85d, 0xfb04)] {
            assert_eq!(effect(AT, first, second), Effect::None, "{first:#06x} {second:#06x}");
        }
    }

    #[test]
    fn halves_of_an_address_are_put_together() {
        // movw r1, #0x1234; movt r9, #0xabcd
        assert_eq!(effect(AT, 0xf241, 0x2134), Effect::SetLow { register: 1, half: 0x1234 });
        assert_eq!(effect(AT, 0xf6ca, 0x39cd), Effect::SetHigh { register: 9, half: 0xabcd });
    }

    #[test]
    fn what_resembles_a_branch_is_none() {
        // udf #0; svc #0; nop; it eq; dsb sy; msr basepri, r0; mrs r0, ipsr; tbb [pc, r0]; add.w r0, r1, r2; vadd.f32
        for (first, second) in [
            (0xde00, 0),
            (0xdf00, 0),
            (0xbf00, 0),
            (0xbf08, 0),
            (0xf3bf, 0x8f4f),
            (0xf380, 0x8811),
            (0xf3ef, 0x8005),
            (0xe8df, 0xf000),
            (0xeb01, 0x0002),
            (0xee30, 0x0a20),
        ] {
            assert_eq!(effect(AT, first, second), Effect::None, "{first:#06x} {second:#06x}");
        }
    }
}
