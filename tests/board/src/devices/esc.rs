//! An ESC for a sensorless brushless motor, by what its makers' manuals promise: it arms at low throttle, has a dead
//! band above it, stops when pulses fail, needs time to start a motor that stands, and takes a high throttle at
//! power-up for the wish to be calibrated.
//!
//! Manuals: BLHeli rev. 14 ("Arming sequence", "Throttle calibration"), SimonK's tgy.asm notes, Afro ESC 30 A. Makers
//! differ: [`Traits::EAGER`] and [`Traits::CAREFUL`] are the two ends of the range, and tests take both; their figures
//! are from memory. Widths here are those of PWM; for OneShot125 they are an eighth.

use crate::time::{TICKS_PER_US, Ticks};

const MILLISECOND: Ticks = 1000 * TICKS_PER_US;
/// Throttle that starts calibration if it is there when power comes.
const CALIBRATION_US: f64 = 1900.0;
const CALIBRATION_AFTER: Ticks = 2000 * MILLISECOND;

/// What differs between ESCs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traits {
    /// Pulses outside of this range are noise, us.
    pub valid_us: [f64; 2],
    /// It arms after pulses below the dead band's end for this long.
    pub arms_after: Ticks,
    /// Below this the motor stands, us.
    pub dead_band_end_us: f64,
    /// Without a valid pulse for this long it stops and wants to be armed again.
    pub times_out_after: Ticks,
    /// From a standing motor to one that turns.
    pub starts_in: Ticks,
}

impl Traits {
    /// Takes nearly everything for a command.
    pub const EAGER: Self = Self {
        valid_us: [500.0, 3500.0],
        arms_after: 100 * MILLISECOND,
        dead_band_end_us: 1010.0,
        times_out_after: 2000 * MILLISECOND,
        starts_in: 50 * MILLISECOND,
    };
    /// Takes little.
    pub const CAREFUL: Self = Self {
        valid_us: [800.0, 2300.0],
        arms_after: 1000 * MILLISECOND,
        dead_band_end_us: 1100.0,
        times_out_after: 250 * MILLISECOND,
        starts_in: 300 * MILLISECOND,
    };
}

/// What it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// It waits for low throttle.
    Disarmed,
    /// The motor stands.
    Standing,
    /// The motor is being started.
    Starting,
    /// The motor turns.
    Turning,
    /// It learns the throttle's ends: what comes now decides what full throttle is.
    Calibrating,
}

/// The ESC with its motor.
#[derive(Clone, Debug)]
pub struct Esc {
    traits: Traits,
    mode: Mode,
    /// Power came then.
    powered_at: Ticks,
    /// Low, or high, throttle since then without a break.
    low_since: Option<Ticks>,
    high_since: Option<Ticks>,
    last_valid: Ticks,
    starts_at: Ticks,
    width_us: f64,
    stalls: u32,
}

impl Esc {
    /// Power comes.
    pub fn new(traits: Traits, now: Ticks) -> Self {
        Self {
            traits,
            mode: Mode::Disarmed,
            powered_at: now,
            low_since: None,
            high_since: None,
            last_valid: now,
            starts_at: now,
            width_us: 0.0,
            stalls: 0,
        }
    }

    /// A pulse ended, of the width that PWM would have.
    pub fn pulse(&mut self, end: Ticks, width: Ticks) {
        self.time_out(end);
        let width_us = width as f64 / TICKS_PER_US as f64;
        let [shortest, longest] = self.traits.valid_us;
        if !(shortest..=longest).contains(&width_us) {
            return;
        }
        (self.last_valid, self.width_us) = (end, width_us);
        let is_low = width_us < self.traits.dead_band_end_us;
        self.low_since = is_low.then(|| self.low_since.unwrap_or(end));
        self.high_since = (width_us > CALIBRATION_US).then(|| self.high_since.unwrap_or(end));
        self.mode = self.next_mode(end, is_low);
    }

    fn next_mode(&mut self, now: Ticks, is_low: bool) -> Mode {
        let lasts = |since: Option<Ticks>, time| since.is_some_and(|since| now - since >= time);
        match (self.mode, is_low) {
            (Mode::Disarmed, true) if lasts(self.low_since, self.traits.arms_after) => Mode::Standing,
            // only what was high from the first pulse on
            (Mode::Disarmed, false)
                if lasts(self.high_since, CALIBRATION_AFTER)
                    && self.high_since.is_some_and(|since| since - self.powered_at < CALIBRATION_AFTER) =>
            {
                Mode::Calibrating
            }
            (Mode::Standing, false) => {
                self.starts_at = now + self.traits.starts_in;
                Mode::Starting
            }
            (Mode::Starting, false) if now >= self.starts_at => Mode::Turning,
            (Mode::Turning, true) => {
                self.stalls += 1;
                Mode::Standing
            }
            (Mode::Starting, true) => Mode::Standing,
            (mode, _) => mode,
        }
    }

