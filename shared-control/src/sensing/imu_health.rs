//! Is the IMU to be believed? Judged on its raw words, step by step, before anything is computed from them.
//!
//! - Stale: no new sample for [`STALE_STEPS`] steps.
//! - Bus dead: all six words of a sample equal one another (a line stuck low or high reads 0 or -1 throughout). At
//!   rest one axis feels 1 g, so this happens by chance in free fall at most; [`RUN_SAMPLES`] in a row count.
//! - Stuck: all six words as they were, [`RUN_SAMPLES`] samples in a row. A real MPU6000 has noise of about one count
//!   (gyro) and several counts (accelerometer): two equal samples are a matter of 1 in 1000, five of 1 in 10^12. A
//!   simulation without noise, however, gives equal words for seconds, at rest as in steady hover. The two are
//!   separated by what the sensor did at rest before: one whose words went on changing for [`NOISE_SAMPLES`] samples at
//!   rest has noise, and from then on a run of equal words means that it is stuck. A sensor that never showed noise
//!   can't be judged so; a real one that is frozen from the start shows by its missing data-ready, which makes it
//!   stale.
//! - Out of range: a word at full scale in [`RUN_SAMPLES`] samples in a row; one knock does not count, nor does a yaw
//!   rate that is known to be beyond the gyro's range.
//!
//! Where gyro and accelerometer are two chips, one can stand still while the other goes on, so that each is judged by
//! its own three words. Three words repeat more often than six: a quiet L3GD20H at rest (0.011 deg/s per root Hz over
//! 100 Hz, 1.6 digits) repeats itself about once in 70 samples. [`CHIP_RUN_SAMPLES`] in a row are then a matter of 1 in
//! 10^13.
//!
//! Every run is complete within five steps: of the MPU6000 each step brings at least one sample, of the L3GD20 at 760
//! Hz five steps at 400 Hz bring nine.

use crate::record::state_words::StateWords;
use crate::sensing::imu::Chips;
use crate::signals::RawImuSample;

/// Steps without a new sample after which the IMU is stale.
pub const STALE_STEPS: u8 = 4;
/// Samples in a row that make a finding.
pub const RUN_SAMPLES: u8 = 5;
/// Samples in a row in which one of two chips stands still that make a finding.
pub const CHIP_RUN_SAMPLES: u8 = 8;
/// Samples at rest without a run of equal ones that prove that the sensor has noise.
pub const NOISE_SAMPLES: u16 = 256;

/// What is wrong with the IMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImuFault {
    /// Samples stay away, or there never was one.
    Stale,
    /// Every word of a sample is the same.
    BusDead,
    /// The words don't change any more.
    Stuck,
    /// At full scale.
    OutOfRange,
}

impl ImuFault {
    /// All of them, in the order of their numbers.
    #[cfg(test)]
    pub(crate) const ALL: [ImuFault; 4] = [ImuFault::Stale, ImuFault::BusDead, ImuFault::Stuck, ImuFault::OutOfRange];

    /// Its number in the words of a state.
    pub fn number(&self) -> u32 {
        match self {
            ImuFault::Stale => 0,
            ImuFault::BusDead => 1,
            ImuFault::Stuck => 2,
            ImuFault::OutOfRange => 3,
        }
    }
}

/// The IMU's health.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImuHealth {
    /// To be believed.
    Good,
    /// Not to be believed.
    Bad(ImuFault),
}

impl ImuHealth {
    /// Its number in a trace.
    pub fn number(&self) -> u32 {
        match self {
            ImuHealth::Good => 0,
            ImuHealth::Bad(fault) => 1 + fault.number(),
        }
    }
}

/// What the judgement rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImuHealthState {
    last: Option<RawImuSample>,
    steps_without_sample: u8,
    dead_run: u8,
    /// Samples in a row whose gyro words were those of the sample before, and the same of the accelerometer's.
    equal_runs: [u8; 2],
    full_scale_run: u8,
    /// Samples at rest since the last run of equal ones; frozen once [`NOISE_SAMPLES`] are reached.
    changing_at_rest: u16,
}

impl ImuHealthState {
    /// Takes the samples of one step. `at_rest`: motors off and the gyro quiet. `beyond`: the gyro word (0 to 2) that
    /// may be at full scale.
    pub fn update(
        &mut self,
        chips: Chips,
        samples: &[RawImuSample],
        at_rest: bool,
        beyond: Option<usize>,
    ) -> ImuHealth {
        let mut fresh = false;
        for sample in samples {
            fresh |= self.take(chips, sample, at_rest, beyond);
        }
        self.steps_without_sample = if fresh { 0 } else { self.steps_without_sample.saturating_add(1) };
        self.judge(chips)
    }

