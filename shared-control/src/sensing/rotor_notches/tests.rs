//! Lines, turns and noise through the notches: what is stopped, what passes and how late.

extern crate std;
use core::f64::consts::TAU;
use std::vec::Vec;

use super::*;

const RATES_HZ: [f32; 2] = [760.0, 1000.0];
/// Amplitude of a line, rad/s: 30 m/s^2 at the end of an F450's arm, one rotor of four.
const LINE_RAD_S: f64 = 0.045;

struct Run {
    config: NotchesConfig,
    state: NotchesState,
    rate_hz: f64,
    sample: u32,
}

impl Run {
    fn new(rate_hz: f32) -> Self {
        let (config, state) = (NotchesConfig::new(rate_hz), NotchesState::default());
        Self { config, state, rate_hz: f64::from(rate_hz), sample: 0 }
    }

    /// So many seconds of a rate about roll, rad/s over seconds, which pitch and yaw share in part; roll as it went in
    /// and came out.
    fn fly(&mut self, duration_s: f64, turns: bool, rate_rad_s: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let samples = (duration_s * self.rate_hz) as u32;
        let mut seen = Vec::new();
        let mut notches = Notches::tune(&self.config, &mut self.state, turns);
        for _ in 0..samples {
            // two or three samples a step
            if self.sample.is_multiple_of(5) || self.sample % 5 == 2 {
                notches = Notches::tune(&self.config, &mut self.state, turns);
            }
            let time_s = f64::from(self.sample) / self.rate_hz;
            self.sample += 1;
            let x = rate_rad_s(time_s);
            let input = Vector3::new(x as f32, -0.5 * x as f32, 0.2 * x as f32);
            let out = notches.update(&mut self.state, &input);
            assert!(out.iter().all(|y| y.is_finite()));
            seen.push((time_s, f64::from(out.x)));
        }
        seen
    }
}

/// Amplitude and phase of a frequency in a series, over whole periods or long enough.
fn line(series: &[(f64, f64)], frequency_hz: f64) -> (f64, f64) {
    let (mut re, mut im) = (0.0f64, 0.0f64);
    for (time_s, y) in series {
        let (sin, cos) = (TAU * frequency_hz * time_s).sin_cos();
        (re, im) = (re + y * cos, im + y * sin);
    }
    let scale = 2.0 / series.len() as f64;
    (scale * re.hypot(im), re.atan2(im))
}

/// A rotor's lines: the first, and its harmonics as the vehicle's model has them in the rate.
fn rotor(time_s: f64, frequency_hz: f64, phase: f64) -> f64 {
    let angle: f64 = TAU * frequency_hz * time_s + phase;
    LINE_RAD_S * (angle.sin() + 0.15 * (2.0 * angle).sin() + 0.033 * (3.0 * angle).sin())
}

