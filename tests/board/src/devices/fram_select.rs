//! The select line of the FM25V01 as the chip sees it. Cypress 001-84497, "AC Switching Characteristics": `tCSU`,
//! `tCSH`, `tD`.
//!
//! A command begins when the line falls and acts when it rises. Between two commands it must be high for `tD`; a pulse
//! that is shorter than the pin's own edge does not reach the chip at all, which then takes the next command's bytes as
//! more of the last one's.

use crate::peripherals::pin::width_at_far_end_ns;
use crate::time::{TICKS_PER_US, Ticks};

/// Deselect time `tD`, ns: from memory 40 at 2.7 V and more, 60 below. The board is held to the longer one.
pub(crate) const DESELECT_NS: f64 = 60.0;
/// Said of a shorter one.
pub const DESELECT_TOO_SHORT: &str =
    "FRAM deselected for less than tD (FM25V01 data sheet 001-84497, AC switching characteristics)";

/// What the chip notices when the line falls again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Deselected {
    /// It rose and fell: the last command acted, another begins.
    Properly,
    /// It rose for less than `tD`: nothing is promised of either command.
    Briefly,
    /// It did not get there: the last command goes on.
    Unnoticed,
}

/// How long the line has been high.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SelectLine {
    rose_at: Option<Ticks>,
}

impl SelectLine {
    /// The pin goes high.
    pub(crate) fn rise(&mut self, now: Ticks) {
        self.rose_at = Some(now);
    }

    /// The pin goes low, its edges taking this long.
    pub(crate) fn fall(&mut self, now: Ticks, edge_ns: f64) -> Deselected {
        // before the first command it was high for ever
        let Some(rose_at) = self.rose_at.take() else { return Deselected::Properly };
        let width_ns = now.saturating_sub(rose_at) as f64 * 1000.0 / TICKS_PER_US as f64;
        match width_at_far_end_ns(width_ns, edge_ns) {
            None => Deselected::Unnoticed,
            Some(high_ns) if high_ns < DESELECT_NS => Deselected::Briefly,
            Some(_) => Deselected::Properly,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peripherals::pin::{Load, Speed};

    fn after(width_ns: u64, speed: Speed, load: Load) -> Deselected {
        let mut line = SelectLine::default();
        line.rise(1000);
        line.fall(1000 + (width_ns * TICKS_PER_US).div_ceil(1000), speed.edge_ns(load))
    }

    #[test]
    fn three_cycles_of_the_core_are_no_deselection_at_any_speed() {
        assert_eq!(after(18, Speed::Low, Load::Heavy), Deselected::Unnoticed);
        for speed in [Speed::Low, Speed::Medium, Speed::High, Speed::VeryHigh] {
            for load in [Load::Light, Load::Heavy] {
                assert_ne!(after(18, speed, load), Deselected::Properly, "{speed:?} {load:?}");
            }
        }
    }

    #[test]
    fn the_deselect_time_counts_at_the_chip() {
        // the edge of 100 ns takes 50 of the pulse
        assert_eq!(after(105, Speed::Low, Load::Heavy), Deselected::Briefly);
        assert_eq!(after(115, Speed::Low, Load::Heavy), Deselected::Properly);
        assert_eq!(after(60, Speed::High, Load::Heavy), Deselected::Briefly);
        assert_eq!(after(66, Speed::High, Load::Heavy), Deselected::Properly);
    }

    #[test]
    fn the_first_command_needs_no_deselection() {
        assert_eq!(SelectLine::default().fall(5, 100.0), Deselected::Properly);
    }
}
