//! With one free input and limits of its own per axis the MPC is its linear law cut to the limit, as a program of one
//! unknown has no other solution: of three pieces, which can be enumerated. How far from level is it surely stable?
//!
//! Where |K z| <= U / s the torque is some share of K z between s and 1. A quadratic Lyapunov function that falls under
//! both shares falls under all between them, for its value after a step is convex in the share. So an ellipsoid on
//! which |K z| <= U / s is never left, and all that begins in it comes to rest.

use nalgebra::{Matrix4, Vector4};

use super::law::ClosedLoop;
use super::quiet_set::{self, QuietSet, lyapunov};

/// Shares for whose loop the Lyapunov functions are made.
const MADE_FOR: [f64; 7] = [1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.1];

/// The largest such ellipsoid of one Lyapunov function, and the least share of the law in it.
pub fn certificate(
    looped: &ClosedLoop<1>,
    falls: &Vector4<f64>,
    made_for: f64,
    torque_max_nm: f64,
) -> Option<(QuietSet, f64)> {
    let shape = lyapunov(&looped.step_with(made_for), falls)?;
    if shape.cholesky().is_none() || !falls_under(&shape, &looped.step) {
        return None;
    }
    let (mut stable, mut not) = (1.0, 0.0);
    for _ in 0..40 {
        let middle = 0.5 * (stable + not);
        if falls_under(&shape, &looped.step_with(middle)) { stable = middle } else { not = middle }
    }
    Some((QuietSet::within(shape, &looped.plan, torque_max_nm / stable)?, stable))
}

/// The certificate with the largest angle at rest.
pub fn widest(looped: &ClosedLoop<1>, torque_max_nm: f64) -> Option<(QuietSet, f64)> {
    let of = |falls: &Vector4<f64>| {
        let all = MADE_FOR.iter().filter_map(|&share| certificate(looped, falls, share, torque_max_nm));
        all.max_by(|(one, _), (other, _)| one.reach(0).total_cmp(&other.reach(0)))
    };
    of(&quiet_set::widest(|falls| of(falls).map_or(0.0, |(set, _)| set.reach(0))))
}

/// Whether the Lyapunov function falls in a step, everywhere but at rest.
fn falls_under(shape: &Matrix4<f64>, step: &Matrix4<f64>) -> bool {
    (shape - step.transpose() * shape * step).cholesky().is_some()
}
