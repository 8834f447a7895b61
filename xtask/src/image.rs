//! What must hold of the linked image.

use std::fmt;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSegment, ObjectSymbol, SectionKind};

/// What the image takes, in bytes.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Size {
    flash: u64,
    ram: u64,
}

impl Size {
    /// How much more than another image.
    pub(crate) fn beyond(&self, other: &Self) -> Self {
        Self { flash: self.flash.saturating_sub(other.flash), ram: self.ram.saturating_sub(other.ram) }
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes of flash, {} bytes of RAM before the stack", self.flash, self.ram)
    }
}

/// Reads the linked image; fails if it computes in `f64`.
pub(crate) fn check(path: &Path) -> Result<Size> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let file = ElfFile32::<object::LittleEndian>::parse(&*bytes)
        .with_context(|| format!("{} is no ELF file", path.display()))?;
    let names = file.symbols().filter_map(|symbol| symbol.name().ok().map(str::to_owned));
    let in_f64 = names.filter(|name| is_f64_routine(name)).collect::<Vec<_>>();
    if !in_f64.is_empty() {
        bail!("the image computes in f64, which the flight controller does in software: {}", in_f64.join(", "));
    }
    Ok(size(&file))
}

/// Whether this is a routine for `f64` of the compiler's run-time library, by the names of the ARM run-time ABI
/// (IHI 0043, tables 2 to 8): `__aeabi_dadd`, `__aeabi_d2iz`, `__aeabi_f2d`, ...
///
/// The Cortex-M4F has no instruction for `f64`, so all arithmetic on it ends up in one of these.
fn is_f64_routine(name: &str) -> bool {
    let Some(routine) = name.strip_prefix("__aeabi_") else {
        return false;
    };
    let takes = routine.starts_with('d') || routine.starts_with("cd");
    takes || routine.ends_with("2d")
}

/// What is loaded lies in flash, initial values of variables included; what is writable is RAM at run time.
fn size<'data>(file: &impl Object<'data>) -> Size {
    let flash = file.segments().map(|segment| segment.file_range().1).sum();
    let writable = file.sections().filter(|s| matches!(s.kind(), SectionKind::Data | SectionKind::UninitializedData));
    Size { flash, ram: writable.map(|section| section.size()).sum() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_arm_run_time_abi_are_told_apart() {
        for name in ["dadd", "dsub", "drsub", "dmul", "ddiv", "dcmplt", "cdcmple", "d2f", "d2iz", "f2d", "i2d", "ul2d"]
        {
            assert!(is_f64_routine(&format!("__aeabi_{name}")), "{name}");
        }
        for name in
            ["fadd", "idiv", "idivmod", "uidiv", "ldivmod", "lmul", "memcpy", "memset4", "unwind_cpp_pr0", "f2iz"]
        {
            assert!(!is_f64_routine(&format!("__aeabi_{name}")), "{name}");
        }
        assert!(!is_f64_routine("main"));
    }
}
