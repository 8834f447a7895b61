//! The working set: the constraints taken as equalities, their multipliers, and the factor that goes with them.
//!
//! A constraint with two sides is two half-spaces g'w <= h, of which one at a time can be active; so all multipliers
//! are >= 0.

use super::Workspace;
use super::factor::{Appended, Factor};
use super::prepare::add_scaled;

/// One side of one constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct HalfSpace {
    /// Index: bounds of the variables first, then, from N on, the general rows.
    pub(super) constraint: u16,
    /// Which side: the greatest value (g = m) or the least (g = -m).
    pub(super) is_upper: bool,
}

impl HalfSpace {
    /// Fills unused places of a warm start; no problem has so many constraints.
    pub(super) const NONE: Self = Self { constraint: u16::MAX, is_upper: false };
}

/// g'w <= h, g of length 1.
pub(super) struct Inequality<const N: usize> {
    pub(super) half_space: HalfSpace,
    pub(super) row: [f32; N],
    pub(super) limit: f32,
}

/// Constraints held as equalities G w = h with multipliers lambda >= 0, rows of G independent.
pub(super) struct WorkingSet<const N: usize> {
    active: [HalfSpace; N],
    multipliers: [f32; N],
    limits: [f32; N],
    count: usize,
    factor: Factor<N>,
    dependence_tolerance: f32,
}

/// Where a walk of the multipliers ends: the first of them to reach zero, after this share of the way.
#[derive(Clone, Copy)]
pub(super) struct Blocking {
    pub(super) position: usize,
    pub(super) step: f32,
}

impl<const N: usize> WorkingSet<N> {
    pub(super) fn new(variable_count: usize, dependence_tolerance: f32) -> Self {
        Self {
            active: [HalfSpace::NONE; N],
            multipliers: [0.0; N],
            limits: [0.0; N],
            count: 0,
            factor: Factor::new(variable_count),
            dependence_tolerance,
        }
    }

    /// Never above N, and written so that the compiler sees it: then it leaves no panic behind an index.
    fn count(&self) -> usize {
        self.count.min(N)
    }

    /// The constraints held.
    pub(super) fn active(&self) -> &[HalfSpace] {
        &self.active[..self.count()]
    }

    /// Holds one more constraint; or, its row being dependent on those held, says of which combination.
    pub(super) fn append(&mut self, entering: &Inequality<N>, multiplier: f32) -> Appended<N> {
        let appended = self.factor.append(&entering.row, self.dependence_tolerance);
        let place = self.count();
        // the factor takes no more than N
        if let Appended::Independent = appended
            && place < N
        {
            self.active[place] = entering.half_space;
            self.limits[place] = entering.limit;
            self.multipliers[place] = multiplier;
            self.count = place + 1;
        }
        appended
    }

    /// The point nearest to `target` that keeps all equalities, and the multipliers that make it stationary.
    pub(super) fn nearest_point(&self, target: &[f32; N]) -> ([f32; N], [f32; N]) {
        self.factor.nearest_point(&self.limits, target)
    }

    /// Moves the multipliers to `target`, or, if one of them would become negative, to where the first vanishes.
    pub(super) fn walk_to(&mut self, target: &[f32; N]) -> Option<Blocking> {
        if target[..self.count()].iter().all(|aim| *aim >= 0.0) {
            self.multipliers = *target;
            return None;
        }
        let mut direction = *target;
        add_scaled(&mut direction, -1.0, &self.multipliers[..self.count()]);
        let blocking = self.first_to_vanish(&direction)?;
        self.walk(&direction, blocking.step);
        Some(blocking)
    }

    /// The first multiplier that reaches zero when they move by `direction` again and again; none if none falls.
    pub(super) fn first_to_vanish(&self, direction: &[f32; N]) -> Option<Blocking> {
        let mut first: Option<Blocking> = None;
        for (position, (multiplier, rate)) in self.multipliers.iter().zip(direction).take(self.count()).enumerate() {
            let step = -multiplier / rate;
            if *rate < 0.0 && first.is_none_or(|found| step < found.step) {
                first = Some(Blocking { position, step });
            }
        }
        first
    }

    /// Moves the multipliers by `step` times `direction`.
    pub(super) fn walk(&mut self, direction: &[f32; N], step: f32) {
        let count = self.count();
        for (multiplier, rate) in self.multipliers[..count].iter_mut().zip(direction) {
            let moved = *multiplier + step * rate;
            // Rounding may end a hair below zero.
            *multiplier = if moved > 0.0 { moved } else { 0.0 };
        }
    }

    /// Lets go of the constraint that blocks.
    pub(super) fn release(&mut self, blocking: Blocking) {
        let (position, count) = (blocking.position, self.count());
        if position >= count {
            return;
        }
        self.factor.remove(position);
        self.active[position..count].rotate_left(1);
        self.multipliers[position..count].rotate_left(1);
        self.limits[position..count].rotate_left(1);
        self.count = count - 1;
    }

    /// The warm start for the next solve.
    pub(super) fn store(&self) -> Workspace<N> {
        Workspace { active: self.active, multipliers: self.multipliers, count: self.count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Holds the three axes with these multipliers.
    fn holding(multipliers: [f32; 3]) -> WorkingSet<3> {
        let mut working = WorkingSet::new(3, 1e-5);
        for (axis, multiplier) in multipliers.into_iter().enumerate() {
            let mut row = [0.0; 3];
            row[axis] = 1.0;
            let half_space = HalfSpace { constraint: axis as u16, is_upper: true };
            working.append(&Inequality { half_space, row, limit: 1.0 }, multiplier);
        }
        working
    }

    /// From (1, 2, 3) to (-1, 4, 3) the first vanishes half-way, where the others are (3, 3).
    #[test]
    fn a_walk_ends_where_the_first_multiplier_vanishes() {
        let mut working = holding([1.0, 2.0, 3.0]);
        let blocking = working.walk_to(&[-1.0, 4.0, 3.0]).unwrap();
        assert_eq!((blocking.position, blocking.step), (0, 0.5));
        assert_eq!(working.multipliers, [0.0, 3.0, 3.0]);
        working.release(blocking);
        assert_eq!(working.multipliers[..2], [3.0, 3.0]);
        assert_eq!(working.active().iter().map(|held| held.constraint).sum::<u16>(), 1 + 2);
        // and to where none is negative they go at once
        assert!(working.walk_to(&[0.0, 7.0, 0.0]).is_none());
        assert_eq!(working.multipliers[..2], [0.0, 7.0]);
    }

    /// Only those that fall can vanish; of two that vanish together the first is let go.
    #[test]
    fn only_what_falls_vanishes() {
        let working = holding([1.0, 1.0, 1.0]);
        let found = |direction: [f32; 3]| working.first_to_vanish(&direction).map(|found| (found.position, found.step));
        assert_eq!(found([0.0, -0.5, 1.0]), Some((1, 2.0)));
        assert_eq!(found([-0.5, -2.0, -1.0]), Some((1, 0.5)));
        assert_eq!(found([1.0, -1.0, -1.0]), Some((1, 1.0)));
        assert_eq!(found([0.0, 1.0, 2.0]), None);
    }

    /// Rounding below zero is zero: multipliers stay dual feasible.
    #[test]
    fn no_multiplier_becomes_negative() {
        let mut working = holding([1.0, 0.5, 0.0]);
        working.walk(&[-1.0, -1.0, 1.0], 0.75);
        assert_eq!(working.multipliers, [0.25, 0.0, 0.75]);
    }
}
