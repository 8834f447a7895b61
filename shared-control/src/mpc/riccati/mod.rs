//! The solver: one bounded input over a horizon, the linear-quadratic problem of one axis, solved exactly by its
//! structure.
//!
//! ```text
//! minimise    sum over k of tracking(x_(k+1), r_(k+1)) + rho (u_k - u_(k-1))^2,   k = 0 .. M
//! subject to  x_(k+1) = the model's step from x_k with u_k,   low <= u_k <= high
//! ```
//!
//! and the last input is held to the horizon's end. It is written once, for S states and M inputs, and flies as
//! [`Tracking`]; [`Regulating`] is the thesis' problem, with r = 0 and |u| <= 1.
//!
//! Method: for a guess of which inputs are held at a bound, and at which, dynamic programming from the last stage to
//! the first gives each input as an affine function of state and previous input (a sweep). Following these laws from
//! the present state, and cutting each input at its bounds on the way, gives the next guess (a roll-out). When the
//! guess comes out as it went in, nothing was cut that was not held and nothing held wants to leave its bound: the
//! conditions of Karush, Kuhn and Tucker, which are sufficient here. Any number of inputs changes at once, as in the
//! primal-dual active-set method (Hintermueller, Ito and Kunisch, *The primal-dual active set strategy as a semismooth
//! Newton method*, SIAM J. Optim. 13, 2002), whose guess is made without the cut; cutting (Tassa, Mansard and Todorov,
//! *Control-limited differential dynamic programming*, ICRA 2014) halves the number of passes here (docs/solver.md).
//!
//! A sweep begins at the last stage that changed, since costs ahead depend on later stages only; and after the last
//! held stage the laws are those without bounds, made at start-up.

mod angle_bounds;
mod angles;
mod columns;
mod dual;
mod equality;
mod guess;
mod lagged;
mod model;
mod prepare;
mod problem;
mod quadratic;
mod rows;
mod solve;
#[cfg(test)]
mod tests;
mod working_set;

pub(super) use angle_bounds::{AngleBounds, SoftAngle};
pub(super) use dual::HeldAngles;
use guess::Held;
pub(super) use guess::{Laws, Pattern};
pub(super) use lagged::LaggedIntegrator;
pub(super) use model::{DoubleIntegrator, Model};
pub(super) use problem::{Problem, Regulating, Slot, Tracking};
use quadratic::{Law, Quadratic};
pub(super) use solve::Outcome;

/// A held input wants to leave its bound if its law requests so much less. Without it, where an input only just reaches
/// its bound, rounding may have it held and free in turns.
const SLACK: f32 = 1e-5;

/// One stage when all later inputs, and its own, are free.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FreeStage<const S: usize> {
    law: Law<S>,
    /// The cost ahead of it, in its state and input.
    ahead: Quadratic<S>,
    /// As long as the sizes of state and previous input, weighted so, sum to at most 1, no later input reaches a bound.
    reach: Law<S>,
}

impl<const S: usize> FreeStage<S> {
    const BLANK: Self = Self { law: Law::ZERO, ahead: Quadratic::ZERO, reach: Law::ZERO };

    /// A certificate for bounds of 1, not a test: it may be false though no bound is reached.
    #[inline(always)]
    fn reaches_no_bound(&self, state: &[f32; S], previous: f32) -> bool {
        self.reach.input(&state.map(f32::abs), previous.abs()) <= 1.0
    }
}

/// A prepared problem with room for M inputs.
#[derive(Clone, Debug)]
pub(super) struct BoundedLq<D, const S: usize, const M: usize> {
    model: D,
    increment_weight: f32,
    control_horizon: usize,
    free: [FreeStage<S>; M],
    /// Tells this problem from others, whose laws are wrong here.
    stamp: u32,
}
