//! What is compared: instructions that make s2 from s0 and s1, and what the host makes of the same numbers.

use std::cmp::Ordering;

/// What the host makes of s0 and s1.
pub type Reference = fn(f32, f32) -> u32;

/// `vmrs apsr_nzcv, fpscr; mrs r3, apsr; vmov s2, r3`: the flags of a comparison become the result.
macro_rules! flags_of {
    ($first:literal, $second:literal) => {
        &[$first, $second, 0xeef1, 0xfa10, 0xf3ef, 0x8300, 0xee01, 0x3a10]
    };
}

/// Half-words, by GNU as, with the reference. Denormals are kept, and what is rounded goes to the nearest, ties to
/// even.
pub const INSTRUCTIONS: [(&[u16], Reference); 28] = [
    // vadd, vsub, vmul, vnmul, vdiv .f32 s2, s0, s1
    (&[0xee30, 0x1a20], |a, b| (a + b).to_bits()),
    (&[0xee30, 0x1a60], |a, b| (a - b).to_bits()),
    (&[0xee20, 0x1a20], |a, b| (a * b).to_bits()),
    (&[0xee20, 0x1a60], |a, b| (-(a * b)).to_bits()),
    (&[0xee80, 0x1a20], |a, b| (a / b).to_bits()),
    // vsqrt, vabs, vneg, vmov .f32 s2, s0
    (&[0xeeb1, 0x1ac0], |a, _| a.sqrt().to_bits()),
    (&[0xeeb0, 0x1ac0], |a, _| a.abs().to_bits()),
    (&[0xeeb1, 0x1a40], |a, _| (-a).to_bits()),
    (&[0xeeb0, 0x1a40], |a, _| a.to_bits()),
    // vcvt .s32.f32, .u32.f32, .f32.s32, .f32.u32 s2, s0
    (&[0xeebd, 0x1ac0], |a, _| a as i32 as u32),
    (&[0xeebc, 0x1ac0], |a, _| a as u32),
    (&[0xeeb8, 0x1ac0], |a, _| (a.to_bits() as i32 as f32).to_bits()),
    (&[0xeeb8, 0x1a40], |a, _| (a.to_bits() as f32).to_bits()),
    // vmov s2, s1; vmla, vmls .f32 s2, s0, s1: multiply, then add, each rounded
    (&[0xeeb0, 0x1a60, 0xee00, 0x1a20], |a, b| (b + a * b).to_bits()),
    (&[0xeeb0, 0x1a60, 0xee00, 0x1a60], |a, b| (b - a * b).to_bits()),
    // vcmp, vcmpe .f32 s0, s1; the same with #0.0
    (flags_of!(0xeeb4, 0x0a60), compared),
    (flags_of!(0xeeb4, 0x0ae0), compared),
    (flags_of!(0xeeb5, 0x0a40), |a, _| compared(a, 0.0)),
    (flags_of!(0xeeb5, 0x0ac0), |a, _| compared(a, 0.0)),
    // vmov r3, s1; vmov s2, r3
    (&[0xee10, 0x3a90, 0xee01, 0x3a10], |_, b| b.to_bits()),
    // vstr s1, [sp, #-8]; vldr s2, [sp, #-8], and the same of d0 and d1
    (&[0xed4d, 0x0a02, 0xed1d, 0x1a02], |_, b| b.to_bits()),
    (&[0xed0d, 0x0b02, 0xed1d, 0x1b02], |a, _| a.to_bits()),
    // vpush {s0, s1}; vpop {s2, s3}, and the same of d0 and d1
    (&[0xed2d, 0x0a02, 0xecbd, 0x1a02], |a, _| a.to_bits()),
    (&[0xed2d, 0x0b02, 0xecbd, 0x1b02], |a, _| a.to_bits()),
    // sub sp, #8; mov r3, sp; vstmia r3, {s0, s1}; vpop {s2, s3}, and the same of d0 and d1
    (&[0xb082, 0x466b, 0xec83, 0x0a02, 0xecbd, 0x1a02], |a, _| a.to_bits()),
    (&[0xb082, 0x466b, 0xec83, 0x0b02, 0xecbd, 0x1b02], |a, _| a.to_bits()),
    // vmov r3, r4, s0, s1; vmov s2, s3, r4, r3, and, not crossed over, r3, r4, d0; d1, r3, r4
    (&[0xec54, 0x3a10, 0xec43, 0x4a11], |_, b| b.to_bits()),
    (&[0xec54, 0x3b10, 0xec44, 0x3b11], |a, _| a.to_bits()),
];

/// N, Z, C, V in the upper bits (ARMv7-M ARM A2.5.3).
fn compared(a: f32, b: f32) -> u32 {
    match a.partial_cmp(&b) {
        Some(Ordering::Less) => 8 << 28,
        Some(Ordering::Equal) => 6 << 28,
        Some(Ordering::Greater) => 2 << 28,
        None => 3 << 28,
    }
}

/// `vmov.f32 s2, #immediate` with each of the 256 that there are, and the number (VFPExpandImm, A6.4.1).
pub fn immediates() -> impl Iterator<Item = ([u16; 2], u32)> {
    (0..=255u8).map(|code| {
        let instruction = [0xeeb0 | u16::from(code >> 4), 0x1a00 | u16::from(code & 0xf)];
        let (sign, exponent, fraction) = (code >> 7, code >> 4 & 7, code & 0xf);
        // three bits of exponent, the first of them upside down
        let power = i32::from(exponent ^ 4) - 3;
        let magnitude = (1.0 + f32::from(fraction) / 16.0) * (power as f32).exp2();
        (instruction, (if sign == 0 { magnitude } else { -magnitude }).to_bits())
    })
}
