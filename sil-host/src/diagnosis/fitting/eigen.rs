//! Eigenvalues of a small symmetric matrix: Jacobi's rotations (Golub and Van Loan, Matrix Computations, 4th ed.,
//! section 8.5), in a fixed order.

/// Rounds over all pairs; each at least squares what remains off the diagonal.
const SWEEPS: usize = 30;

/// Eigenvalues in ascending order, each with its vector of length one; rows of the matrix one behind the other.
pub(in crate::diagnosis) fn symmetric(matrix: &[f64], size: usize) -> Vec<(f64, Vec<f64>)> {
    let mut a = matrix.to_vec();
    let mut vectors: Vec<Vec<f64>> =
        (0..size).map(|i| (0..size).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..SWEEPS {
        for p in 0..size {
            for q in p + 1..size {
                rotate(&mut a, &mut vectors, size, p, q);
            }
        }
    }
    let mut eigen: Vec<(f64, Vec<f64>)> = vectors.into_iter().enumerate().map(|(i, v)| (a[i * size + i], v)).collect();
    eigen.sort_by(|x, y| x.0.total_cmp(&y.0));
    eigen
}

/// Makes the entry of p and q zero.
fn rotate(a: &mut [f64], vectors: &mut [Vec<f64>], size: usize, p: usize, q: usize) {
    let off = a[p * size + q];
    if off == 0.0 || !off.is_finite() {
        return;
    }
    let half = 0.5 * (a[q * size + q] - a[p * size + p]) / off;
    let tangent = half.signum() / (half.abs() + libm::hypot(half, 1.0));
    let cos = 1.0 / libm::hypot(tangent, 1.0);
    let sin = tangent * cos;
    for k in 0..size {
        let (kp, kq) = (a[k * size + p], a[k * size + q]);
        (a[k * size + p], a[k * size + q]) = (cos * kp - sin * kq, sin * kp + cos * kq);
    }
    for k in 0..size {
        let (pk, qk) = (a[p * size + k], a[q * size + k]);
        (a[p * size + k], a[q * size + k]) = (cos * pk - sin * qk, sin * pk + cos * qk);
    }
    let (before, from_q) = vectors.split_at_mut(q);
    for (of_p, of_q) in before[p].iter_mut().zip(&mut from_q[0]) {
        (*of_p, *of_q) = (cos * *of_p - sin * *of_q, sin * *of_p + cos * *of_q);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_difference_has_the_eigenvalues_of_a_string() {
        // tridiagonal (-1, 2, -1) of size 5: 2 - 2 cos(k pi / 6)
        let size = 5;
        let entry = |i: usize, j: usize| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
        let matrix: Vec<f64> = (0..25).map(|k| entry(k / size, k % size)).collect();
        for (k, (value, vector)) in (1..).zip(symmetric(&matrix, size)) {
            let expected = 2.0 - 2.0 * libm::cos(core::f64::consts::PI * f64::from(k) / 6.0);
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
            for i in 0..size {
                let product: f64 = (0..size).map(|j| entry(i, j) * vector[j]).sum();
                assert!((product - value * vector[i]).abs() < 1e-13);
            }
        }
    }
}
