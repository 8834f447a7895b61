//! Why a run ended before its time: the model is strict where silicon is, and never guesses.

use std::fmt;

/// What the image did that no board, or not this model, can go on from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A register, or a bit of one, without a model.
    Unmodelled(&'static str),
    /// What the document of a part forbids.
    Forbidden(&'static str),
    /// A peripheral whose clock is off in RCC.
    ClockOff,
    /// Floating point before the image enabled it in CPACR.
    FloatBeforeEnabled,
    /// A fault while the core could take none: lock-up.
    Lockup(&'static str),
    /// The CPU emulator itself failed.
    Emulator(String),
}

/// Where and why a run ended.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Stop {
    /// Why.
    pub cause: Cause,
    /// Address of the access; 0 if there is none.
    pub address: u32,
    /// What was written, `None` for a read.
    pub value: Option<u32>,
    /// Program counter of the instruction.
    pub pc: u32,
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cause, address, value, pc } = self;
        match value {
            Some(value) => write!(f, "{cause:?}: writing {value:#x} to {address:#010x} at pc {pc:#010x}"),
            None => write!(f, "{cause:?}: {address:#010x} at pc {pc:#010x}"),
        }
    }
}
