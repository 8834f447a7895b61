//! The working set: the constraints taken as equalities, their multipliers, and the factor that goes with them.
//!
//! A constraint with two sides is two half-spaces g'u <= h, of which one at a time can be active; so all multipliers
//! are >= 0.

use super::Workspace;
use super::factor::{Appended, Factor};

/// One side of one constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct HalfSpace {
    /// Index: bounds of the N variables first, then the general rows.
    pub(super) constraint: u16,
    /// Which side: the greatest value (g = m, h = d_upper) or the least (g = -m, h = -d_lower).
    pub(super) is_upper: bool,
}

impl HalfSpace {
    /// Fills unused places of a warm start; no problem has so many constraints.
    pub(super) const NONE: Self = Self { constraint: u16::MAX, is_upper: false };
}

/// Constraints held as equalities G u = h with multipliers lambda >= 0, rows of G independent.
pub(super) struct WorkingSet<const N: usize> {
    pub(super) active: [HalfSpace; N],
    pub(super) multipliers: [f32; N],
    pub(super) count: usize,
    limits: [f32; N],
    factor: Factor<N>,
}

/// Where a walk along a direction of the multipliers ends: the first of them to reach zero.
pub(super) struct Blocking {
    position: usize,
    step: f32,
}

impl<const N: usize> WorkingSet<N> {
    pub(super) fn new() -> Self {
        Self { active: [HalfSpace::NONE; N], multipliers: [0.0; N], count: 0, limits: [0.0; N], factor: Factor::new() }
    }

    pub(super) fn contains(&self, constraint: u16) -> bool {
        self.active[..self.count].iter().any(|held| held.constraint == constraint)
    }

    /// Holds one more half-space, row'u <= limit; or, its row being dependent, says of which combination.
    pub(super) fn append(
        &mut self,
        half_space: HalfSpace,
        row: &[f32; N],
        limit: f32,
        multiplier: f32,
        dependence_tolerance: f32,
    ) -> Appended<N> {
        let appended = self.factor.append(row, dependence_tolerance);
        if let Appended::Independent = appended {
            self.active[self.count] = half_space;
            self.limits[self.count] = limit;
            self.multipliers[self.count] = multiplier;
            self.count += 1;
        }
        appended
    }

    /// The nearest point to the origin that keeps all equalities, and the multipliers that make it stationary.
    pub(super) fn nearest_point(&self) -> ([f32; N], [f32; N]) {
        self.factor.nearest_point(&self.limits)
    }

    /// The first multiplier to reach zero on the way to `target`; none if all stay >= 0.
    pub(super) fn blocking_towards(&self, target: &[f32; N]) -> Option<Blocking> {
        let mut first: Option<Blocking> = None;
        for position in 0..self.count {
            if target[position] < 0.0 {
                let step = self.multipliers[position] / (self.multipliers[position] - target[position]);
                if first.as_ref().is_none_or(|found| step < found.step) {
                    first = Some(Blocking { position, step });
                }
            }
        }
        first
    }

    /// The first multiplier to reach zero when they fall at these rates without end; none if none falls.
    pub(super) fn blocking_along(&self, rates: &[f32; N]) -> Option<Blocking> {
        let mut first: Option<Blocking> = None;
        for position in 0..self.count {
            if rates[position] > 0.0 {
                let step = self.multipliers[position] / rates[position];
                if first.as_ref().is_none_or(|found| step < found.step) {
                    first = Some(Blocking { position, step });
                }
            }
        }
        first
    }

    /// Walks towards `target` as far as `blocking` allows and lets go of the constraint that blocks.
    pub(super) fn walk_towards(&mut self, target: &[f32; N], blocking: &Blocking) {
        for (multiplier, aim) in self.multipliers[..self.count].iter_mut().zip(target) {
            *multiplier = not_negative(*multiplier + blocking.step * (aim - *multiplier));
        }
        self.remove(blocking.position);
    }

    /// Walks down `rates` as far as `blocking` allows, lets go of the constraint that blocks, and returns the step.
    pub(super) fn walk_along(&mut self, rates: &[f32; N], blocking: &Blocking) -> f32 {
        for (multiplier, rate) in self.multipliers[..self.count].iter_mut().zip(rates) {
            *multiplier = not_negative(*multiplier - blocking.step * rate);
        }
        self.remove(blocking.position);
        blocking.step
    }

    /// The warm start for the next solve.
    pub(super) fn store(&self) -> Workspace<N> {
        Workspace { active: self.active, multipliers: self.multipliers, count: self.count }
    }

    fn remove(&mut self, position: usize) {
        self.factor.remove(position);
        self.active[position..self.count].rotate_left(1);
        self.multipliers[position..self.count].rotate_left(1);
        self.limits[position..self.count].rotate_left(1);
        self.count -= 1;
    }
}

/// Rounding may take a multiplier a hair below zero.
fn not_negative(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}
