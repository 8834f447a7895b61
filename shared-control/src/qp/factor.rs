//! The factor of the working set: G = L Q, L lower triangular with positive diagonal, Q with orthonormal rows.
//!
//! One row of G is one active constraint g'u = h. Appending is a Gram-Schmidt step done twice (Giraud, Langou and
//! Rozložník 2005: twice is enough), removing a sweep of Givens rotations; both as in Golub and Van Loan, *Matrix
//! Computations*, 4th edition, sections 5.2.8 and 6.5.2. With it the point of G u = h nearest to the origin is Q'y with
//! L y = h, and its multipliers (u = -G'lambda) solve L' lambda = -y.

use super::prepare::{add_scaled, dot};

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

    /// Appends a row of length 1, unless at most `tolerance` of it is left outside the span of the rows present.
    pub(super) fn append(&mut self, row: &[f32; N], tolerance: f32) -> Appended<N> {
        let mut whole = *row;
        let rest = &mut whole[..self.variable_count];
        let mut coefficients = [0.0; N];
        for _pass in 0..2 {
            for (coefficient, direction) in coefficients.iter_mut().zip(&self.orthonormal[..self.count]) {
                let along = dot(direction, rest);
                *coefficient += along;
                add_scaled(rest, -along, direction);
            }
        }
        let pivot = libm::sqrtf(dot(rest, rest));
        // As many independent rows as variables span everything: what rounding leaves of one more is no direction.
        if self.count >= self.variable_count || pivot <= tolerance {
            return Appended::Dependent(self.solve_transposed(&coefficients));
        }
        for entry in rest {
            *entry /= pivot;
        }
        coefficients[self.count] = pivot;
        self.lower[self.count] = coefficients;
        self.orthonormal[self.count] = whole;
        self.count += 1;
        Appended::Independent
    }

    /// Removes the row at `position`; later rows move up by one.
    pub(super) fn remove(&mut self, position: usize) {
        if position >= self.count {
            return;
        }
        self.lower[position..self.count].rotate_left(1);
        self.count -= 1;
        // Each later row now reaches one column past the diagonal: rotate that entry into the diagonal.
        for pivot in position..self.count {
            let (kept, excess) = (self.lower[pivot][pivot], self.lower[pivot][pivot + 1]);
            let length = libm::sqrtf(kept * kept + excess * excess);
            let (cosine, sine) = (kept / length, excess / length);
            let rotate = |first: &mut f32, second: &mut f32| {
                (*first, *second) = (cosine * *first + sine * *second, cosine * *second - sine * *first);
            };
            for row in &mut self.lower[pivot..self.count] {
                let (left, right) = row.split_at_mut(pivot + 1);
                rotate(&mut left[pivot], &mut right[0]);
            }
            let (above, below) = self.orthonormal.split_at_mut(pivot + 1);
            for (first, second) in above[pivot].iter_mut().zip(&mut below[0]).take(self.variable_count) {
                rotate(first, second);
            }
        }
    }

    /// The point of G u = `limits` nearest to the origin, and its multipliers: u = -G'lambda.
    pub(super) fn nearest_point(&self, limits: &[f32; N]) -> ([f32; N], [f32; N]) {
        let mut along = [0.0; N];
        let mut point = [0.0; N];
        for index in 0..self.count {
            let row = &self.lower[index];
            along[index] = (limits[index] - dot(&row[..index], &along[..index])) / row[index];
            add_scaled(&mut point[..self.variable_count], along[index], &self.orthonormal[index]);
        }
        (point, self.solve_transposed(&along.map(|entry| -entry)))
    }

    /// Solves L'x = `right`.
    fn solve_transposed(&self, right: &[f32; N]) -> [f32; N] {
        let mut solution = *right;
        for index in (0..self.count).rev() {
            solution[index] /= self.lower[index][index];
            let value = solution[index];
            add_scaled(&mut solution[..index], -value, &self.lower[index]);
        }
        solution
    }
}
