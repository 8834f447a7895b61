//! The covariance of what the levelling does not know: prediction and comparison, in single precision.

#![allow(clippy::needless_range_loop, reason = "sums over rows and columns read best by their indices")]

use core::ops::Range;

use nalgebra::Vector3;

use crate::elementary::larger;
use crate::record::state_words::StateWords;

/// Tilt about north and east, rad; velocity north, east, down, m/s; gyro bias x, y, z, rad/s; drag, 1/s.
pub(super) const STATES: usize = 9;
pub(super) const TILT: usize = 0;
pub(super) const VELOCITY: usize = 2;
pub(super) const BIAS: usize = 5;
pub(super) const DRAG: usize = 8;

/// Expected deviations beyond which a comparison counts for less.
const BELIEVED_DEVIATIONS: f32 = 3.0;
/// Walk of the drag's coefficient, 1/s per root of s: it changes with the rotors' speed.
const DRAG_WALK_SQUARED: f32 = 1e-5;
/// No variance is beyond this: nothing is left that could be trusted.
const VARIANCE_MAX: f32 = 1e6;

/// What comes in between comparisons, per root of Hz.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noises {
    /// Of the rate, rad/s.
    pub(super) gyro: f32,
    /// Of the specific force, m/s^2.
    pub(super) force: f32,
    /// Of the bias' change, rad/s^2.
    pub(super) bias: f32,
}

type Row = [f32; STATES];

/// Symmetric; the lower triangle mirrors the upper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Covariance([Row; STATES]);

impl Covariance {
    pub(super) fn of(variances: Row) -> Self {
        let mut rows = [[0.0; STATES]; STATES];
        for i in 0..STATES {
            rows[i][i] = variances[i];
        }
        Self(rows)
    }

    pub(super) fn record(&self, words: &mut StateWords) {
        for (i, row) in self.0.iter().enumerate() {
            words.row(row.get(i..).unwrap_or_default());
        }
    }

    /// Variance of a state.
    #[cfg(test)]
    pub(super) fn variance(&self, state: usize) -> f32 {
        self.0[state][state]
    }

    /// These states have this variance, and nothing to do with the others.
    pub(super) fn forget(&mut self, states: Range<usize>, variance: f32) {
        for i in 0..STATES {
            for j in 0..STATES {
                if states.contains(&i) || states.contains(&j) {
                    self.0[i][j] = if i == j { variance } else { 0.0 };
                }
            }
        }
    }

    /// A window on: P <- F P F^T + Q with F = 1 + A dt. `body_axes_in_world` are the columns of R, `window_m_s` is the
    /// integral of the specific force over the window, world.
    pub(super) fn predict(
        &mut self,
        noises: &Noises,
        body_axes_in_world: &[Vector3<f32>; 3],
        window_m_s: &Vector3<f32>,
        window_s: f32,
    ) {
        let [x, y, z] = body_axes_in_world.map(|axis| axis * -window_s);
        let tilt_of_bias = [[x.x, y.x, z.x], [x.y, y.y, z.y]];
        // v' = phi x a
        let a = window_m_s;
        let velocity_of_tilt = [[0.0, a.z], [-a.z, 0.0], [a.y, -a.x]];
        let mut rows = self.0;
        for j in 0..STATES {
            let mut column = [0.0; BIAS + 3];
            for (i, entry) in column.iter_mut().enumerate() {
                *entry = rows[i][j];
            }
            advance(&mut column, &tilt_of_bias, &velocity_of_tilt);
            for (i, entry) in column.into_iter().enumerate() {
                rows[i][j] = entry;
            }
        }
        for row in &mut rows {
            let mut begin = [0.0; BIAS + 3];
            begin.copy_from_slice(&row[..BIAS + 3]);
            advance(&mut begin, &tilt_of_bias, &velocity_of_tilt);
            row[..BIAS + 3].copy_from_slice(&begin);
        }
        let grown = |noise: f32| noise * noise * window_s;
        for i in 0..STATES {
            rows[i][i] += match i {
                0..VELOCITY => grown(noises.gyro),
                VELOCITY..BIAS => grown(noises.force),
                BIAS..DRAG => grown(noises.bias),
                _ => DRAG_WALK_SQUARED * window_s,
            };
            for j in 0..i {
                rows[i][j] = rows[j][i];
            }
        }
        self.0 = rows;
    }

    /// A number that should be zero and is not: `residual` = `sees` times errors + noise of this variance. Adds what it
    /// says to the errors that earlier comparisons of the same window found.
    pub(super) fn compare(&mut self, errors: &mut Row, sees: &Row, residual: f32, variance: f32) {
        let seen = self.0.map(|row| dot(&row, sees));
        let known = larger(dot(&seen, sees), 0.0);
        let surprise = residual - dot(errors, sees);
        let expected = BELIEVED_DEVIATIONS * BELIEVED_DEVIATIONS * (known + variance);
        let excess = larger(surprise * surprise / expected, 1.0);
        let per_variance = 1.0 / (known + variance * excess);
        for i in 0..STATES {
            let gain = seen[i] * per_variance;
            errors[i] += gain * surprise;
            for j in i..STATES {
                self.0[i][j] -= gain * seen[j];
                self.0[j][i] = self.0[i][j];
            }
            // rounding must not make a variance negative
            self.0[i][i] = larger(self.0[i][i], 0.0);
        }
    }

    /// Is every variance a number that means something?
    pub(super) fn is_sound(&self) -> bool {
        (0..STATES).all(|i| (0.0..=VARIANCE_MAX).contains(&self.0[i][i]))
    }
}

/// F times a column: velocity by tilt, then tilt by bias.
fn advance(column: &mut [f32; BIAS + 3], tilt_of_bias: &[[f32; 3]; 2], velocity_of_tilt: &[[f32; 2]; 3]) {
    let [north, east, .., bx, by, bz] = *column;
    for (i, [by_north, by_east]) in velocity_of_tilt.iter().enumerate() {
        column[VELOCITY + i] += by_north * north + by_east * east;
    }
    for (i, [by_x, by_y, by_z]) in tilt_of_bias.iter().enumerate() {
        column[TILT + i] += by_x * bx + by_y * by + by_z * bz;
    }
}

fn dot(a: &Row, b: &Row) -> f32 {
    let mut sum = 0.0;
    for i in 0..STATES {
        sum += a[i] * b[i];
    }
    sum
}
