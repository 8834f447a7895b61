//! The factor of the working set: G = L Q, L lower triangular with positive diagonal, Q with orthonormal rows.
//!
//! One row of G is one active constraint g'u = h. Appending is a Gram-Schmidt step done twice (Giraud, Langou and
//! Rozložník 2005: twice is enough), removing a sweep of Givens rotations; both as in Golub and Van Loan, *Matrix
//! Computations*, 4th edition, sections 5.2.8 and 6.5.2. With it the point of G u = h nearest to the origin is Q'y with
//! L y = h, and its multipliers (u = -G'lambda) solve L' lambda = -y.

use super::prepare::dot;

/// L and Q of up to N rows.
pub(super) struct Factor<const N: usize> {
    lower: [[f32; N]; N],
    orthonormal: [[f32; N]; N],
    count: usize,
}

/// What [`Factor::append`] found.
pub(super) enum Appended<const N: usize> {
    /// The row is part of the factor now.
    Independent,
    /// The row is this combination of the rows present, and nothing was changed.
    Dependent([f32; N]),
}

impl<const N: usize> Factor<N> {
    pub(super) fn new() -> Self {
        Self { lower: [[0.0; N]; N], orthonormal: [[0.0; N]; N], count: 0 }
    }

    /// Appends a row of length 1, unless less than `tolerance` of it is left outside the span of the rows present.
    pub(super) fn append(&mut self, row: &[f32; N], tolerance: f32) -> Appended<N> {
        let mut rest = *row;
        let mut coefficients = [0.0; N];
        for _pass in 0..2 {
            for (coefficient, direction) in coefficients.iter_mut().zip(&self.orthonormal[..self.count]) {
                let along = dot(direction, &rest);
                *coefficient += along;
                for (entry, component) in rest.iter_mut().zip(direction) {
                    *entry -= along * component;
                }
            }
        }
        let pivot = libm::sqrtf(dot(&rest, &rest));
        // N independent rows span everything: what rounding leaves of another row is no direction.
        if self.count >= N || pivot <= tolerance {
            return Appended::Dependent(self.solve_transposed(&coefficients));
        }
        for entry in &mut rest {
            *entry /= pivot;
        }
        coefficients[self.count] = pivot;
        self.lower[self.count] = coefficients;
        self.orthonormal[self.count] = rest;
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
            for row in &mut self.lower[pivot..self.count] {
                (row[pivot], row[pivot + 1]) =
                    (cosine * row[pivot] + sine * row[pivot + 1], cosine * row[pivot + 1] - sine * row[pivot]);
            }
            let (upper, lower) = self.orthonormal.split_at_mut(pivot + 1);
            for (first, second) in upper[pivot].iter_mut().zip(&mut lower[0]) {
                (*first, *second) = (cosine * *first + sine * *second, cosine * *second - sine * *first);
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
            for (entry, component) in point.iter_mut().zip(&self.orthonormal[index]) {
                *entry += along[index] * component;
            }
        }
        let multipliers = self.solve_transposed(&along).map(|entry| -entry);
        (point, multipliers)
    }

    /// Solves L'x = `right`.
    fn solve_transposed(&self, right: &[f32; N]) -> [f32; N] {
        let mut solution = *right;
        for index in (0..self.count).rev() {
            solution[index] /= self.lower[index][index];
            let value = solution[index];
            for (entry, factor) in solution[..index].iter_mut().zip(&self.lower[index]) {
                *entry -= value * factor;
            }
        }
        solution
    }
}
