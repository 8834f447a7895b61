//! What the documents of the board's parts forbid: each rule is the sentence that a run stops with.
//!
//! A test may tolerate some: those stop nothing and have no effect, but are counted.

use crate::time::Ticks;

pub use crate::devices::fram_select::DESELECT_TOO_SHORT;
pub use crate::devices::io_chip::registers::{
    AMBIGUOUS_ARMING, MAIN_DRIVEN, NO_SUCH_REGISTER, NOT_SAFE_FIRST, WRITE_UNRECOGNISED,
};
pub use crate::devices::mpu6000::SELECT_HOLD_TOO_SHORT;
pub use crate::devices::mpu6000_start::PATHS_NOT_RESET;
pub use crate::devices::sd_card::{BLOCK_UNAWAITED, CLOCK_TOO_FAST};
pub use crate::devices::sensor_rail::{BACK_FED, RAMP_NOT_FROM_ZERO, SOURCES_CURRENT};
pub use crate::peripherals::spi_clock::{CLOCK_FLOATS, LAST_BIT_LATE, PIN_TOO_SLOW};

/// Every one of them.
pub const ALL: [&str; 16] = [
    DESELECT_TOO_SHORT,
    SELECT_HOLD_TOO_SHORT,
    PATHS_NOT_RESET,
    BACK_FED,
    RAMP_NOT_FROM_ZERO,
    SOURCES_CURRENT,
    CLOCK_FLOATS,
    LAST_BIT_LATE,
    PIN_TOO_SLOW,
    WRITE_UNRECOGNISED,
    NOT_SAFE_FIRST,
    MAIN_DRIVEN,
    AMBIGUOUS_ARMING,
    NO_SUCH_REGISTER,
    CLOCK_TOO_FAST,
    BLOCK_UNAWAITED,
];

/// A rule that was broken without stopping the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Broken {
    /// Which.
    pub rule: &'static str,
    /// When first.
    pub first: Ticks,
    /// How often.
    pub times: u64,
}
