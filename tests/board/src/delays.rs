//! From the tick of the image's loop to the rising edge that carries what the step computed.

use crate::peripherals::timer::Pulse;
use crate::time::Ticks;

/// Delays of the first pulse on each channel after each tick.
#[derive(Clone, Debug, Default)]
pub struct Delays {
    /// The last two ticks: a long pulse ends after the tick that follows its own.
    ticks: [Option<Ticks>; 2],
    counted: [Option<Ticks>; 4],
    range: Option<(Ticks, Ticks)>,
    pulses: u64,
}

impl Delays {
    pub(crate) fn tick(&mut self, at: Ticks) {
        self.ticks = [self.ticks[1], Some(at)];
    }

    /// A pulse has ended.
    pub(crate) fn pulse(&mut self, pulse: Pulse) {
        let before = self.ticks.into_iter().flatten().filter(|tick| *tick <= pulse.rise).max();
        let Some(tick) = before.filter(|_| self.counted[pulse.channel] != before) else { return };
        let delay = pulse.rise - tick;
        let (shortest, longest) = self.range.unwrap_or((delay, delay));
        self.range = Some((shortest.min(delay), longest.max(delay)));
        self.counted[pulse.channel] = before;
        self.pulses += 1;
    }

    /// Shortest and longest so far.
    pub fn range(&self) -> Option<(Ticks, Ticks)> {
        self.range
    }

    /// How many there were.
    pub fn count(&self) -> u64 {
        self.pulses
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_pulse_after_each_tick_counts() {
        let mut delays = Delays::default();
        let pulse = |rise| Pulse { channel: 2, rise, width: 900 };
        delays.pulse(pulse(50));
        assert_eq!(delays.range(), None);
        delays.tick(100);
        delays.tick(1000);
        // it ended after the second tick, and began after the first
        delays.pulse(pulse(150));
        delays.pulse(pulse(600));
        delays.pulse(pulse(1070));
        assert_eq!((delays.range(), delays.count()), (Some((50, 70)), 2));
    }
}
