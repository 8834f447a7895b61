//! Residuals of windows and their slopes: the best start states, and the normal equations of the parameters with these eliminated.

use crate::diagnosis::fitting::linear::{Cholesky, dot};
use crate::prediction::Channel;

/// Residuals of one window, or their change with a parameter.
pub(in crate::diagnosis) type Column = Vec<f64>;

/// Per window: residuals, and their slopes along the start state and the parameters.
pub(in crate::diagnosis) struct Linearisation {
    pub(in crate::diagnosis) windows: Vec<WindowLinear>,
}

/// One window of it.
pub(in crate::diagnosis) struct WindowLinear {
    pub(in crate::diagnosis) residual: Column,
    pub(in crate::diagnosis) start: Vec<Column>,
    pub(in crate::diagnosis) parameters: Vec<Column>,
}

/// Normal equations of the parameters, the start states eliminated.
#[derive(Clone, Debug)]
pub(in crate::diagnosis) struct Normal {
    /// Rows one behind the other.
    pub(in crate::diagnosis) matrix: Vec<f64>,
    pub(in crate::diagnosis) right: Vec<f64>,
    /// Sum of squares that the best start states leave at the present parameters.
    pub(in crate::diagnosis) chi2: f64,
}

impl WindowLinear {
    /// The best change of the start state once the parameters have changed by `step`, and the sum of squares that is left.
    pub(in crate::diagnosis) fn best_start(&self, step: &[f64], free: &[Channel]) -> (Vec<f64>, f64) {
        let mut residual = self.residual.clone();
        for (column, by) in self.parameters.iter().zip(step) {
            residual.iter_mut().zip(column).for_each(|(residual, slope)| *residual -= slope * by);
        }
        let right: Vec<f64> = self.start.iter().map(|column| dot(column, &residual)).collect();
        let Some(factor) = start_factor(&self.start, free) else {
            return (vec![0.0; free.len()], dot(&residual, &residual));
        };
        let best = factor.solve(&right);
        let chi2 = dot(&residual, &residual) - dot(&right, &best);
        (best, chi2)
    }

    pub(in crate::diagnosis) fn reduced(&self, extra: &[Column], free: &[Channel]) -> Normal {
        let columns: Vec<&Column> = self.parameters.iter().chain(extra).collect();
        let size = columns.len();
        let against = |column: &Column| -> Vec<f64> { self.start.iter().map(|start| dot(start, column)).collect() };
        let Some(factor) = start_factor(&self.start, free) else {
            return Normal { matrix: vec![0.0; size * size], right: vec![0.0; size], chi2: 0.0 };
        };
        let residual = factor.forward(&against(&self.residual));
        let projected: Vec<Vec<f64>> = columns.iter().map(|column| factor.forward(&against(column))).collect();
        let mut matrix = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                let value = dot(columns[i], columns[j]) - dot(&projected[i], &projected[j]);
                (matrix[i * size + j], matrix[j * size + i]) = (value, value);
            }
        }
        let right = columns
            .iter()
            .zip(&projected)
            .map(|(column, projected)| dot(column, &self.residual) - dot(projected, &residual))
            .collect();
        Normal { matrix, right, chi2: dot(&self.residual, &self.residual) - dot(&residual, &residual) }
    }
}

/// Normal equations of a start state with these free components, factored; `slopes` are theirs.
pub(in crate::diagnosis) fn start_factor(slopes: &[Column], free: &[Channel]) -> Option<Cholesky> {
    let size = slopes.len();
    let mut matrix = vec![0.0; size * size];
    for i in 0..size {
        for j in 0..size {
            matrix[i * size + j] = dot(&slopes[i], &slopes[j]);
        }
        // free in so far as this is far beyond any error of a measured start
        let prior = free[i].start_range();
        matrix[i * size + i] += 1.0 / (prior * prior);
    }
    Cholesky::new(&matrix, size)
}

/// How a prediction changes with a parameter: minus the change of the residual.
pub(in crate::diagnosis) fn slopes(residual: &[Column], shifted: Vec<Column>, step: f64) -> Vec<Column> {
    residual.iter().zip(shifted).map(|(base, shifted)| slope(base, shifted, step)).collect()
}

pub(in crate::diagnosis) fn slope(base: &Column, mut shifted: Column, step: f64) -> Column {
    shifted.iter_mut().zip(base).for_each(|(shifted, base)| *shifted = (base - *shifted) / step);
    shifted
}

/// From column by column to window by window.
pub(in crate::diagnosis) fn turned(columns: Vec<Vec<Column>>, windows: usize) -> Vec<Vec<Column>> {
    let mut turned: Vec<Vec<Column>> = (0..windows).map(|_| Vec::with_capacity(columns.len())).collect();
    for column in columns {
        for (window, part) in turned.iter_mut().zip(column) {
            window.push(part);
        }
    }
    turned
}
