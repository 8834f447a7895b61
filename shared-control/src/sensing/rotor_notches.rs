//! Notches in the gyro's rates that follow the rotors, whose speed they find in the gyro itself.
//!
//! ```text
//!   rates --two notches at 2 f--+--three notches about f--blend--> rates without the rotors' lines
//!                               '--band-pass about f--> f: least squares of x[n] + x[n-2] = 2 cos(w) x[n-1]
//! ```
//! Four rotors give four lines, some per cent apart. A notch for each would have to know which line is whose; here the
//! notches stand side by side about the mean of the lines, each weighted with its power, and stop 20 dB within 4 % of
//! it (tested; by calculation 10 %). ArduPilot's harmonic notch does the same with its double and triple notches. The
//! band-pass follows the mean too, so that neither the pilot's turns nor the harmonic draw it away. It seeks from the
//! lowest frequency up: above a rotor's speed there are harmonics to be mistaken.
//!
//! A notch of quality Q delays slow turns by 1 / (Q w): five of them by 2.3 ms in all at 80 Hz, less above.

use nalgebra::Vector3;

use crate::elementary::{atan2, larger, limit, sqrt};
use crate::filter::Resonance;
use crate::record::state_words::StateWords;

/// Rotor speeds that are followed, Hz; lines of 80 to 200 Hz with what their mean strays.
const FOLLOWED_HZ: [f32; 2] = [76.0, 210.0];
/// Notches at the rotors' mean speed: where, over it, and how sharp.
const AT_SPEED: [f32; 3] = [0.92, 1.0, 1.08];
const AT_SPEED_QUALITY: f32 = 3.6;
/// Notches at its harmonic: where, over the harmonic.
const AT_HARMONIC: [f32; 2] = [0.95, 1.05];
const AT_HARMONIC_QUALITY: f32 = 3.0;
const NOTCHES: usize = AT_SPEED.len() + AT_HARMONIC.len();
/// The band-pass is applied twice: a turn at 20 Hz leaves 3 % with the rotors at 80 Hz.
const BAND_QUALITY: f32 = 1.5;
/// Highest angle per sample of a notch, rad; a harmonic beyond is the low-pass's affair.
const ANGLE_MAX_RAD: f32 = 2.8;
/// Memory of the least squares, s.
const MEMORY_S: f32 = 0.03;
/// Root mean square of the three rates within the band from which on rotors are seen, rad/s; three times what the
/// MPU6000's noise leaves there (0.005 deg/s over a root Hz, data sheet).
const SEEN_RAD_S: f32 = 0.004;
/// By how much a step goes up while no rotor is seen: from end to end in 35 steps.
const SEEK_BY: f32 = 1.03;
/// How long the notches take to come in, s, and to go out.
const COME_IN_S: f32 = 0.05;
const GO_OUT_S: f32 = 0.2;

/// The notches at an IMU's sample rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotchesConfig {
    /// Angle per sample of the slowest and the fastest rotor that is followed, rad.
    angle_rad: [f32; 2],
    sample_rate_hz: f32,
}

impl NotchesConfig {
    /// For samples at this rate, Hz.
    pub fn new(sample_rate_hz: f32) -> Self {
        let angle_rad =
            FOLLOWED_HZ.map(|hz| limit(2.0 * core::f32::consts::PI * hz / sample_rate_hz, 0.01, ANGLE_MAX_RAD));
        Self { angle_rad, sample_rate_hz }
    }

    fn share_a_sample(&self, duration_s: f32) -> f32 {
        limit(1.0 / (duration_s * self.sample_rate_hz), 0.0, 1.0)
    }
}

/// What the notches remember.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NotchesState {
    /// Of each axis the last two samples, the newer first, rad/s: what came, and after each notch.
    past: [[[f32; 2]; NOTCHES + 1]; 3],
    /// After the band-pass, once and twice.
    past_band: [[[f32; 2]; 2]; 3],
    /// Of the least squares: (x[n] + x[n-2]) x[n-1] and x[n-1]^2, each remembered, rad^2/s^2.
    product: f32,
    power: f32,
    /// Angle per sample of the rotors' mean speed, rad; zero before the first step.
    angle_rad: f32,
    /// Share of the notches in what comes out, 0 to 1.
    share: f32,
}

