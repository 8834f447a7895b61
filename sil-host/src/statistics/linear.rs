//! Small symmetric positive definite systems, row by row in a fixed order: the same bits on every machine.

/// Lower triangle of a symmetric matrix and its Cholesky factor.
#[derive(Clone, Debug)]
pub(crate) struct Cholesky {
    size: usize,
    factor: Vec<f64>,
}

impl Cholesky {
    /// Factors a symmetric matrix (rows one behind the other); `None` if it is not positive definite.
    pub(crate) fn new(matrix: &[f64], size: usize) -> Option<Cholesky> {
        let mut factor = matrix.to_vec();
        for i in 0..size {
            for j in 0..=i {
                let mut sum = factor[i * size + j];
                for k in 0..j {
                    sum -= factor[i * size + k] * factor[j * size + k];
                }
                if i != j {
                    factor[i * size + j] = sum / factor[j * size + j];
                } else if sum > 0.0 && sum.is_finite() {
                    factor[i * size + i] = sum.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(Cholesky { size, factor })
    }

    /// `L^-1 b`.
    pub(crate) fn forward(&self, b: &[f64]) -> Vec<f64> {
        let mut y = b.to_vec();
        for i in 0..self.size {
            for k in 0..i {
                y[i] -= self.factor[i * self.size + k] * y[k];
            }
            y[i] /= self.factor[i * self.size + i];
        }
        y
    }

    /// `L^-T y`.
    pub(crate) fn backward(&self, y: &[f64]) -> Vec<f64> {
        let mut x = y.to_vec();
        for i in (0..self.size).rev() {
            for k in i + 1..self.size {
                x[i] -= self.factor[k * self.size + i] * x[k];
            }
            x[i] /= self.factor[i * self.size + i];
        }
        x
    }

    /// Solution of `A x = b`.
    pub(crate) fn solve(&self, b: &[f64]) -> Vec<f64> {
        self.backward(&self.forward(b))
    }

    /// The inverse, rows one behind the other.
    pub(crate) fn inverse(&self) -> Vec<f64> {
        let mut inverse = vec![0.0; self.size * self.size];
        for j in 0..self.size {
            let mut unit = vec![0.0; self.size];
            unit[j] = 1.0;
            for (i, value) in self.solve(&unit).into_iter().enumerate() {
                inverse[i * self.size + j] = value;
            }
        }
        inverse
    }
}

/// Inner product.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inner products with several vectors of the same length, each summed in the order of [`dot`]: side by side none of
/// them waits for its own last sum.
pub(crate) fn dots(a: &[f64], others: &[&[f64]]) -> Vec<f64> {
    let mut products = Vec::with_capacity(others.len());
    let mut fours = others.chunks_exact(4);
    for four in &mut fours {
        let [b, c, d, e] = [four[0], four[1], four[2], four[3]];
        let mut sums = [-0.0; 4];
        for ((((a, b), c), d), e) in a.iter().zip(b).zip(c).zip(d).zip(e) {
            sums = [sums[0] + a * b, sums[1] + a * c, sums[2] + a * d, sums[3] + a * e];
        }
        products.extend(sums);
    }
    products.extend(fours.remainder().iter().map(|b| dot(a, b)));
    products
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_side_by_side_are_those_of_one_by_one_to_the_bit() {
        let column = |k: usize| -> Vec<f64> { (0..50).map(|i| libm::sin((1 + i * (k + 3)) as f64) * 1e3).collect() };
        let columns: Vec<Vec<f64>> = (0..11).map(column).collect();
        let others: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let one_by_one: Vec<f64> = others.iter().map(|other| dot(&columns[5], other)).collect();
        assert_eq!(dots(&columns[5], &others), one_by_one);
    }

    #[test]
    fn a_systems_inverse_solves_it() {
        let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0];
        let factor = Cholesky::new(&matrix, 3).unwrap();
        let solution = factor.solve(&[1.0, 2.0, 3.0]);
        for (row, right) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            let left = dot(&matrix[3 * row..3 * row + 3], &solution);
            assert!((left - right).abs() < 1e-14);
        }
        let inverse = factor.inverse();
        assert!((dot(&matrix[..3], &[inverse[0], inverse[3], inverse[6]]) - 1.0).abs() < 1e-14);
        assert!(Cholesky::new(&[1.0, 2.0, 2.0, 1.0], 2).is_none());
    }
}