fn white(sample: f64) -> f64 {
    // a fixed hash of the sample's number, uniform within +-1
    let mut word = (sample * 1e6) as u64 ^ 0x9e37_79b9_7f4a_7c15;
    word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (word >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(48))]

    /// Four rotors whose lifts scatter by 3 % (speeds by 1.5 %, here to +-4 %): within 0.3 s of the first sample each
    /// line and the harmonic are down by 20 dB, in the MPU6000's noise and under a slow turn.
    #[test]
    fn lines_of_four_rotors_are_down_by_20_db(
        rate in 0usize..2, mean_hz in 80.0f64..200.0, scatter in proptest::array::uniform4(-0.04f64..0.04),
    ) {
        let at_hz = scatter.map(|part| (mean_hz * (1.0 + part)).clamp(80.0, 200.0));
        let mut run = Run::new(RATES_HZ[rate]);
        let rates = |time_s: f64| {
            let rotors: f64 = at_hz.iter().zip([0.0, 1.3, 2.9, 4.4]).map(|(hz, phase)| rotor(time_s, *hz, phase)).sum();
            rotors + 0.5 * (TAU * time_s).sin() + 0.004 * white(time_s)
        };
        run.fly(0.3, true, rates);
        let out = run.fly(4.0, true, rates);
        let input: Vec<_> = out.iter().map(|(time_s, _)| (*time_s, rates(*time_s))).collect();
        for hz in at_hz {
            let (before, after) = (line(&input, hz).0, line(&out, hz).0);
            // two rotors at one speed may cancel each other: a line that is none is not asked to be less
            proptest::prop_assert!(after < 0.1 * before + 0.02 * LINE_RAD_S, "{hz} Hz of {at_hz:?}: {before} {after}");
        }
    }

    /// Turns of up to 20 Hz are late by at most 3 ms (phase delay), and neither larger nor smaller by a tenth.
    #[test]
    fn turns_are_late_by_at_most_3_ms(rate in 0usize..2, rotor_hz in 80.0f64..200.0, turn_hz in 1.0f64..20.0) {
        let mut run = Run::new(RATES_HZ[rate]);
        let rates = |time_s: f64| rotor(time_s, rotor_hz, 0.0) + 0.2 * (TAU * turn_hz * time_s).sin();
        run.fly(0.5, true, |time_s| rotor(time_s, rotor_hz, 0.0));
        run.fly(1.0, true, rates);
        let out = run.fly(6.0, true, rates);
        let input: Vec<_> = out.iter().map(|(time_s, _)| (*time_s, rates(*time_s))).collect();
        let ((before, phase), (after, late)) = (line(&input, turn_hz), line(&out, turn_hz));
        let delay_ms = 1e3 * ((phase - late).rem_euclid(TAU)) / (TAU * turn_hz);
        proptest::prop_assert!(run.state.share > 0.99, "{}", run.state.share);
        proptest::prop_assert!((0.5..=3.0).contains(&delay_ms), "{delay_ms}");
        proptest::prop_assert!((after / before - 1.0).abs() < 0.1, "{}", after / before);
    }

    /// A manoeuvre without rotors in the gyro is no rotor: the notches stay out and it passes as it is.
    #[test]
    fn a_manoeuvre_is_no_rotor(rate in 0usize..2, size_rad_s in 0.1f64..3.0) {
        let mut run = Run::new(RATES_HZ[rate]);
        // from 0.5 to 20 Hz in 10 s
        let chirp = |time_s: f64| size_rad_s * (TAU * (0.5 * time_s + 0.975 * time_s * time_s)).sin();
        for (time_s, y) in run.fly(10.0, true, chirp) {
            proptest::prop_assert!((y - chirp(time_s)).abs() < 1e-3 * size_rad_s, "{time_s}: {y}");
        }
    }

    /// Any counts whatever leave finite numbers within what resonances can make of the largest.
    #[test]
    fn no_input_makes_it_run_away(words in proptest::collection::vec(-35.0f64..35.0, 400)) {
        let mut run = Run::new(1000.0);
        for (_, y) in run.fly(2.0, true, |time_s| words[(time_s * 1000.0) as usize % 400]) {
            proptest::prop_assert!(y.abs() < 350.0);
        }
    }
}

/// A step of the rate, which no vehicle makes, comes out whole: at most a quarter beyond it, and there after 20 ms.
#[test]
fn a_step_of_rate_passes() {
    let mut run = Run::new(1000.0);
    let rates = |time_s: f64| rotor(time_s, 82.0, 0.0) + if time_s >= 1.0 { 2.0 } else { 0.0 };
    run.fly(1.0, true, rates);
    for (time_s, y) in run.fly(0.5, true, rates) {
        assert!(y < 2.5, "{time_s}: {y}");
        assert!(time_s < 1.02 || y > 1.6, "{time_s}: {y}");
        assert!(time_s < 1.1 || (y - 2.0).abs() < 0.06, "{time_s}: {y}");
    }
}

/// Rotors that speed up by half within half a second are not lost, and with rotors that stand all passes.
#[test]
fn the_speed_is_followed_and_left_when_the_rotors_stand() {
    let mut run = Run::new(1000.0);
    let phase = |time_s: f64| {
        let rising = (time_s - 1.0).clamp(0.0, 0.5);
        TAU * (90.0 * time_s + 45.0 * rising * rising + 45.0 * (time_s - 1.5).max(0.0))
    };
    let rates = |time_s: f64| 4.0 * LINE_RAD_S * phase(time_s).sin();
    run.fly(0.3, true, rates);
    for (time_s, y) in run.fly(1.7, true, rates) {
        assert!(y.abs() < 0.4 * LINE_RAD_S * 4.0, "{time_s}: {y}");
    }
    let (speed_hz, share) = run.state.followed(&run.config);
    assert!((speed_hz - 135.0).abs() < 2.0 && share > 0.99, "{speed_hz} {share}");
    run.fly(0.3, false, rates);
    assert_eq!(run.state.followed(&run.config).1, 0.0);
}
