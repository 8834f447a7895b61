//! States from which no limit is ever reached: the MPC's terminal set. An ellipsoid of a Lyapunov function of the loop
//! without limits is never left by it; one so small that within it all planned torques are inside of their limits is
//! never left by what flies either, since there the two are the same.

use nalgebra::{Matrix4, Vector4};

use super::law::{ClosedLoop, Rows};

/// { z : z' P z <= level }
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuietSet {
    /// P.
    pub shape: Matrix4<f64>,
    /// Of the Lyapunov function.
    pub level: f64,
}

impl QuietSet {
    /// For a loop all of whose planned torques may be `torque_max_nm`, by the Lyapunov function that falls by
    /// `z' diag(falls) z` in a step; none where the loop is not stable.
    pub fn new<const M: usize>(looped: &ClosedLoop<M>, falls: &Vector4<f64>, torque_max_nm: f64) -> Option<Self> {
        Self::within(lyapunov(&looped.step, falls)?, &looped.plan, torque_max_nm)
    }

    /// The largest ellipsoid on which none of these rows is beyond a limit.
    pub fn within<const M: usize>(shape: Matrix4<f64>, rows: &Rows<M>, limit_nm: f64) -> Option<Self> {
        let inverse = shape.try_inverse()?;
        // the largest of a row over the ellipsoid is sqrt(level row P^-1 row')
        let widest = rows.row_iter().map(|row| (row * inverse * row.transpose())[0]).fold(0.0, f64::max);
        Some(Self { shape, level: limit_nm * limit_nm / widest })
    }

    /// What the Lyapunov function is to fall by for [`Self::new`] to reach the largest angle at rest.
    pub fn widest_falls<const M: usize>(looped: &ClosedLoop<M>, torque_max_nm: f64) -> Vector4<f64> {
        widest(|falls| Self::new(looped, falls, torque_max_nm).map_or(0.0, |set| set.reach(0)))
    }

    /// Lyapunov function of a state over the level: at most 1 within.
    pub fn depth(&self, state: &Vector4<f64>) -> f64 {
        state.dot(&(self.shape * state)) / self.level
    }

    /// The largest angle, rate or torque with all others zero.
    pub fn reach(&self, component: usize) -> f64 {
        (self.level / self.shape[(component, component)]).sqrt()
    }
}

/// P with A' P A - P = -diag(falls), by doubling: sums of 1, 2, 4, ... terms of A'^k diag(falls) A^k. None where they
/// have no sum.
pub fn lyapunov(step: &Matrix4<f64>, falls: &Vector4<f64>) -> Option<Matrix4<f64>> {
    let (mut sum, mut power) = (Matrix4::from_diagonal(falls), *step);
    for _ in 0..40 {
        let more = power.transpose() * sum * power;
        sum += more;
        if !sum.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        if more.amax() < 1e-15 * sum.amax() {
            return Some(sum);
        }
        power *= power;
    }
    None
}

/// What the Lyapunov function falls by in a step, chosen for the largest value: each weight in turn by factors from 81
/// down to 1.5.
pub fn widest(value: impl Fn(&Vector4<f64>) -> f64) -> Vector4<f64> {
    let mut best = Vector4::repeat(1.0);
    let mut most = value(&best);
    for factor in [81.0, 9.0, 3.0, 1.5] {
        let mut goes_on = true;
        while goes_on {
            goes_on = false;
            for (component, factor) in (0..4).flat_map(|component| [(component, factor), (component, 1.0 / factor)]) {
                let mut tried = best;
                tried[component] *= factor;
                let found = value(&tried);
                // more by rounding alone would go on for ever
                if found > most * (1.0 + 1e-6) {
                    (best, most, goes_on) = (tried, found, true);
                }
            }
        }
    }
    best
}
