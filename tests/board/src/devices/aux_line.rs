//! An AUX line as the ESC at its end sees it: a level over time, and the pulses that it makes.

use super::level_shifter;
use crate::peripherals::pin::Drive;
use crate::time::Ticks;

/// The line behind the level shifter. Power comes with it low.
#[derive(Clone, Debug)]
pub(crate) struct AuxLine {
    drive: Drive,
    /// How long a line that was low stays so when the pin lets go.
    floats_low: Ticks,
    /// It is, or will be, at its level from this time on.
    level_from: Ticks,
    /// Since when it is high.
    rose_at: Option<Ticks>,
    /// Rise and width of the pulses that ended.
    pulses: Vec<(Ticks, Ticks)>,
}

impl AuxLine {
    /// At power-on the chip drives nothing.
    pub(crate) fn new(now: Ticks, floats_low: Ticks) -> Self {
        Self { drive: Drive::None, floats_low, level_from: now + floats_low, rose_at: None, pulses: Vec::new() }
    }

    /// The pin drives it like this from now on.
    pub(crate) fn drive(&mut self, drive: Drive, now: Ticks) {
        if drive == self.drive {
            return;
        }
        self.settle(now);
        self.drive = drive;
        // a line that is high already stays so
        self.level_from =
            now + if self.rose_at.is_some() { 0 } else { level_shifter::settles_after(drive, self.floats_low) };
        self.settle(now);
    }

    /// Lets happen what is due by now.
    fn settle(&mut self, now: Ticks) {
        if self.level_from > now {
            return;
        }
        match (self.rose_at, level_shifter::level(self.drive)) {
            (None, true) => self.rose_at = Some(self.level_from),
            (Some(rise), false) => {
                self.pulses.push((rise, self.level_from - rise));
                self.rose_at = None;
            }
            _ => {}
        }
    }

    /// Since when it is high; none while it is low.
    pub(crate) fn high_since(&mut self, now: Ticks) -> Option<Ticks> {
        self.settle(now);
        self.rose_at
    }

    /// Rise and width of the pulses that ended since the last call.
    pub(crate) fn take_pulses(&mut self) -> Vec<(Ticks, Ticks)> {
        std::mem::take(&mut self.pulses)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::level_shifter::FLOATS_LOW;
    use crate::time::TICKS_PER_US;

    const MILLISECOND: Ticks = 1000 * TICKS_PER_US;

    #[test]
    fn from_power_on_to_the_first_low_an_esc_sees_one_long_pulse() {
        for floats_low in [0, FLOATS_LOW] {
            let mut line = AuxLine::new(0, floats_low);
            line.drive(Drive::Strong(false), 3 * MILLISECOND);
            assert_eq!(line.take_pulses(), [(floats_low, 3 * MILLISECOND - floats_low)]);
            assert_eq!(line.high_since(4 * MILLISECOND), None);
        }
    }

    #[test]
    fn a_reset_in_the_low_of_a_pulse_train_makes_a_pulse_of_its_own() {
        // as PX4 measured: 58 us low, then high for 3.12 ms until the image drives the pin
        let mut line = AuxLine::new(0, FLOATS_LOW);
        line.drive(Drive::Strong(false), 10);
        line.drive(Drive::None, MILLISECOND);
        line.drive(Drive::Strong(false), MILLISECOND + (58 + 3120) * TICKS_PER_US);
        assert_eq!(line.take_pulses(), [(MILLISECOND + 58 * TICKS_PER_US, 3120 * TICKS_PER_US)]);
    }

    #[test]
    fn a_reset_in_the_high_of_a_pulse_makes_it_longer() {
        let mut line = AuxLine::new(0, FLOATS_LOW);
        line.drive(Drive::Strong(false), 0);
        line.drive(Drive::Strong(true), 100);
        line.drive(Drive::Weak(false), 200);
        line.drive(Drive::Strong(false), 5000);
        assert_eq!(line.take_pulses(), [(100, 4900)]);
    }

    #[test]
    fn a_line_that_is_let_go_for_less_than_it_takes_to_rise_stays_low() {
        let mut line = AuxLine::new(0, FLOATS_LOW);
        line.drive(Drive::Strong(false), 0);
        line.drive(Drive::None, 100);
        line.drive(Drive::Strong(false), 100 + FLOATS_LOW - 1);
        assert!(line.take_pulses().is_empty());
    }
}