    fn time_out(&mut self, now: Ticks) {
        let gone = now.saturating_sub(self.last_valid) > self.traits.times_out_after;
        if gone && !matches!(self.mode, Mode::Disarmed | Mode::Calibrating) {
            self.mode = Mode::Disarmed;
            self.low_since = None;
        }
    }

    /// What it does now.
    pub fn mode(&mut self, now: Ticks) -> Mode {
        self.time_out(now);
        self.mode
    }

    /// Does the motor turn?
    pub fn turns(&mut self, now: Ticks) -> bool {
        self.mode(now) == Mode::Turning
    }

    /// What the motor turns with, 0 to 1 of the range from 1 to 2 ms.
    pub fn command(&mut self, now: Ticks) -> f64 {
        if self.mode(now) == Mode::Turning { (self.width_us / 1000.0 - 1.0).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// How often a motor that turned was told to stop.
    pub fn stops(&self) -> u32 {
        self.stalls
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pulses at 400 Hz for a while; the time after them.
    fn feed(esc: &mut Esc, from: Ticks, ms: u64, width_us: u64) -> Ticks {
        let ends = (0..ms * 2 / 5).map(|pulse| from + (pulse + 1) * 5 * MILLISECOND / 2);
        let mut last = from;
        for end in ends {
            esc.pulse(end, width_us * TICKS_PER_US);
            last = end;
        }
        last
    }

    const BOTH: [Traits; 2] = [Traits::EAGER, Traits::CAREFUL];

    #[test]
    fn nothing_turns_before_low_throttle_was_there_long_enough() {
        for traits in BOTH {
            let mut esc = Esc::new(traits, 0);
            let now = feed(&mut esc, 0, 1500, 1500);
            assert_eq!((esc.mode(now), esc.command(now)), (Mode::Disarmed, 0.0));
            let now = feed(&mut esc, now, 1200, 1000);
            assert_eq!(esc.mode(now), Mode::Standing);
            let now = feed(&mut esc, now, 400, 1500);
            assert_eq!((esc.mode(now), esc.command(now)), (Mode::Turning, 0.5));
        }
    }

    fn turning(traits: Traits) -> (Esc, Ticks) {
        let mut esc = Esc::new(traits, 0);
        let now = feed(&mut esc, 0, 1500, 1000);
        let now = feed(&mut esc, now, 500, 1300);
        assert_eq!(esc.mode(now), Mode::Turning);
        (esc, now)
    }

    #[test]
    fn a_motor_that_was_stopped_in_flight_is_away_for_its_starting_time() {
        for traits in BOTH {
            let (mut esc, now) = turning(traits);
            let now = feed(&mut esc, now, 5, 1000);
            assert_eq!((esc.mode(now), esc.stops()), (Mode::Standing, 1));
            let start_ms = traits.starts_in / MILLISECOND;
            let now = feed(&mut esc, now, start_ms, 1500);
            assert_eq!(esc.command(now), 0.0);
            let now = feed(&mut esc, now, 10, 1500);
            assert_eq!(esc.command(now), 0.5);
        }
    }

    #[test]
    fn a_pulse_that_is_too_long_or_cut_is_noise() {
        for (traits, long_us) in [(Traits::EAGER, 3600), (Traits::CAREFUL, 2400)] {
            let (mut esc, now) = turning(traits);
            for width_us in [300, long_us, 400_000] {
                esc.pulse(now + MILLISECOND, width_us * TICKS_PER_US);
                assert!((esc.command(now) - 0.3).abs() < 1e-9, "{width_us}");
            }
        }
        // the millisecond pulse of a reset is a command to one ESC and noise to the other
        for (traits, taken) in [(Traits::EAGER, true), (Traits::CAREFUL, false)] {
            let (mut esc, now) = turning(traits);
            esc.pulse(now + 4 * MILLISECOND, 3120 * TICKS_PER_US);
            assert_eq!(esc.command(now) == 1.0, taken);
        }
    }

    #[test]
    fn without_pulses_it_stops_and_wants_to_be_armed_again() {
        for traits in BOTH {
            let (mut esc, now) = turning(traits);
            assert!(esc.command(now + traits.times_out_after) > 0.0);
            assert_eq!(esc.mode(now + traits.times_out_after + 1), Mode::Disarmed);
            let back = feed(&mut esc, now + 3000 * MILLISECOND, 90, 1300);
            assert_eq!(esc.command(back), 0.0);
        }
    }

    #[test]
    fn high_throttle_at_power_up_calibrates_and_later_does_not() {
        for traits in BOTH {
            let mut esc = Esc::new(traits, 0);
            let now = feed(&mut esc, 0, 2100, 2000);
            assert_eq!(esc.mode(now), Mode::Calibrating);
            let (mut flying, now) = turning(traits);
            let now = feed(&mut flying, now, 3000, 2000);
            assert_eq!(flying.command(now), 1.0);
        }
    }
}
