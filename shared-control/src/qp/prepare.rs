//! What is computed once: the factor of H and the rows of the projection.
//!
//! H = R'R (Cholesky, R upper triangular); M = [R^-1; A R^-1]. Each row of M is stored with length 1 and its true
//! length beside it, so that violations and pivots of different rows compare.

/// A prepared program, see the head of [`crate::qp`], with room for N variables and R general rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Qp<const N: usize, const R: usize> {
    /// Variables in use, 1..=N; arrays are zero beyond.
    pub(super) variable_count: usize,
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

/// Greatest H_ii (H^-1)_ii; the thesis' weights give at most 60.
const CONDITION_LIMIT: f32 = 1e4;

/// Why a program can't be prepared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpError {
    /// An entry of H or A is NaN or infinite.
    NotFinite,
    /// No variables, or more than the type has room for.
    VariableCount,
    /// H differs from its transpose.
    NotSymmetric,
    /// Elimination of this variable meets a pivot that is not positive.
    NotPositiveDefinite {
        /// Index of the variable.
        variable: usize,
    },
    /// Single precision can't tell this variable from the others: H_ii (H^-1)_ii is above 1e4, so that more than four
    /// of its seven digits are lost.
    IllConditioned {
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
            Self::VariableCount => {
                write!(formatter, "no variables, or more than the program has room for")
            }
            Self::NotSymmetric => write!(formatter, "the Hessian must be symmetric"),
            Self::NotPositiveDefinite { variable } => {
                write!(formatter, "the Hessian must be positive definite, but is not at variable {variable}")
            }
            Self::IllConditioned { variable } => {
                write!(formatter, "the Hessian is too ill-conditioned for single precision at variable {variable}")
            }
            Self::TooManyRows => write!(formatter, "more constraint rows than the program has room for"),
            Self::EmptyRow { row } => write!(formatter, "constraint row {row} is zero"),
        }
    }
}

impl core::error::Error for QpError {}

impl<const N: usize, const R: usize> Qp<N, R> {
    /// Factors `hessian` and transforms `rows`.
    ///
    /// The number of rows of `hessian` is the number of variables, n in 1..=N, and of each row, here and in `rows`, the
    /// first n entries count. There may be 0..=R `rows`.
    pub fn prepare(hessian: &[[f32; N]], rows: &[[f32; N]]) -> Result<Self, QpError> {
        let variable_count = hessian.len();
        if variable_count == 0 || variable_count > N {
            return Err(QpError::VariableCount);
        }
        if rows.len() > R {
            return Err(QpError::TooManyRows);
        }
        let mut entries = hessian.iter().chain(rows).flat_map(|row| &row[..variable_count]);
        if !entries.all(|entry| entry.is_finite()) {
            return Err(QpError::NotFinite);
        }
        let mut qp = Self {
            variable_count,
            bound_rows: [[0.0; N]; N],
            bound_lengths: [0.0; N],
            general_rows: [[0.0; N]; R],
            general_lengths: [0.0; R],
            general_count: rows.len(),
        };
        // made where it stays: a board's stack has no room for copies
        cholesky(hessian, &mut qp.bound_rows)?;
        invert_upper(&mut qp.bound_rows, variable_count);
        let general = qp.general_rows.iter_mut().zip(&mut qp.general_lengths).zip(rows);
        for (index, ((row, general_length), source)) in general.enumerate() {
            for (weight, inverse_row) in source.iter().zip(&qp.bound_rows[..variable_count]) {
                add_scaled(row, *weight, inverse_row);
            }
            *general_length = normalise(row).ok_or(QpError::EmptyRow { row: index })?;
        }
        let bounds = qp.bound_rows.iter_mut().zip(&mut qp.bound_lengths).zip(hessian);
        for (variable, ((row, bound_length), entries)) in bounds.enumerate() {
            // The square of the row's length is (H^-1)_ii.
            let length = normalise(row).ok_or(QpError::IllConditioned { variable })?;
            let diagonal = entries.get(variable).copied().unwrap_or_default();
            if diagonal * length * length > CONDITION_LIMIT {
                return Err(QpError::IllConditioned { variable });
            }
            *bound_length = length;
        }
        Ok(qp)
    }

