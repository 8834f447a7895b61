//! Digital filters of the control path: coefficients once, at configuration; in the loop only multiply and add.

use crate::elementary::{limit, sin_cos};
use crate::record::state_words::StateWords;

/// First-order low-pass y += a (x - y), the bilinear-free form used for derivative and target filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass1 {
    /// Share of the new sample, 0..1.
    pub share: f32,
}

impl LowPass1 {
    /// From the cut-off (-3 dB) and the sample rate, Hz: a = dt / (dt + 1 / (2 pi f)). A cut-off of zero or less
    /// means no filtering.
    pub fn new(cutoff_hz: f32, rate_hz: f32) -> Self {
        if cutoff_hz > 0.0 && rate_hz > 0.0 {
            let dt_s = 1.0 / rate_hz;
            let time_constant_s = 1.0 / (2.0 * core::f32::consts::PI * cutoff_hz);
            Self { share: dt_s / (dt_s + time_constant_s) }
        } else {
            Self { share: 1.0 }
        }
    }

    /// One sample.
    pub fn update(&self, state: &mut f32, x: f32) -> f32 {
        *state += self.share * (x - *state);
        *state
    }
}

/// Second-order Butterworth low-pass, transposed direct form II.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass2 {
    b0: f32,
    b1: f32,
    b2: f32,
    a1: f32,
    a2: f32,
}

/// State of a [`LowPass2`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LowPass2State {
    s1: f32,
    s2: f32,
}

impl LowPass2State {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { s1, s2 } = self;
        words.numbers(&[*s1, *s2]);
    }
}

impl LowPass2 {
    /// From cut-off and sample rate, Hz, by the bilinear transform with the cut-off prewarped; the cut-off is kept
    /// below 0.45 of the sample rate.
    pub fn new(cutoff_hz: f32, rate_hz: f32) -> Self {
        let ratio = limit(cutoff_hz / rate_hz, 1e-4, 0.45);
        let (s, c) = sin_cos(core::f32::consts::PI * ratio);
        let k = s / c;
        let norm = 1.0 / (1.0 + core::f32::consts::SQRT_2 * k + k * k);
        let b0 = k * k * norm;
        Self {
            b0,
            b1: 2.0 * b0,
            b2: b0,
            a1: 2.0 * (k * k - 1.0) * norm,
            a2: (1.0 - core::f32::consts::SQRT_2 * k + k * k) * norm,
        }
    }

    /// The state in which a constant input `x` comes out unchanged.
    pub fn settled(&self, x: f32) -> LowPass2State {
        let s2 = (self.b2 - self.a2) * x;
        LowPass2State { s1: (self.b1 - self.a1) * x + s2, s2 }
    }

    /// One sample.
    pub fn update(&self, state: &mut LowPass2State, x: f32) -> f32 {
        let y = self.b0 * x + state.s1;
        state.s1 = self.b1 * x - self.a1 * y + state.s2;
        state.s2 = self.b2 * x - self.a2 * y;
        y
    }
}

/// A resonance of second order that either stops its frequency and passes the rest, or the reverse; unit gain away from
/// it, or at it. Its coefficients are cheap enough to follow a frequency from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// 1 / (1 + half bandwidth): the gain of the direct path of the notch.
    direct: f32,
    /// Cosine of the angle per sample, times twice the above.
    feedback: f32,
}

impl Resonance {
    /// At `angle_rad` per sample (2 pi f / rate, within 0 and pi), with the width that a notch of this quality has: its
    /// -3 dB points are f / quality apart.
    pub fn new(angle_rad: f32, quality: f32) -> Self {
        let direct = 1.0 / (1.0 + angle_rad / (2.0 * quality));
        Self { direct, feedback: 2.0 * sin_cos(angle_rad).1 * direct }
    }

