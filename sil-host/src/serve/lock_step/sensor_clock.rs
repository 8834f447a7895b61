//! The time that a simulator's sensors give: how often they come, which of them make a step, and what is missing.
//!
//! The core's filters and gains are made for one rate, so the rate is found before the first step, from the times of
//! [`LEARNT`] intervals in a row, and kept. Up to 400 steps per second each sample makes a step; of faster sensors
//! every second one does, or every third, and the samples between are in the step's input, as on the board.

use std::collections::VecDeque;

use shared_control::signals::IMU_SAMPLES_MAX;

use crate::serve::GivenRates;

/// Intervals that the rate is found from.
const LEARNT: usize = 16;
/// Share by which each of them may differ from their mean: times in whole milliseconds of 400 samples a second do by a
/// fifth.
const JITTER: f64 = 0.35;
/// Intervals without a rate among them after which that is said.
const IRREGULAR_AFTER: u32 = 200;
/// The core's shortest step, µs: the board's at 400 Hz.
const STEP_MIN_US: f64 = 2_500.0;
/// Its longest, µs: the board's at 100 Hz.
const STEP_MAX_US: f64 = 10_000.0;
/// How far beyond either end is rounding.
const ROUNDING: f64 = 1e-3;
/// A longer gap is another simulation, µs.
const GAP_MAX_US: i64 = 1_000_000;

/// What the time of a sample means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Beat {
    /// The rate is not known yet.
    Unknown,
    /// The times follow no rate, though many have come: the shortest and the longest interval, µs. Said once.
    Irregular(u64, u64),
    /// The rate is found; this sample is time 0.
    Found(Pace),
    /// They come at a rate that the core cannot fly with: one of so many µs. Said once.
    Unusable(f64),
    /// The time of the last sample once more.
    Again,
    /// The next sample, behind so many that are missing.
    Next {
        /// Samples that did not come in between.
        missing: u32,
    },
    /// Not the same simulation any more: so many µs later than the last, or earlier.
    Jump(i64),
}

/// The pace of the sensors and of the core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace {
    /// From sample to sample, µs.
    pub(super) sample_us: f64,
    /// Samples to a step.
    pub(super) per_step: u32,
}

impl Pace {
    /// For sensors that come once in so many µs; none if the core cannot fly with them.
    fn new(sample_us: f64) -> Option<Self> {
        let per_step = (STEP_MIN_US * (1.0 - ROUNDING) / sample_us).ceil().max(1.0);
        let fits = per_step <= IMU_SAMPLES_MAX as f64 && per_step * sample_us <= STEP_MAX_US * (1.0 + ROUNDING);
        fits.then_some(Self { sample_us, per_step: per_step as u32 })
    }

    /// The rates that the core is made for.
    pub(super) fn rates(&self) -> GivenRates {
        let imu_hz = 1e6 / self.sample_us;
        GivenRates { loop_hz: (imu_hz / f64::from(self.per_step)) as f32, imu_hz: imu_hz as f32 }
    }
}

/// The clock.
#[derive(Clone, Debug, Default)]
pub(super) struct SensorClock {
    pace: Option<Pace>,
    last_us: Option<u64>,
    intervals_us: VecDeque<u64>,
    /// Intervals since it began to look for a rate.
    looked_at: u32,
    /// Was it said that there is none?
    said: bool,
}

impl SensorClock {
    /// The pace, once it is found.
    pub(super) fn pace(&self) -> Option<Pace> {
        self.pace
    }

    /// Takes the time of a sample, µs.
    pub(super) fn take(&mut self, time_us: u64) -> Beat {
        let Some(last_us) = self.last_us.replace(time_us) else { return Beat::Unknown };
        let interval_us = time_us.wrapping_sub(last_us) as i64;
        match self.pace {
            _ if interval_us == 0 => Beat::Again,
            _ if !(0..=GAP_MAX_US).contains(&interval_us) => {
                *self = Self { last_us: Some(time_us), ..Self::default() };
                Beat::Jump(interval_us)
            }
            None => self.learn(interval_us.unsigned_abs()),
            Some(pace) => {
                let whole = (interval_us as f64 / pace.sample_us).round().max(1.0);
                Beat::Next { missing: whole as u32 - 1 }
            }
        }
    }