    /// c = -R^-T f: the minimiser without constraints, in the coordinates w.
    pub(super) fn target(&self, linear: &[f32; N]) -> [f32; N] {
        let mut target = [0.0; N];
        for variable in self.variables() {
            let weight = -linear[variable] * self.bound_lengths[variable];
            let nonzero = target.get_mut(variable..self.variables().end).unwrap_or_default();
            add_scaled(nonzero, weight, self.nonzero_part(variable, &self.bound_rows[variable]));
        }
        target
    }

    /// z = R^-1 w.
    pub(super) fn variables_at(&self, point: &[f32; N]) -> [f32; N] {
        let mut variables = [0.0; N];
        for variable in self.variables() {
            variables[variable] = self.bound_lengths[variable] * self.bound_value(variable, point);
        }
        variables
    }

    /// Indices of the variables in use.
    ///
    /// Never above N, and written so that the compiler sees it: then it leaves no panic behind an index.
    pub(super) fn variables(&self) -> core::ops::Range<usize> {
        0..self.variable_count.min(N)
    }

    /// Indices of the general rows in use; as for [`Self::variables`].
    pub(super) fn rows(&self) -> core::ops::Range<usize> {
        0..self.general_count.min(R)
    }

    /// m'w of a bound's row, of which the entries before the diagonal are zero.
    pub(super) fn bound_value(&self, variable: usize, point: &[f32; N]) -> f32 {
        dot(self.nonzero_part(variable, &self.bound_rows[variable]), self.nonzero_part(variable, point))
    }

    /// What a bound's row multiplies: the entries from its diagonal on.
    fn nonzero_part<'a>(&self, variable: usize, entries: &'a [f32; N]) -> &'a [f32] {
        entries.get(variable..self.variables().end).unwrap_or_default()
    }

    /// m'w of a general row.
    pub(super) fn general_value(&self, row: usize, point: &[f32; N]) -> f32 {
        dot(&self.general_rows[row][self.variables()], &point[self.variables()])
    }
}

/// Sum of products, in index order.
pub(super) fn dot(left: &[f32], right: &[f32]) -> f32 {
    left.iter().zip(right).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// `target` += `weight` * `source`.
pub(super) fn add_scaled(target: &mut [f32], weight: f32, source: &[f32]) {
    for (sum, entry) in target.iter_mut().zip(source) {
        *sum += weight * entry;
    }
}

/// Euclidean length.
pub(super) fn length(vector: &[f32]) -> f32 {
    libm::sqrtf(dot(vector, vector))
}

/// Scales `row` to length 1 and returns the length it had; none if that is no normal number.
fn normalise(row: &mut [f32]) -> Option<f32> {
    let length = length(row);
    if !length.is_normal() {
        return None;
    }
    for entry in row {
        *entry /= length;
    }
    Some(length)
}

/// The upper triangular R with R'R = `hessian`, into zeros. No row is behind the last column, and the compiler sees it:
/// then there is no panic behind an index, and a board may prepare after its start.
fn cholesky<const N: usize>(hessian: &[[f32; N]], factor: &mut [[f32; N]; N]) -> Result<(), QpError> {
    let size = hessian.len().min(N);
    for row in 0..size {
        for column in row..size {
            if hessian[row][column] != hessian[column][row] {
                return Err(QpError::NotSymmetric);
            }
            let mut rest = hessian[row][column];
            for above in &factor[..row] {
                rest -= above[row] * above[column];
            }
            if column > row {
                factor[row][column] = rest / factor[row][row];
            } else if rest > 0.0 {
                factor[row][row] = libm::sqrtf(rest);
            } else {
                return Err(QpError::NotPositiveDefinite { variable: row });
            }
        }
    }
    Ok(())
}

/// The leading part of an upper triangular matrix with a positive diagonal becomes its inverse, by back substitution:
/// the last column first, since each needs the columns before it as they were.
fn invert_upper<const N: usize>(matrix: &mut [[f32; N]; N], size: usize) {
    for column in (0..size.min(N)).rev() {
        matrix[column][column] = 1.0 / matrix[column][column];
        for row in (0..column).rev() {
            let entries = matrix[row];
            let mut sum = 0.0;
            for (entry, inverse_row) in entries.iter().zip(matrix.iter()).take(column + 1).skip(row + 1) {
                sum += entry * inverse_row[column];
            }
            matrix[row][column] = -sum / entries[row];
        }
    }
}