    /// Might it turn out that what came last was not to be believed?
    pub fn is_suspect(&self, chips: Chips) -> bool {
        let repeats = self.has_noise() && self.equal_run(chips) > 0;
        self.steps_without_sample > 0 || self.dead_run > 0 || self.full_scale_run > 0 || repeats
    }

    /// Has the sensor shown noise, so that standing still would be noticed?
    pub fn has_noise(&self) -> bool {
        self.changing_at_rest >= NOISE_SAMPLES
    }

    pub(crate) fn record(&self, out: &mut StateWords) {
        let Self { last, steps_without_sample, dead_run, equal_runs, full_scale_run, changing_at_rest } = self;
        let [gyro_run, accel_run] = equal_runs;
        out.optional_time_us(last.map(|sample| sample.time_us));
        for word in last.map_or([0; 6], |sample| words(&sample)) {
            out.word(i32::from(word) as u32);
        }
        for count in [steps_without_sample, dead_run, gyro_run, accel_run, full_scale_run] {
            out.word(u32::from(*count));
        }
        out.word(u32::from(*changing_at_rest));
    }

    /// True if the sample is a new one.
    fn take(&mut self, chips: Chips, sample: &RawImuSample, at_rest: bool, beyond: Option<usize>) -> bool {
        let (gyro_repeats, accel_repeats) = match self.last {
            Some(last) if sample.time_us <= last.time_us => return false,
            Some(last) => (last.gyro_counts == sample.gyro_counts, last.accel_counts == sample.accel_counts),
            None => (false, false),
        };
        let [first, ..] = words(sample);
        let [gyro, accel] = self.equal_runs;
        self.equal_runs = [run(gyro, gyro_repeats), run(accel, accel_repeats)];
        self.dead_run = run(self.dead_run, words(sample).iter().all(|word| *word == first));
        let mut judged = words(sample).into_iter().enumerate().filter(|(place, _)| beyond != Some(*place));
        self.full_scale_run = run(self.full_scale_run, judged.any(|(_, word)| is_full_scale(word)));
        if !self.has_noise() {
            let changing = at_rest && !self.stands_still(chips);
            self.changing_at_rest = if changing { self.changing_at_rest + 1 } else { 0 };
        }
        self.last = Some(*sample);
        true
    }

    /// Samples in a row in which all words, or those of either chip, were as before.
    fn equal_run(&self, chips: Chips) -> u8 {
        let [gyro, accel] = self.equal_runs;
        match chips {
            Chips::One => gyro.min(accel),
            Chips::Two => gyro.max(accel),
        }
    }

    fn stands_still(&self, chips: Chips) -> bool {
        let run_samples = match chips {
            Chips::One => RUN_SAMPLES,
            Chips::Two => CHIP_RUN_SAMPLES,
        };
        self.equal_run(chips) + 1 >= run_samples
    }

    fn judge(&self, chips: Chips) -> ImuHealth {
        if self.last.is_none() || self.steps_without_sample >= STALE_STEPS {
            ImuHealth::Bad(ImuFault::Stale)
        } else if self.dead_run >= RUN_SAMPLES {
            ImuHealth::Bad(ImuFault::BusDead)
        } else if self.full_scale_run >= RUN_SAMPLES {
            ImuHealth::Bad(ImuFault::OutOfRange)
        } else if self.has_noise() && self.stands_still(chips) {
            ImuHealth::Bad(ImuFault::Stuck)
        } else {
            ImuHealth::Good
        }
    }
}

fn run(length: u8, goes_on: bool) -> u8 {
    // far below where adding one could overflow
    if goes_on { length.saturating_add(1).min(100) } else { 0 }
}

fn words(sample: &RawImuSample) -> [i16; 6] {
    let ([gx, gy, gz], [ax, ay, az]) = (sample.gyro_counts, sample.accel_counts);
    [gx, gy, gz, ax, ay, az]
}

