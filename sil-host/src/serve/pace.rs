//! Simulated time by the wall clock: how many ticks are due.

use std::time::{Duration, Instant};

/// Most wall time that is made up for at once; what a process that slept has missed beyond that is left out.
const BACKLOG_MAX: Duration = Duration::from_millis(200);

/// A clock that goes `speed` times as fast as the wall's.
pub struct Pace {
    speed: f64,
    last: Instant,
    owed_us: f64,
    missed_us: f64,
}

impl Pace {
    /// From `now` on.
    pub fn new(speed: f64, now: Instant) -> Self {
        Self { speed, last: now, owed_us: 0.0, missed_us: 0.0 }
    }

    /// Whole ticks of `tick_us` that are due since the last call.
    pub fn take_due(&mut self, now: Instant, tick_us: u64) -> u64 {
        self.owed_us += self.speed * now.duration_since(self.last).as_secs_f64() * 1e6;
        self.last = now;
        let most_us = self.speed * BACKLOG_MAX.as_secs_f64() * 1e6;
        if self.owed_us > most_us {
            self.missed_us += self.owed_us - most_us;
            self.owed_us = most_us;
        }
        let ticks = (self.owed_us / tick_us as f64).floor();
        self.owed_us -= ticks * tick_us as f64;
        ticks as u64
    }

    /// Simulated time that was left out because the computer was too slow, s.
    pub fn missed_s(&self) -> f64 {
        self.missed_us * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_due_by_the_wall_clock_times_the_speed() {
        let start = Instant::now();
        let mut pace = Pace::new(2.0, start);
        let at = |us: u64| start + Duration::from_micros(us);
        // rests are kept: 2 x 300 us are one tick of 500 us, 2 x 400 us later there are 900 us in hand
        assert_eq!([300, 700].map(|us| pace.take_due(at(us), 500)), [1, 1]);
        assert_eq!(pace.take_due(at(750), 500), 1);
        assert_eq!(pace.missed_s(), 0.0);
        // a second asleep: 0.2 s of it are made up for
        assert_eq!(pace.take_due(at(1_000_750), 500), 800);
        assert!((pace.missed_s() - 1.6).abs() < 1e-9);
    }
}
