//! What is computed once: the factor of H and the rows of the least-distance form.
//!
//! H = R'R (Cholesky, R upper triangular); M = [R^-1; A R^-1]. Each row of M is stored with length 1 and its true
//! length beside it, so that violations and pivots of different rows compare.

/// A prepared program: see the head of [`super`].
#[derive(Clone, Debug, PartialEq)]
pub struct Qp<const N: usize, const R: usize> {
    /// Rows of R^-1, upper triangular, scaled to length 1.
    pub(super) bound_rows: [[f32; N]; N],
    /// Length of each row of R^-1.
    pub(super) bound_lengths: [f32; N],
    /// Rows of A R^-1, scaled to length 1.
    pub(super) general_rows: [[f32; N]; R],
    /// Length of each row of A R^-1.
    pub(super) general_lengths: [f32; R],
    /// General rows in use, 0..=R.
    pub(super) general_count: usize,
}

/// Why a program can't be prepared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpError {
    /// An entry of H or A is NaN or infinite.
    NotFinite,
    /// H differs from its transpose.
    NotSymmetric,
    /// Elimination of this variable meets a pivot that is zero, negative, or lost in rounding.
    NotPositiveDefinite {
        /// Index of the variable.
        variable: usize,
    },
    /// More general rows than the type has room for.
    TooManyRows,
    /// This general row has no usable length.
    EmptyRow {
        /// Index of the row.
        row: usize,
    },
}

impl core::fmt::Display for QpError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotFinite => write!(formatter, "the matrices of the quadratic program must be finite"),
            Self::NotSymmetric => write!(formatter, "the Hessian must be symmetric"),
            Self::NotPositiveDefinite { variable } => {
                write!(formatter, "the Hessian must be positive definite, but is not at variable {variable}")
            }
            Self::TooManyRows => write!(formatter, "more constraint rows than the program has room for"),
            Self::EmptyRow { row } => write!(formatter, "constraint row {row} is zero"),
        }
    }
}

impl core::error::Error for QpError {}

impl<const N: usize, const R: usize> Qp<N, R> {
    /// Factors `hessian` (N x N) and transforms `rows` (at most R rows of N).
    pub fn prepare(hessian: &[[f32; N]; N], rows: &[[f32; N]]) -> Result<Self, QpError> {
        if rows.len() > R {
            return Err(QpError::TooManyRows);
        }
        if !hessian.iter().chain(rows).flatten().all(|entry| entry.is_finite()) {
            return Err(QpError::NotFinite);
        }
        let inverse = invert_upper(&cholesky(hessian)?);
        let mut qp = Self {
            bound_rows: inverse,
            bound_lengths: [0.0; N],
            general_rows: [[0.0; N]; R],
            general_lengths: [0.0; R],
            general_count: rows.len(),
        };
        for (variable, (row, length)) in qp.bound_rows.iter_mut().zip(&mut qp.bound_lengths).enumerate() {
            *length = normalise(row).ok_or(QpError::NotPositiveDefinite { variable })?;
        }
        for (index, source) in rows.iter().enumerate() {
            let mut row = [0.0; N];
            for (weight, inverse_row) in source.iter().zip(&inverse) {
                for (sum, entry) in row.iter_mut().zip(inverse_row) {
                    *sum += weight * entry;
                }
            }
            qp.general_lengths[index] = normalise(&mut row).ok_or(QpError::EmptyRow { row: index })?;
            qp.general_rows[index] = row;
        }
        Ok(qp)
    }

    /// v = R^-T f.
    pub(super) fn offset(&self, linear: &[f32; N]) -> [f32; N] {
        let mut offset = [0.0; N];
        for (variable, row) in self.bound_rows.iter().enumerate() {
            let weight = linear[variable] * self.bound_lengths[variable];
            for (sum, entry) in offset.iter_mut().zip(row).skip(variable) {
                *sum += weight * entry;
            }
        }
        offset
    }

    /// The minimiser without any constraint, -H^-1 f.
    pub fn unconstrained(&self, linear: &[f32; N]) -> [f32; N] {
        self.variables(&[0.0; N], &self.offset(linear))
    }

    /// z = R^-1 (u - v).
    pub(super) fn variables(&self, point: &[f32; N], offset: &[f32; N]) -> [f32; N] {
        let mut difference = *point;
        for (entry, shift) in difference.iter_mut().zip(offset) {
            *entry -= shift;
        }
        let mut variables = [0.0; N];
        for (variable, row) in self.bound_rows.iter().enumerate() {
            variables[variable] = self.bound_lengths[variable] * dot(&row[variable..], &difference[variable..]);
        }
        variables
    }
}

/// Sum of products, in index order.
pub(super) fn dot(left: &[f32], right: &[f32]) -> f32 {
    left.iter().zip(right).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// Scales `row` to length 1 and returns the length it had; none if that is no normal number.
fn normalise<const N: usize>(row: &mut [f32; N]) -> Option<f32> {
    let length = libm::sqrtf(dot(row, row));
    if !length.is_normal() {
        return None;
    }
    for entry in row {
        *entry /= length;
    }
    Some(length)
}

/// The upper triangular R with R'R = `hessian`.
fn cholesky<const N: usize>(hessian: &[[f32; N]; N]) -> Result<[[f32; N]; N], QpError> {
    let mut factor = [[0.0; N]; N];
    for row in 0..N {
        for column in row..N {
            if hessian[row][column] != hessian[column][row] {
                return Err(QpError::NotSymmetric);
            }
            let mut rest = hessian[row][column];
            for above in &factor[..row] {
                rest -= above[row] * above[column];
            }
            if column > row {
                factor[row][column] = rest / factor[row][row];
            } else if rest > N as f32 * f32::EPSILON * hessian[row][row] {
                factor[row][row] = libm::sqrtf(rest);
            } else {
                return Err(QpError::NotPositiveDefinite { variable: row });
            }
        }
    }
    Ok(factor)
}

/// Inverse of an upper triangular matrix with a positive diagonal, by back substitution.
fn invert_upper<const N: usize>(factor: &[[f32; N]; N]) -> [[f32; N]; N] {
    let mut inverse = [[0.0; N]; N];
    for column in 0..N {
        inverse[column][column] = 1.0 / factor[column][column];
        for row in (0..column).rev() {
            let mut sum = 0.0;
            for inner in row + 1..=column {
                sum += factor[row][inner] * inverse[inner][column];
            }
            inverse[row][column] = -sum / factor[row][row];
        }
    }
    inverse
}
