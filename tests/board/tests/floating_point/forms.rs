//! Names of floating-point instructions, and which of them an ELF contains.
//!
//! Encodings: ARMv7-M Architecture Reference Manual, DDI 0403, sections A6.4 to A6.7. Register numbers and conditions
//! (by `it`) make no form of their own; double-precision registers, which hold two words to be moved, do.

use std::collections::BTreeMap;

use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSection, ObjectSymbol};

/// The form of an instruction of the floating-point unit; none for all others.
pub fn form(first: u16, second: u16) -> Option<String> {
    let is_coprocessor = first & 0xec00 == 0xec00 && matches!(second >> 8 & 0xf, 10 | 11);
    if !is_coprocessor {
        return None;
    }
    let is_double = second & 0x100 != 0;
    let name = match first >> 8 {
        0xee if second & 0x10 == 0 => arithmetic(first, second),
        0xee => transfer(first, second),
        0xec | 0xed => load_or_store(first),
        _ => None,
    };
    let Some(name) = name else { return Some(format!("unknown {first:#06x} {second:#06x}")) };
    Some(if is_double { format!("{name}.64") } else { name.to_owned() })
}

/// A6.5, tables A6-1 and A6-2.
fn arithmetic(first: u16, second: u16) -> Option<&'static str> {
    let negates = second & 0x40 != 0;
    let pick = |plain, negated| Some(if negates { negated } else { plain });
    match first >> 4 & 0xb {
        0x0 => pick("vmla", "vmls"),
        0x1 => pick("vnmls", "vnmla"),
        0x2 => pick("vmul", "vnmul"),
        0x3 => pick("vadd", "vsub"),
        0x8 if !negates => Some("vdiv"),
        0x9 => pick("vfnms", "vfnma"),
        0xa => pick("vfma", "vfms"),
        0xb if !negates => Some("vmov immediate"),
        0xb => one_operand(first & 0xf, second & 0x80 != 0),
        _ => None,
    }
}

/// Table A6-3, from the operation's number and the bit that tells two apart.
fn one_operand(operation: u16, bit: bool) -> Option<&'static str> {
    let pick = |clear, set| Some(if bit { set } else { clear });
    match operation {
        0x0 => pick("vmov", "vabs"),
        0x1 => pick("vneg", "vsqrt"),
        0x4 => pick("vcmp", "vcmpe"),
        0x5 => pick("vcmp zero", "vcmpe zero"),
        0x8 => pick("vcvt.f32.u32", "vcvt.f32.s32"),
        0xc => pick("vcvtr.u32.f32", "vcvt.u32.f32"),
        0xd => pick("vcvtr.s32.f32", "vcvt.s32.f32"),
        _ => None,
    }
}

/// A6.7: between the core's registers and these.
fn transfer(first: u16, second: u16) -> Option<&'static str> {
    let is_double = second & 0x100 != 0;
    match (first >> 4 & 0xf, is_double) {
        (0x0, false) => Some("vmov from core"),
        (0x1, false) => Some("vmov to core"),
        (0xe, false) => Some("vmsr"),
        (0xf, false) => Some("vmrs"),
        _ => None,
    }
}

/// A6.6, and of A6.7 what moves two words.
fn load_or_store(first: u16) -> Option<&'static str> {
    // before or after, up or down, write back, load
    let is_set = |bit: u16| first >> bit & 1 != 0;
    match (is_set(8), is_set(7), is_set(5), is_set(4)) {
        (false, false, false, load) if is_set(6) => Some(if load { "vmov two to core" } else { "vmov two from core" }),
        (false, true, _, load) => Some(if load { "vldmia" } else { "vstmia" }),
        (true, false, true, load) => Some(if load { "vldmdb" } else { "vstmdb" }),
        (true, _, false, load) => Some(if load { "vldr" } else { "vstr" }),
        _ => None,
    }
}

/// The forms in a stream of Thumb instructions, each with how often it occurs.
pub fn forms(code: &[u16]) -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    let mut rest = code;
    while let [first, after @ ..] = rest {
        let second = after.first().copied().unwrap_or_default();
        if let Some(form) = form(*first, second) {
            *found.entry(form).or_default() += 1;
        }
        let is_wide = *first >= 0xe800;
        rest = if is_wide { after.get(1..).unwrap_or_default() } else { after };
    }
    found
}

/// The forms in an ELF's code. Its mapping symbols tell instructions from data (AAELF32, section 5.5.5).
pub fn forms_in_elf(elf: &[u8]) -> BTreeMap<String, usize> {
    let file = ElfFile32::<LittleEndian>::parse(elf).unwrap();
    let text = file.section_by_name(".text").unwrap();
    let (base, bytes) = (text.address(), text.data().unwrap());
    let mut marks: Vec<_> = file
        .symbols()
        .filter_map(|symbol| Some((symbol.address(), symbol.name().ok()?.get(..2)?.to_owned())))
        .filter(|(_, name)| name == "$t" || name == "$d")
        .collect();
    marks.sort();
    let ends = marks.iter().skip(1).map(|(address, _)| *address).chain([base + bytes.len() as u64]);
    let mut all = BTreeMap::new();
    for ((start, name), end) in marks.iter().zip(ends) {
        if name == "$t" && (base..end).contains(start) {
            let stretch = &bytes[(start - base) as usize..(end - base) as usize];
            let code: Vec<_> = stretch.chunks_exact(2).map(|half| u16::from_le_bytes([half[0], half[1]])).collect();
            forms(&code).into_iter().for_each(|(form, count)| *all.entry(form).or_default() += count);
        }
    }
    all
}

#[test]
fn forms_have_their_names() {
    // half-words by GNU as
    for (first, second, name) in [
        (0xee10, 0x1a60, "vnmla"),
        (0xee10, 0x1a20, "vnmls"),
        (0xeea0, 0x1a20, "vfma"),
        (0xeea0, 0x1a60, "vfms"),
        (0xee90, 0x1a60, "vfnma"),
        (0xee90, 0x1a20, "vfnms"),
        (0xeee1, 0x3a10, "vmsr"),
        (0xec52, 0x3b10, "vmov two to core.64"),
        (0xec42, 0x3a11, "vmov two from core"),
        (0xed30, 0x0a02, "vldmdb"),
        (0xeebe, 0x1ace, "unknown 0xeebe 0x1ace"), // vcvt to fixed point
        (0xeeb2, 0x1a40, "unknown 0xeeb2 0x1a40"), // vcvtb
        (0xfe80, 0x1a00, "unknown 0xfe80 0x1a00"), // vmaxnm, of a later architecture
    ] {
        assert_eq!(form(first, second).unwrap(), name);
    }
    // mcr p15; add.w; strd
    for (first, second) in [(0xee01, 0x3f10), (0xeb01, 0x0002), (0xe9c0, 0x1a02)] {
        assert_eq!(form(first, second), None);
    }
}
