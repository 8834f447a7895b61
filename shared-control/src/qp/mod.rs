//! A small dense quadratic program, solved exactly, without allocation.
//!
//! ```text
//! minimise    1/2 z'Hz + f'z
//! subject to  lower     <=  z   <= upper        N bounds
//!             row_lower <=  A z <= row_upper    up to R general rows
//! ```
//!
//! H is symmetric positive definite. H and A are known at start-up and go through [`Qp::prepare`] once; f and the
//! bounds change from solve to solve.
//!
//! Method: the dual active-set method of Goldfarb and Idnani (*A numerically stable dual method for solving strictly
//! convex quadratic programs*, Mathematical Programming 27, 1983), warm-started and with a working set of two-sided
//! constraints as Arnström, Bemporad and Axehill have it (*A dual active-set solver for embedded quadratic programming
//! using recursive LDL' updates*, IEEE TAC 67, 2022). With H = R'R and w = R z the program is a projection: the point w
//! nearest to c = -R^-T f, the minimiser without constraints, of those with limits on M w, M = \[R^-1; A R^-1\].
//!
//! Two departures from the second paper, both for single precision: it takes c as the origin, where the limits lose
//! digits to a far c; and it factors M_W M_W' of the working set W, which squares the condition number of M_W, factored
//! here (`factor`).
//!
//! Everything is `+ - * /`, `sqrt` and comparisons in a fixed order: the same bits on every machine.

mod effort;
mod factor;
mod prepare;
mod solve;
#[cfg(test)]
mod tests;
mod working_set;

pub use prepare::{Qp, QpError};

use working_set::HalfSpace;

/// Limits of one solve. An absent limit is an infinity of its side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<const N: usize, const R: usize> {
    /// Least value of each variable.
    pub lower: [f32; N],
    /// Greatest value of each variable.
    pub upper: [f32; N],
    /// Least value of each general row; entries beyond the prepared rows are ignored.
    pub row_lower: [f32; R],
    /// Greatest value of each general row; entries beyond the prepared rows are ignored.
    pub row_upper: [f32; R],
}

/// When the solver stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Most changes of the working set, plus one; at least 1.
    pub iteration_limit: u16,
    /// Most work, in units of one entry of a row multiplied and added; a solve that would take more ends before. With
    /// room to spare in the type the same solve is counted as more.
    pub work_limit: u32,
    /// Largest violation that counts as none, as a distance in the norm of H relative to that of z; above the rounding
    /// of a dot product.
    pub feasibility_tolerance: f32,
    /// A row whose distance from the span of the working set is below this (rows have length 1) counts as dependent.
    pub dependence_tolerance: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { iteration_limit: 500, work_limit: u32::MAX, feasibility_tolerance: 1e-6, dependence_tolerance: 1e-5 }
    }
}

/// A setting outside its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingsError {
    /// `iteration_limit` is 0.
    IterationLimit,
    /// `feasibility_tolerance` is not within 1e-7 .. 1e-2.
    FeasibilityTolerance,
    /// `dependence_tolerance` is not within 1e-7 .. 1e-2.
    DependenceTolerance,
}

impl core::fmt::Display for SettingsError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::IterationLimit => "iteration_limit must be at least 1",
            Self::FeasibilityTolerance => "feasibility_tolerance must lie within 1e-7 .. 1e-2",
            Self::DependenceTolerance => "dependence_tolerance must lie within 1e-7 .. 1e-2",
        })
    }
}

impl core::error::Error for SettingsError {}

impl Settings {
    /// Checks the ranges that the fields' documentation states.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let tolerances = 1e-7..=1e-2;
        if self.iteration_limit == 0 {
            return Err(SettingsError::IterationLimit);
        }
        if !tolerances.contains(&self.feasibility_tolerance) {
            return Err(SettingsError::FeasibilityTolerance);
        }
        if !tolerances.contains(&self.dependence_tolerance) {
            return Err(SettingsError::DependenceTolerance);
        }
        Ok(())
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All of the Karush-Kuhn-Tucker conditions hold.
    Solved,
    /// The iteration limit was reached first.
    IterationLimit,
    /// The work limit would have been passed first.
    WorkLimit,
    /// No point satisfies all constraints.
    Infeasible,
    /// The data were not usable numbers, or overflowed.
    NumericalError,
}

/// What a solve returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<const N: usize> {
    /// The minimiser, inside its bounds to the last bit. With [`Status::WorkLimit`] the point reached, inside its
    /// bounds too, but perhaps not within the general rows; else zero.
    pub x: [f32; N],
    /// How the solve ended.
    pub status: Status,
    /// Working sets examined; 1 when the first was already optimal.
    pub iterations: u16,
    /// Work done, in the units of [`Settings::work_limit`], and never above it.
    pub work: u32,
}

/// The warm start: the constraints that were active at the last solution, and their multipliers.
///
/// Any content is a valid start, also one from another problem; it only costs iterations. A failed solve empties it;
/// one that ends at its work limit leaves what it had come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace<const N: usize> {
    active: [HalfSpace; N],
    multipliers: [f32; N],
    count: usize,
}

impl<const N: usize> Workspace<N> {
    /// A cold start: nothing active.
    pub const fn new() -> Self {
        Self { active: [HalfSpace::NONE; N], multipliers: [0.0; N], count: 0 }
    }
}

impl<const N: usize> Default for Workspace<N> {
    fn default() -> Self {
        Self::new()
    }
}
