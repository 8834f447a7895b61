//! Linear least squares by the normal equations, for a handful of columns.

use nalgebra::{SMatrix, SVector};

/// The factors of the columns that come nearest to `measured`, and the root mean square of what is left.
///
/// # Panics
/// The columns depend on each other.
pub fn least_squares<const N: usize>(columns: [&[f64]; N], measured: &[f64]) -> ([f64; N], f64) {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let matrix = SMatrix::<f64, N, N>::from_fn(|i, j| dot(columns[i], columns[j]));
    let right = SVector::<f64, N>::from_fn(|i, _| dot(columns[i], measured));
    let factors = matrix.cholesky().expect("columns that differ").solve(&right);
    let left = dot(measured, measured) - factors.dot(&right);
    (core::array::from_fn(|i| factors[i]), (left.max(0.0) / measured.len() as f64).sqrt())
}
