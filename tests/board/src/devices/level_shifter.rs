//! The level shifter TXS0108 (U901) between the chip's motor pins and the AUX connectors. Pixhawk schematic
//! PX4FMUv2.4.6; data sheet SCES642, section 7.3: pull-ups on both sides, output enable tied to 3.3 V.
//!
//! The pull-ups make what nobody drives high. PX4 measured it on this board (pull request 7182): after a reset in the
//! middle of nothing the line stays low for 58 us, then is high until the image drives the pin.

use crate::peripherals::pin::Drive;
use crate::time::{TICKS_PER_US, Ticks};

/// How long a line that was low stays so when the pin lets go, as measured on one board. The capacitance behind it
/// differs from vehicle to vehicle: tests take 0 too.
pub(crate) const FLOATS_LOW: Ticks = 58 * TICKS_PER_US;

/// The level that a line comes to.
///
/// The chip's pull-down of 30 to 50 kOhm stands against a pull-up of 4 kOhm on a high line and of 40 on a low one: the
/// line is high, or at half of the supply, where an ESC may see anything. It counts as high.
pub(crate) fn level(drive: Drive) -> bool {
    match drive {
        Drive::Strong(level) => level,
        Drive::Weak(_) | Drive::None => true,
    }
}

/// When the line gets to that level after the pin has changed.
pub(crate) fn settles_after(drive: Drive, floats_low: Ticks) -> Ticks {
    if matches!(drive, Drive::Strong(_)) { 0 } else { floats_low }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_driven_pin_makes_a_low_line() {
        assert!(!level(Drive::Strong(false)));
        for drive in [Drive::Strong(true), Drive::Weak(true), Drive::Weak(false), Drive::None] {
            assert!(level(drive), "{drive:?}");
        }
    }

    #[test]
    fn a_line_that_is_let_go_rises_late() {
        assert_eq!(settles_after(Drive::None, FLOATS_LOW), 58 * TICKS_PER_US);
        assert_eq!(settles_after(Drive::Strong(true), FLOATS_LOW), 0);
    }
}
