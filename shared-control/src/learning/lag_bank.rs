//! What one axis does in answer to its motors, for a bank of lags at once.
//!
//! With the motors' lag T and the axis' gain k (its acceleration per torque over that of the model) the rate moves in a
//! step by k times what the model's body would under the torque that motors of that lag make ([`super::motors`]), and
//! by what nobody knows. Both sides pass the same filter,
//!
//! ```text
//!   F = (1 - 1/z) / (1 - p/z)^2        y = F (w - w/z)        x(T) = F (rotation by that torque)        y = k x(T) + e
//! ```
//! whose 1 - 1/z takes off what stays (a bias of the gyro has gone with the difference, a constant torque goes here),
//! and which makes white what the observer of bandwidth p is for: a torque that walks at random under white noise of
//! the gyro. A gust is such a torque. The controller answers to it, but only afterwards: where e is white up to beyond
//! what the loop answers to, e now has nothing of what x answers to, and least squares is right in closed loop without
//! an instrument (Ljung, System Identification, section 13.4). With a pole as slow as the loop it is not: e remembers
//! the gust that x answers to, and the gain comes out too small.
//!
//! For any lag between two of the bank a mean of both neighbours' x is taken, so that sums of squares and of products
//! of neighbours are all that has to be kept.

use crate::elementary::exp;

/// Lags of the bank, s.
pub const LAGS_S: [f32; LAGS] = [0.003, 0.006, 0.01, 0.015, 0.021, 0.029, 0.039, 0.051, 0.066, 0.084, 0.106, 0.13];
/// The longest.
pub const LAG_MAX_S: f32 = LAGS_S[LAGS - 1];
/// How many.
pub const LAGS: usize = 12;

/// Filters and sums of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisSums {
    rate_before_rad_s: f32,
    measured: Filter,
    turned: [Filter; LAGS],
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
    /// Change that motors of each lag would have given the model's body, rad/s.
    pub turned_rad_s: [f32; LAGS],
}

/// F of the head of this file.
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

/// Pole of F for a bandwidth.
pub fn pole(bandwidth_rad_s: f32, step_s: f32) -> f32 {
    exp(-bandwidth_rad_s * step_s)
}

impl AxisSums {
    /// One step on. Where it counts it comes into the sums with a weight of one, and those before keep `kept` of
    /// theirs. Gives y, and x of each lag.
    pub fn update(&mut self, pole: f32, motion: &Motion, kept: Option<f32>) -> (f32, [f32; LAGS]) {
        let moved_rad_s = motion.rate_rad_s - self.rate_before_rad_s;
        self.rate_before_rad_s = motion.rate_rad_s;
        if !moved_rad_s.is_finite() {
            (self.measured, self.turned) = Default::default();
            return (0.0, [0.0; LAGS]);
        }
        let y = self.measured.pass(pole, moved_rad_s - motion.known_rad_s);
        let mut x = motion.turned_rad_s;
        for (x, filter) in x.iter_mut().zip(&mut self.turned) {
            *x = filter.pass(pole, *x);
        }
        if let Some(kept) = kept {
            self.add(&x, y, kept);
        }
        (y, x)
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
}