impl NotchesState {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { past, past_band, product, power, angle_rad, share } = self;
        words.row(past.as_flattened().as_flattened());
        words.row(past_band.as_flattened().as_flattened());
        words.numbers(&[*product, *power, *angle_rad, *share]);
    }

    /// The rotors' mean speed, Hz, and how far the notches are in, 0 to 1.
    pub fn followed(&self, config: &NotchesConfig) -> (f32, f32) {
        (self.angle_rad * config.sample_rate_hz / (2.0 * core::f32::consts::PI), self.share)
    }

    /// Goes on from a steady rate, rad/s: after a gap the past is of no use.
    pub fn begin(&mut self, rate_rad_s: &Vector3<f32>) {
        let past = core::array::from_fn(|axis| [[rate_rad_s[axis]; 2]; NOTCHES + 1]);
        *self = Self { past, angle_rad: self.angle_rad, ..Self::default() };
    }

    /// Those for the present speed, of its harmonic first.
    fn notches(&self) -> [Resonance; NOTCHES] {
        let at = |speeds: f32, quality| Resonance::new(limit(speeds * self.angle_rad, 0.0, ANGLE_MAX_RAD), quality);
        let [low, high] = AT_HARMONIC.map(|place| at(2.0 * place, AT_HARMONIC_QUALITY));
        let [below, mean, above] = AT_SPEED.map(|place| at(place, AT_SPEED_QUALITY));
        [low, high, below, mean, above]
    }
}

/// The filters for the speed that was found last; made once a step.
pub struct Notches {
    /// Share of a sample in the least squares.
    memory: f32,
    /// By how much the notches come in with a sample.
    share_a_sample: f32,
    notches: [Resonance; NOTCHES],
    band: Resonance,
}

impl Notches {
    /// Finds the speed in what the samples up to now have left, and sets the filters to it. What is no rotor's line
    /// makes them go out where they are, then seek, from the lowest frequency up.
    pub fn tune(config: &NotchesConfig, state: &mut NotchesState, rotors_turn: bool) -> Self {
        let [slowest_rad, fastest_rad] = config.angle_rad;
        let found = found_angle_rad(state).filter(|rad| rotors_turn && (slowest_rad..=fastest_rad).contains(rad));
        state.angle_rad = match found {
            Some(found_rad) => found_rad,
            None if state.share > 0.0 => state.angle_rad,
            None if (slowest_rad..fastest_rad).contains(&state.angle_rad) => state.angle_rad * SEEK_BY,
            None => slowest_rad,
        };
        let share_a_sample = match found {
            Some(_) => config.share_a_sample(COME_IN_S),
            None => -config.share_a_sample(GO_OUT_S),
        };
        let band = Resonance::new(state.angle_rad, BAND_QUALITY);
        Self { memory: config.share_a_sample(MEMORY_S), share_a_sample, notches: state.notches(), band }
    }

    /// One sample of the rates, rad/s.
    pub fn update(&self, state: &mut NotchesState, rate_rad_s: &Vector3<f32>) -> Vector3<f32> {
        let (mut product, mut power) = (0.0, 0.0);
        let mut out = *rate_rad_s;
        for axis in 0..3 {
            let (x, past) = (rate_rad_s[axis], &mut state.past[axis]);
            let now = self.through(x, past);
            let [once, twice] = &mut state.past_band[axis];
            let banded = self.band.pass(now[AT_HARMONIC.len()], &past[AT_HARMONIC.len()], once);
            let newest = self.band.pass(banded, once, twice);
            let [newer, older] = *twice;
            product += (newest + older) * newer;
            power += newer * newer;
            (*once, *twice) = ([banded, once[0]], [newest, newer]);
            for (past, now) in past.iter_mut().zip(now) {
                *past = [now, past[0]];
            }
            out[axis] = x + state.share * (now[NOTCHES] - x);
        }
        state.product += self.memory * (product - state.product);
        state.power += self.memory * (power - state.power);
        state.share = limit(state.share + self.share_a_sample, 0.0, 1.0);
        out
    }

    /// What came, and what each notch leaves of it.
    fn through(&self, x: f32, past: &[[f32; 2]; NOTCHES + 1]) -> [f32; NOTCHES + 1] {
        let mut now = [x; NOTCHES + 1];
        for (i, notch) in self.notches.iter().enumerate() {
            now[i + 1] = notch.stop(now[i], &past[i], &past[i + 1]);
        }
        now
    }
}

/// Angle per sample of the line that the band holds, rad; none where it holds little.
fn found_angle_rad(state: &NotchesState) -> Option<f32> {
    // lines near each other beat: what was seen may fade for a while
    let least_rad_s = if state.share > 0.0 { 0.5 * SEEN_RAD_S } else { SEEN_RAD_S };
    let cosine = limit(state.product / (2.0 * state.power), -1.0, 1.0);
    let sine = sqrt(larger(0.0, 1.0 - cosine * cosine));
    (state.power > least_rad_s * least_rad_s).then(|| atan2(sine, cosine))
}

#[cfg(test)]
mod tests;
