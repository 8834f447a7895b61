//! What one axis does in answer to its motors, for a bank of lags at once.
//!
//! With the motors' lag T and the axis' gain k (its acceleration per torque over that of the model) the rate moves in a
//! step by k times what the model's body would under the delivered torque u lagged by T, and by what nobody knows. Both
//! sides pass the same filter,
//!
//! ```text
//!   F = (1 - 1/z) / (1 - p/z)^2        y = F (w - w/z)        x(T) = F (rotation by u lagged by T)        y = k x(T) + e
//! ```
//! whose 1 - 1/z takes off what stays (a bias of the gyro has gone with the difference, a constant torque goes here),
//! and which makes white what the observer of bandwidth p is for: a torque that walks at random under white noise of
//! the gyro. Lag and filter commute, so that the torque is filtered once and lagged for each T. For any lag between two
//! of the bank a mean of both neighbours' x is taken, so that sums of squares and of products of neighbours are all
//! that has to be kept.

use crate::lagged_axis::LagStep;
use crate::record::state_words::StateWords;

/// Lags of the bank, s.
pub const LAGS_S: [f32; 12] = [0.002, 0.004, 0.007, 0.011, 0.016, 0.022, 0.03, 0.04, 0.053, 0.07, 0.092, 0.12];
/// How many.
pub const LAGS: usize = LAGS_S.len();

/// The bank for a loop's step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagBank {
    steps: [LagStep; LAGS],
    pole: f32,
}

/// Filters and sums of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisSums {
    rate_before_rad_s: f32,
    measured: Filter,
    turned: Filter,
    /// Lagged part of the filtered torque, as rotation in a step, rad/s, a lag each.
    lagged_rad_s: [f32; LAGS],
    /// Weight of all samples.
    pub samples: f32,
    /// Sum of y^2, (rad/s)^2.
    pub yy: f32,
    /// Sums of x y, a lag each.
    pub xy: [f32; LAGS],
    /// Sums of x^2.
    pub xx: [f32; LAGS],
    /// Sums of x times the next lag's x; the last is unused.
    pub next: [f32; LAGS],
}

/// What an axis did in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Rate now, rad/s; no number where it was not seen.
    pub rate_rad_s: f32,
    /// Part of its change that is known from elsewhere (gravity's), rad/s.
    pub known_rad_s: f32,
    /// Change that the torque in force would have given the model's body without lag, rad/s.
    pub turned_rad_s: f32,
}

/// F of the page's head.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Filter {
    input: f32,
    once: f32,
    twice: f32,
}

impl Filter {
    fn pass(&mut self, pole: f32, input: f32) -> f32 {
        self.once = pole * self.once + (input - self.input);
        self.twice = pole * self.twice + self.once;
        self.input = input;
        self.twice
    }
}

impl LagBank {
    /// For steps of `step_s`, and a filter as fast as the bandwidth says.
    pub fn new(step_s: f32, bandwidth_rad_s: f32) -> Self {
        let pole = crate::elementary::exp(-bandwidth_rad_s * step_s);
        Self { steps: LAGS_S.map(|lag_s| LagStep::new(step_s, lag_s)), pole }
    }
}

impl AxisSums {
    /// One step on. Where it counts it comes into the sums with a weight of one, and those before keep `kept` of theirs.
    pub fn update(&mut self, bank: &LagBank, motion: &Motion, kept: Option<f32>) {
        let moved_rad_s = motion.rate_rad_s - self.rate_before_rad_s;
        self.rate_before_rad_s = motion.rate_rad_s;
        if !moved_rad_s.is_finite() {
            (self.measured, self.turned, self.lagged_rad_s) = Default::default();
            return;
        }
        let y = self.measured.pass(bank.pole, moved_rad_s - motion.known_rad_s);
        let turned = self.turned.pass(bank.pole, motion.turned_rad_s);
        let mut x = [0.0; LAGS];
        for ((x, lagged), step) in x.iter_mut().zip(&mut self.lagged_rad_s).zip(&bank.steps) {
            let lacking = *lagged - turned;
            *x = turned + step.rate_share * lacking;
            *lagged = turned + step.kept * lacking;
        }
        if let Some(kept) = kept {
            self.add(&x, y, kept);
        }
    }

    fn add(&mut self, x: &[f32; LAGS], y: f32, kept: f32) {
        self.samples = kept * self.samples + 1.0;
        self.yy = kept * self.yy + y * y;
        let mut following = x.iter().skip(1);
        let sums = self.xy.iter_mut().zip(&mut self.xx).zip(&mut self.next).zip(x);
        for (((xy, xx), next), x) in sums {
            *xy = kept * *xy + x * y;
            *xx = kept * *xx + x * x;
            *next = kept * *next + x * following.next().unwrap_or(&0.0);
        }
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { rate_before_rad_s, measured, turned, lagged_rad_s, samples, yy, xy, xx, next } = self;
        words.number(*rate_before_rad_s);
        for Filter { input, once, twice } in [measured, turned] {
            words.numbers(&[*input, *once, *twice]);
        }
        words.numbers(lagged_rad_s);
        words.numbers(&[*samples, *yy]);
        for sums in [xy, xx, next] {
            words.numbers(sums);
        }
    }
}
