//! A side's own clock: its ticks in whole microseconds, without drift at any rate.

/// Tick k is at k / rate, rounded to a microsecond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clock {
    rate_hz: u64,
    next_tick: u64,
}

impl Clock {
    /// Starts at zero. A rate of zero counts as one.
    pub fn new(rate_hz: u32) -> Self {
        Self { rate_hz: u64::from(rate_hz.max(1)), next_tick: 0 }
    }

    /// Time of the next tick, µs.
    pub fn next_us(&self) -> u64 {
        Self::tick_us(self.next_tick, self.rate_hz)
    }

    /// Time of a tick of a clock of that rate, µs.
    pub fn tick_us(tick: u64, rate_hz: u64) -> u64 {
        (tick * 1_000_000 + rate_hz / 2) / rate_hz
    }

    /// True, and on to the next tick, if one is due.
    pub fn tick(&mut self, now_us: u64) -> bool {
        let due = self.next_us() <= now_us;
        if due {
            self.next_tick += 1;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_drift_at_rates_that_do_not_divide_a_second() {
        let mut clock = Clock::new(300);
        let mut last = 0;
        for second in 0..10 {
            for _ in 0..300 {
                last = clock.next_us();
                assert!(clock.tick(last));
            }
            assert_eq!(clock.next_us(), (second + 1) * 1_000_000);
        }
        assert!(!clock.tick(last));
    }
}
