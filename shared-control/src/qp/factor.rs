//! The factor of the working set: G = L Q, L lower triangular with positive diagonal, Q with orthonormal rows.
//!
//! One row of G is one active constraint g'w = h. Appending is a Gram-Schmidt step done twice (Giraud, Langou and
//! Rozložník 2005: twice is enough), removing a sweep of Givens rotations; both as in Golub and Van Loan, *Matrix
//! Computations*, 4th edition, sections 5.2.8 and 6.5.2. With it the point of G w = h nearest to c is c - Q's with
//! s = Q c - L^-1 h, and its multipliers (w - c = -G'lambda) solve L' lambda = s.

use super::prepare::{add_scaled, dot, length};

/// L and Q of as many rows as there are variables, at most.
pub(super) struct Factor<const N: usize> {
    lower: [[f32; N]; N],
    orthonormal: [[f32; N]; N],
    count: usize,
    variable_count: usize,
}

/// What [`Factor::append`] found.
pub(super) enum Appended<const N: usize> {
    /// The row is part of the factor now.
    Independent,
    /// The row is this combination of the rows present, and nothing was changed.
    Dependent([f32; N]),
}

impl<const N: usize> Factor<N> {
    pub(super) fn new(variable_count: usize) -> Self {
        Self { lower: [[0.0; N]; N], orthonormal: [[0.0; N]; N], count: 0, variable_count }
    }

    /// Never above N, and written so that the compiler sees it: then it leaves no panic behind an index.
    fn count(&self) -> usize {
        self.count.min(N)
    }

    /// As for [`Self::count`].
    fn variable_count(&self) -> usize {
        self.variable_count.min(N)
    }

    /// Appends a row of length 1, unless at most `tolerance` of it is left outside the span of the rows present.
    pub(super) fn append(&mut self, row: &[f32; N], tolerance: f32) -> Appended<N> {
        let mut whole = *row;
        let rest = &mut whole[..self.variable_count()];
        let mut coefficients = [0.0; N];
        let place = self.count();
        for _pass in 0..2 {
            for (coefficient, direction) in coefficients.iter_mut().zip(&self.orthonormal[..place]) {
                let along = dot(direction, rest);
                *coefficient += along;
                add_scaled(rest, -along, direction);
            }
        }
        let pivot = length(rest);
        // As many independent rows as variables span everything: what rounding leaves of one more is no direction.
        if place >= self.variable_count() || pivot <= tolerance {
            return Appended::Dependent(self.solve_transposed(&coefficients));
        }
        for entry in rest {
            *entry /= pivot;
        }
        coefficients[place] = pivot;
        self.lower[place] = coefficients;
        self.orthonormal[place] = whole;
        self.count = place + 1;
        Appended::Independent
    }

    /// Removes the row at `position`; later rows move up by one.
    pub(super) fn remove(&mut self, position: usize) {
        let (count, variable_count) = (self.count(), self.variable_count());
        if position >= count {
            return;
        }
        self.lower[position..count].rotate_left(1);
        let count = count - 1;
        self.count = count;
        // Each later row now reaches one column past the diagonal: rotate that entry into the diagonal.
        for pivot in position..count {
            let (kept, excess) = (self.lower[pivot][pivot], self.lower[pivot][pivot + 1]);
            let length = libm::sqrtf(kept * kept + excess * excess);
            let (cosine, sine) = (kept / length, excess / length);
            let rotate = |first: &mut f32, second: &mut f32| {
                (*first, *second) = (cosine * *first + sine * *second, cosine * *second - sine * *first);
            };
            for row in &mut self.lower[pivot..count] {
                let (left, right) = row.split_at_mut(pivot + 1);
                rotate(&mut left[pivot], &mut right[0]);
            }
            let (above, below) = self.orthonormal.split_at_mut(pivot + 1);
            for (first, second) in above[pivot].iter_mut().zip(&mut below[0]).take(variable_count) {
                rotate(first, second);
            }
        }
    }

    /// The point of G w = `limits` nearest to `target`, and its multipliers: w - c = -G'lambda.
    pub(super) fn nearest_point(&self, limits: &[f32; N], target: &[f32; N]) -> ([f32; N], [f32; N]) {
        let mut point = *target;
        let within = &mut point[..self.variable_count()];
        let (mut along, mut shift) = ([0.0; N], [0.0; N]);
        for (index, row) in self.lower[..self.count()].iter().enumerate() {
            along[index] = (limits[index] - dot(&row[..index], &along[..index])) / row[index];
        }
        // Twice is enough here too: what the first pass leaves of a far target is only rounding.
        for _pass in 0..2 {
            for (index, direction) in self.orthonormal[..self.count()].iter().enumerate() {
                let excess = dot(direction, within) - along[index];
                add_scaled(within, -excess, direction);
                shift[index] += excess;
            }
        }
        (point, self.solve_transposed(&shift))
    }

    /// Solves L'x = `right`.
    fn solve_transposed(&self, right: &[f32; N]) -> [f32; N] {
        let mut solution = *right;
        for index in (0..self.count()).rev() {
            solution[index] /= self.lower[index][index];
            let value = solution[index];
            add_scaled(&mut solution[..index], -value, &self.lower[index]);
        }
        solution
    }
}