/// At either end of 16 bits; -32767 is what some chips have for -32768.
pub(super) fn is_full_scale(word: i16) -> bool {
    word == i16::MAX || word <= -i16::MAX
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time and words that a noisy sensor at rest could send.
    fn noisy(k: u64) -> RawImuSample {
        let n = (k * 7919 % 11) as i16;
        RawImuSample {
            time_us: (k + 1) * 1000,
            gyro_counts: [n - 5, 3 - n, n % 3],
            accel_counts: [n, -n, -4096 + 2 * n],
        }
    }

    fn still(k: u64) -> RawImuSample {
        RawImuSample { time_us: (k + 1) * 1000, gyro_counts: [0; 3], accel_counts: [0, 0, -4096] }
    }

    /// Noise seen for 300 steps at rest, one sample each.
    fn rested() -> ImuHealthState {
        let mut state = ImuHealthState::default();
        for k in 0..300 {
            assert_eq!(state.update(Chips::One, &[noisy(k)], true, None), ImuHealth::Good);
        }
        assert!(state.has_noise());
        state
    }

    /// Steps until a fault is reported, with the fault, when each step from 300 on brings `samples`.
    fn detected(state: &mut ImuHealthState, sample: impl Fn(u64) -> Option<RawImuSample>) -> (u64, ImuFault) {
        for k in 300..400 {
            if let ImuHealth::Bad(fault) = state.update(Chips::One, sample(k).as_slice(), false, None) {
                return (k - 299, fault);
            }
        }
        panic!("never detected");
    }

    #[test]
    fn each_fault_is_found_within_five_steps() {
        assert_eq!(detected(&mut rested(), |_| None), (4, ImuFault::Stale));
        let frozen = noisy(299);
        let repeat = |k| Some(RawImuSample { time_us: (k + 1) * 1000, ..frozen });
        assert_eq!(detected(&mut rested(), repeat), (4, ImuFault::Stuck));
        let dead = |k| Some(RawImuSample { time_us: (k + 1) * 1000, gyro_counts: [-1; 3], accel_counts: [-1; 3] });
        assert_eq!(detected(&mut rested(), dead), (5, ImuFault::BusDead));
        let saturated = |k| Some(RawImuSample { gyro_counts: [0, i16::MIN, k as i16], ..noisy(k) });
        assert_eq!(detected(&mut rested(), saturated), (5, ImuFault::OutOfRange));
    }

    #[test]
    fn the_same_sample_again_is_no_news() {
        let same = noisy(299);
        assert_eq!(detected(&mut rested(), |_| Some(same)), (4, ImuFault::Stale));
    }

    #[test]
    fn a_simulation_without_noise_is_never_stuck() {
        let mut state = ImuHealthState::default();
        for k in 0..100_000u64 {
            // at rest, then steady hover, a manoeuvre, steady hover
            let moving = (60_000..61_000).contains(&k);
            let sample = if moving { noisy(k) } else { still(k) };
            assert_eq!(state.update(Chips::One, &[sample], k < 20_000, None), ImuHealth::Good, "sample {k}");
        }
    }

    #[test]
    fn noise_is_learnt_at_rest_only() {
        let mut state = ImuHealthState::default();
        for k in 0..10_000 {
            state.update(Chips::One, &[noisy(k)], false, None);
        }
        assert!(!state.has_noise());
    }

    #[test]
    fn one_knock_is_no_fault_and_a_fault_ends_with_its_cause() {
        let mut state = rested();
        let knock = RawImuSample { accel_counts: [i16::MAX, 0, 0], ..noisy(300) };
        assert_eq!(state.update(Chips::One, &[knock], false, None), ImuHealth::Good);
        for _ in 0..10 {
            state.update(Chips::One, &[], false, None);
        }
        assert_eq!(state.update(Chips::One, &[], false, None), ImuHealth::Bad(ImuFault::Stale));
        assert_eq!(state.update(Chips::One, &[noisy(320)], false, None), ImuHealth::Good);
    }

    /// What might turn into a finding makes it suspect at once, and ends with its cause.
    #[test]
    fn the_first_sign_of_a_fault_makes_it_suspect() {
        let quiet = rested();
        assert!(!quiet.is_suspect(Chips::One));
        let next = |samples: &[RawImuSample]| {
            let mut state = quiet;
            state.update(Chips::One, samples, false, None);
            let suspect = state.is_suspect(Chips::One);
            state.update(Chips::One, &[noisy(305)], false, None);
            assert!(!state.is_suspect(Chips::One));
            suspect
        };
        let noise = noisy(300);
        assert!(!next(&[noise]));
        assert!(next(&[]), "no sample");
        assert!(next(&[RawImuSample { gyro_counts: [7; 3], accel_counts: [7; 3], ..noise }]), "a dead bus");
        assert!(next(&[RawImuSample { accel_counts: [i16::MAX, 0, 1], ..noise }]), "full scale");
        assert!(next(&[RawImuSample { time_us: noise.time_us, ..noisy(299) }]), "the same again");
        // without noise repeating is no sign
        let mut still_state = ImuHealthState::default();
        for k in 0..3 {
            still_state.update(Chips::One, &[still(k)], true, None);
        }
        assert!(!still_state.is_suspect(Chips::One));
    }

    /// Full scale is either end of 16 bits, and -32767, which some chips have for -32768.
    #[test]
    fn full_scale_is_either_end() {
        for (word, full) in [(i16::MAX, true), (i16::MIN, true), (-i16::MAX, true), (32_766, false), (-32_766, false)] {
            let mut state = rested();
            let found = (300..305).map(|k| {
                let sample = RawImuSample { gyro_counts: [word, k as i16, 3], ..noisy(k) };
                state.update(Chips::One, &[sample], false, None)
            });
            let expected = if full { ImuHealth::Bad(ImuFault::OutOfRange) } else { ImuHealth::Good };
            assert_eq!(found.last(), Some(expected), "{word}");
        }
    }

    /// A yaw rate that is known to be beyond the range is no fault of the gyro; any other word at full scale is.
    #[test]
    fn a_rate_that_is_known_to_be_beyond_the_range_is_no_fault() {
        let judged = |gyro_counts: [i16; 3], beyond: Option<usize>| {
            let mut state = rested();
            let healths = (300..310).map(|k| {
                let sample = RawImuSample { gyro_counts, ..noisy(k) };
                let health = state.update(Chips::One, &[sample], false, beyond);
                (health, state.is_suspect(Chips::One))
            });
            healths.last()
        };
        assert_eq!(judged([3, 2, i16::MIN], Some(2)), Some((ImuHealth::Good, false)));
        for (words, beyond) in [([3, 2, i16::MIN], None), ([3, i16::MAX, 2], Some(2))] {
            assert_eq!(judged(words, beyond), Some((ImuHealth::Bad(ImuFault::OutOfRange), true)));
        }
    }

    /// Noise is proven by so many samples at rest in a row, not one less; standing still begins the count anew.
    #[test]
    fn noise_takes_its_samples_in_a_row() {
        let mut state = ImuHealthState::default();
        for k in 0..u64::from(NOISE_SAMPLES) {
            assert!(!state.has_noise(), "sample {k}");
            state.update(Chips::One, &[noisy(k)], true, None);
        }
        assert!(state.has_noise());
        let mut state = ImuHealthState::default();
        for k in 0..1000 {
            // of 100 samples the last five repeat the one before: a run of five
            let sample = if k % 100 < 95 {
                noisy(k)
            } else {
                RawImuSample { time_us: (k + 1) * 1000, ..noisy(k / 100 * 100 + 94) }
            };
            state.update(Chips::One, &[sample], true, None);
        }
        assert!(!state.has_noise());
    }

    #[test]
    fn before_the_first_sample_there_is_no_health() {
        assert_eq!(ImuHealthState::default().update(Chips::One, &[], true, None), ImuHealth::Bad(ImuFault::Stale));
    }

    /// Of two chips each may stand still by itself; what the other still says must not hide it.
    #[test]
    fn either_of_two_chips_is_found_stuck() {
        let mut state = ImuHealthState::default();
        for k in 0..300 {
            assert_eq!(state.update(Chips::Two, &[noisy(k)], true, None), ImuHealth::Good);
        }
        for stuck_gyro in [true, false] {
            let (mut state, frozen) = (state, noisy(299));
            for k in 300..308 {
                let RawImuSample { gyro_counts, accel_counts, .. } = frozen;
                let live = noisy(k);
                let sample = if stuck_gyro {
                    RawImuSample { gyro_counts, ..live }
                } else {
                    RawImuSample { accel_counts, ..live }
                };
                let health = state.update(Chips::Two, &[sample], false, None);
                let found = usize::from(CHIP_RUN_SAMPLES) <= (k - 300 + 2) as usize;
                assert_eq!(health == ImuHealth::Bad(ImuFault::Stuck), found, "sample {k}");
                assert!(state.is_suspect(Chips::Two) && !state.is_suspect(Chips::One));
            }
        }
    }
}
