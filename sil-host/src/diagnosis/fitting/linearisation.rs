//! Residuals of windows and their slopes: the best start states, and the normal equations of the parameters with these
//! eliminated.

use crate::prediction::Channel;
use crate::prediction::start_state::{slope, start_factor};
use crate::prediction::windowed_log::Residuals;
use crate::statistics::dot;

/// Per window: residuals, and their slopes along the start state and the parameters.
pub(in crate::diagnosis) struct Linearisation {
    pub(in crate::diagnosis) windows: Vec<WindowLinear>,
}

/// One window of it.
pub(in crate::diagnosis) struct WindowLinear {
    pub(in crate::diagnosis) residual: Residuals,
    pub(in crate::diagnosis) start: Vec<Residuals>,
    pub(in crate::diagnosis) parameters: Vec<Residuals>,
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

impl Normal {
    /// Those of several windows as one.
    pub(in crate::diagnosis) fn sum(windows: &[Normal]) -> Normal {
        let size = windows.first().map_or(0, |normal| normal.right.len());
        let mut sum = Normal { matrix: vec![0.0; size * size], right: vec![0.0; size], chi2: 0.0 };
        for normal in windows {
            sum.matrix.iter_mut().zip(&normal.matrix).for_each(|(sum, value)| *sum += value);
            sum.right.iter_mut().zip(&normal.right).for_each(|(sum, value)| *sum += value);
            sum.chi2 += normal.chi2;
        }
        sum
    }
}

impl WindowLinear {
    /// The best change of the start state once the parameters have changed by `step`, and the sum of squares that
    /// remains.
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

    pub(in crate::diagnosis) fn reduced(&self, extra: &[Residuals], free: &[Channel]) -> Normal {
        let columns: Vec<&Residuals> = self.parameters.iter().chain(extra).collect();
        let size = columns.len();
        let against = |column: &Residuals| -> Vec<f64> { self.start.iter().map(|start| dot(start, column)).collect() };
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

/// How a prediction changes with a parameter: minus the change of the residual.
pub(in crate::diagnosis) fn slopes(residual: &[Residuals], shifted: Vec<Residuals>, step: f64) -> Vec<Residuals> {
    residual.iter().zip(shifted).map(|(base, shifted)| slope(base, shifted, step)).collect()
}

/// From column by column to window by window.
pub(in crate::diagnosis) fn turned(columns: Vec<Vec<Residuals>>, windows: usize) -> Vec<Vec<Residuals>> {
    let mut turned: Vec<Vec<Residuals>> = (0..windows).map(|_| Vec::with_capacity(columns.len())).collect();
    for column in columns {
        for (window, part) in turned.iter_mut().zip(column) {
            window.push(part);
        }
    }
    turned
}