    fn learn(&mut self, interval_us: u64) -> Beat {
        self.looked_at = self.looked_at.saturating_add(1);
        self.intervals_us.push_back(interval_us);
        if self.intervals_us.len() > LEARNT {
            self.intervals_us.pop_front();
        }
        if self.intervals_us.len() < LEARNT {
            return Beat::Unknown;
        }
        let mean_us = self.intervals_us.iter().sum::<u64>() as f64 / LEARNT as f64;
        let regular = |interval: &u64| (*interval as f64 - mean_us).abs() <= JITTER * mean_us;
        let is_regular = self.intervals_us.iter().all(regular);
        self.pace = if is_regular { Pace::new(mean_us) } else { None };
        if let Some(pace) = self.pace {
            return Beat::Found(pace);
        }
        if self.said || !is_regular && self.looked_at < IRREGULAR_AFTER {
            return Beat::Unknown;
        }
        self.said = true;
        let [shortest, longest] = [self.intervals_us.iter().min(), self.intervals_us.iter().max()]
            .map(|interval| interval.copied().unwrap_or_default());
        if is_regular { Beat::Unusable(mean_us) } else { Beat::Irregular(shortest, longest) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paced(times_us: impl IntoIterator<Item = u64>) -> (SensorClock, Vec<Beat>) {
        let mut clock = SensorClock::default();
        let beats = times_us.into_iter().map(|time_us| clock.take(time_us)).collect();
        (clock, beats)
    }

    /// What simulators send: 250 Hz (Gazebo, jMAVSim), 400 Hz, the same in whole milliseconds since 1970, 1000 Hz.
    #[test]
    fn the_rate_is_that_of_the_times() {
        let since_1970_us = 1_700_000_000_000_000;
        for (sample_us, start_us, cut_us, per_step) in
            [(4000, 0, 1, 1), (2500, 77, 1, 1), (2500, since_1970_us, 1000, 1), (1000, 0, 1, 3), (10_000, 0, 1, 1)]
        {
            let times = (0..=LEARNT as u64).map(|index| (start_us + index * sample_us) / cut_us * cut_us);
            let (clock, beats) = paced(times);
            let pace = Pace { sample_us: sample_us as f64, per_step };
            assert_eq!((beats.last(), clock.pace()), (Some(&Beat::Found(pace)), Some(pace)));
            assert!(beats[..LEARNT].iter().all(|beat| *beat == Beat::Unknown));
        }
        let rates = |sample_us| Pace::new(sample_us).map(|pace| (pace.rates().loop_hz, pace.rates().imu_hz));
        assert_eq!(rates(4000.0), Some((250.0, 250.0)));
        assert_eq!(rates(1250.0), Some((400.0, 800.0)));
        assert_eq!((rates(11_000.0), rates(100.0)), (None, None));
    }

    #[test]
    fn what_comes_too_seldom_or_at_no_rate_is_said_once() {
        let (_, beats) = paced((0..1000).map(|index| index * 20_000));
        let said: Vec<&Beat> = beats.iter().filter(|beat| **beat != Beat::Unknown).collect();
        assert_eq!(said, [&Beat::Unusable(20_000.0)]);
        let (_, beats) = paced((0..1000).map(|index| index / 2 * 8000 + index % 2 * 1000));
        let said: Vec<&Beat> = beats.iter().filter(|beat| **beat != Beat::Unknown).collect();
        assert_eq!(said, [&Beat::Irregular(1000, 7000)]);
    }

    /// A start that is out of step delays the rate, no more.
    #[test]
    fn the_first_times_may_be_others() {
        let (clock, _) = paced([0, 1, 30_000].into_iter().chain((0..20).map(|index| 31_000 + index * 4000)));
        assert_eq!(clock.pace(), Some(Pace { sample_us: 4000.0, per_step: 1 }));
    }

    #[test]
    fn gaps_and_jumps_are_told_apart() {
        let (mut clock, _) = paced((0..=LEARNT as u64).map(|index| index * 2500));
        let end_us = LEARNT as u64 * 2500;
        assert_eq!(clock.take(end_us), Beat::Again);
        // whole milliseconds
        assert_eq!(clock.take(end_us + 2000), Beat::Next { missing: 0 });
        assert_eq!(clock.take(end_us + 5000), Beat::Next { missing: 0 });
        assert_eq!(clock.take(end_us + 15_000), Beat::Next { missing: 3 });
        assert_eq!(clock.take(end_us + 14_000), Beat::Jump(-1000));
        assert_eq!(clock.pace(), None);
        assert_eq!(clock.take(end_us + 2_000_000), Beat::Jump(1_986_000));
    }
}
