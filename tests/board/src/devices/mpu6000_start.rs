//! How an MPU6000 comes up. Register map RM-MPU-6000A-00, sections 4.25 and 4.28; product specification
//! PS-MPU-6000A-00, section 6.3; PX4's driver mpu6000.cpp, whose comment says that the chip "frequently comes up in a
//! bad state where all transfers come as zero", and which tries up to five times.

use crate::time::{TICKS_PER_S, Ticks};

const MILLISECOND: Ticks = TICKS_PER_S / 1000;
/// From power until registers answer: 11 ms are typical, 100 the most. Tests take both.
pub(crate) const START_UP: [Ticks; 2] = [11 * MILLISECOND, 100 * MILLISECOND];
/// After DEVICE_RESET, and again after the signal paths' reset (section 4.28, for the serial bus SPI).
pub(crate) const RESET: Ticks = 100 * MILLISECOND;

/// Said of data that are read too early.
pub const PATHS_NOT_RESET: &str =
    "MPU6000 data read after DEVICE_RESET without a reset of the signal paths (RM-MPU-6000A section 4.28)";

/// Its state of waking.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    /// When it answers; none without power.
    ready_at: Option<Ticks>,
    start_up: Ticks,
    /// So often will it come up badly yet: all transfers as zero, until it is reset.
    bad: u8,
    paths_pending: bool,
}

impl Default for Start {
    fn default() -> Self {
        Self { ready_at: None, start_up: START_UP[1], bad: 0, paths_pending: false }
    }
}

impl Start {
    /// From power to the first answer, from now on.
    pub(crate) fn set_start_up(&mut self, start_up: Ticks) {
        self.start_up = start_up;
    }

    /// It will come up badly so many times from here on.
    pub(crate) fn come_up_badly(&mut self, times: u8) {
        self.bad = times;
    }

    /// Power comes, or goes.
    pub(crate) fn power(&mut self, on: bool, now: Ticks) {
        self.ready_at = on.then_some(now + self.start_up);
        self.paths_pending = false;
    }

    pub(crate) fn is_powered(&self) -> bool {
        self.ready_at.is_some()
    }

    /// DEVICE_RESET.
    pub(crate) fn reset(&mut self, now: Ticks) {
        if self.is_powered() {
            self.ready_at = Some(now + RESET);
            self.bad = self.bad.saturating_sub(1);
            self.paths_pending = true;
        }
    }

    /// SIGNAL_PATH_RESET of gyro, accelerometer and thermometer.
    pub(crate) fn reset_paths(&mut self, now: Ticks) {
        self.paths_pending = false;
        self.ready_at = self.ready_at.map(|at| at.max(now + RESET));
    }

    /// Does it take and give bytes?
    pub(crate) fn answers(&self, now: Ticks) -> bool {
        self.hears(now) && self.bad == 0
    }

    /// Does it at least take a reset?
    pub(crate) fn hears(&self, now: Ticks) -> bool {
        self.ready_at.is_some_and(|at| now >= at)
    }

    /// Are its data to be relied upon?
    pub(crate) fn check_data(&self) -> Result<(), &'static str> {
        if self.paths_pending { Err(PATHS_NOT_RESET) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_mute_until_its_start_up_time_is_over() {
        for start_up in START_UP {
            let mut start = Start::default();
            start.set_start_up(start_up);
            assert!(!start.answers(TICKS_PER_S));
            start.power(true, 0);
            assert!(!start.answers(start_up - 1));
            assert!(start.answers(start_up));
        }
    }

    #[test]
    fn a_reset_takes_100_ms_and_the_signal_paths_want_theirs() {
        let mut start = Start::default();
        start.power(true, 0);
        start.reset(TICKS_PER_S);
        assert!(!start.answers(TICKS_PER_S + RESET - 1));
        assert!(start.answers(TICKS_PER_S + RESET));
        assert_eq!(start.check_data(), Err(PATHS_NOT_RESET));
        start.reset_paths(TICKS_PER_S + RESET);
        assert_eq!(start.check_data(), Ok(()));
        assert!(!start.answers(TICKS_PER_S + 2 * RESET - 1));
    }

    #[test]
    fn a_bad_start_is_mended_by_as_many_resets() {
        let mut start = Start::default();
        start.come_up_badly(3);
        start.power(true, 0);
        for attempt in 1..=3 {
            let now = attempt * TICKS_PER_S;
            assert!(start.hears(now) && !start.answers(now), "{attempt}");
            start.reset(now);
        }
        assert!(start.answers(4 * TICKS_PER_S));
    }
}