    /// One sample of the notch, (1 - 2 c z^-1 + z^-2) over its poles, after the last two that went in and came out, the
    /// newer first. A constant passes unchanged however the frequency moves.
    pub fn stop(&self, x: f32, past_in: &[f32; 2], past_out: &[f32; 2]) -> f32 {
        self.direct * (x + past_in[1]) + self.feedback * (past_out[0] - past_in[0])
            - (2.0 * self.direct - 1.0) * past_out[1]
    }

    /// One sample of the band-pass, what the notch takes away; likewise, and nothing of a constant.
    pub fn pass(&self, x: f32, past_in: &[f32; 2], past_out: &[f32; 2]) -> f32 {
        (1.0 - self.direct) * (x - past_in[1]) + self.feedback * past_out[0] - (2.0 * self.direct - 1.0) * past_out[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gain at a frequency, measured by running a sine through.
    fn gain(filter: &LowPass2, frequency_hz: f32, rate_hz: f32) -> f32 {
        let mut state = LowPass2State::default();
        let mut peak = 0.0f32;
        for i in 0..4000 {
            let turns = frequency_hz * i as f32 / rate_hz;
            let phase_rad = 2.0 * core::f32::consts::PI * (turns - turns as i32 as f32);
            let y = filter.update(&mut state, sin_cos(phase_rad).0);
            if i > 2000 {
                peak = crate::elementary::larger(peak, y.abs());
            }
        }
        peak
    }

    #[test]
    fn butterworth_passes_low_halves_power_at_cutoff_and_stops_high() {
        let f = LowPass2::new(100.0, 1000.0);
        assert!((gain(&f, 5.0, 1000.0) - 1.0).abs() < 0.01);
        assert!((gain(&f, 100.0, 1000.0) - core::f32::consts::FRAC_1_SQRT_2).abs() < 0.01);
        assert!(gain(&f, 400.0, 1000.0) < 0.03);
    }

    #[test]
    fn a_settled_filter_stays_settled() {
        let f = LowPass2::new(80.0, 1000.0);
        let mut state = f.settled(3.25);
        for _ in 0..1000 {
            assert!((f.update(&mut state, 3.25) - 3.25).abs() < 1e-4);
        }
    }

    #[test]
    fn first_order_reaches_63_percent_after_its_time_constant() {
        // time constant 1/(2 pi 1 Hz) = 0.159 s; the discrete form is late by half a sample of 1 ms
        let f = LowPass1::new(1.0, 1000.0);
        let mut y = 0.0;
        for _ in 0..159 {
            f.update(&mut y, 1.0);
        }
        assert!((y - 0.632).abs() < 0.005);
        assert_eq!(LowPass1::new(0.0, 1000.0).share, 1.0);
    }

    /// What notch and band-pass leave is the whole; the notch stops its own frequency, and a constant passes it while
    /// the frequency moves.
    #[test]
    fn notch_and_band_pass_are_each_other_s_rest() {
        let resonance = Resonance::new(2.0 * core::f32::consts::PI * 0.1, 3.0);
        let (mut past_in, mut stopped, mut passed) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        let mut left = 0.0f32;
        for i in 0..2000 {
            let turns = 0.1 * i as f32;
            let x = sin_cos(2.0 * core::f32::consts::PI * (turns - turns as i32 as f32)).0;
            let stop = resonance.stop(x, &past_in, &stopped);
            let pass = resonance.pass(x, &past_in, &passed);
            assert!((stop + pass - x).abs() < 1e-4);
            (past_in, stopped, passed) = ([x, past_in[0]], [stop, stopped[0]], [pass, passed[0]]);
            if i > 500 {
                left = crate::elementary::larger(left, stop.abs());
            }
        }
        assert!(left < 1e-3, "{left}");
        let mut past = [2.5; 2];
        for i in 0..500 {
            let y = Resonance::new(0.4 + 0.002 * i as f32, 3.0).stop(2.5, &[2.5; 2], &past);
            assert!((y - 2.5).abs() < 1e-4);
            past = [y, past[0]];
        }
    }
}
