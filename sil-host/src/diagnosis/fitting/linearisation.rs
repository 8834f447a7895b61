//! Residuals of windows and their slopes: the best start states, and the normal equations of the parameters with these
//! eliminated.

use std::sync::Arc;

use rayon::prelude::*;

use crate::prediction::Channel;
use crate::prediction::start_state::start_factor;
use crate::prediction::windowed_log::Residuals;
use crate::statistics::{Cholesky, dot, dots};

/// Per window: residuals, and their slopes along the start state and the parameters.
pub(in crate::diagnosis) struct Linearisation {
    pub(in crate::diagnosis) windows: Vec<WindowLinear>,
}

impl Linearisation {
    /// The windows with their start states eliminated.
    pub(in crate::diagnosis) fn eliminated(&self) -> Vec<Option<Eliminated<'_>>> {
        self.windows.par_iter().map(WindowLinear::eliminated).collect()
    }

    /// Normal equations window by window.
    pub(in crate::diagnosis) fn normals(&self) -> Vec<Normal> {
        let of = |window: &WindowLinear| {
            window.eliminated().map_or_else(|| Normal::nothing(window.parameters.len()), Eliminated::normal)
        };
        self.windows.par_iter().map(of).collect()
    }

    /// Window by window, the best change of the start state once the parameters have changed by `step`, and the sum of
    /// squares that remains.
    pub(in crate::diagnosis) fn best_starts(&self, step: &[f64]) -> Vec<(Vec<f64>, f64)> {
        self.windows.par_iter().map(|window| window.best_start(step)).collect()
    }

    /// Normal equations over all windows.
    pub(in crate::diagnosis) fn normal(&self) -> Normal {
        Normal::sum(&self.normals())
    }
}

/// Normal equations over all windows with further columns behind the parameters' own, window by window.
pub(in crate::diagnosis) fn normal_beside(windows: &[Option<Eliminated<'_>>], extra: &[Vec<Residuals>]) -> Normal {
    let of = |(window, extra): (&Option<Eliminated<'_>>, &Vec<Residuals>)| Some(window.as_ref()?.beside(extra));
    let normals: Vec<Normal> = windows.par_iter().zip(extra).filter_map(of).collect();
    Normal::sum(&normals)
}

/// One window of it.
#[derive(Clone)]
pub(in crate::diagnosis) struct WindowLinear {
    pub(in crate::diagnosis) residual: Residuals,
    pub(in crate::diagnosis) start: Arc<StartSlopes>,
    pub(in crate::diagnosis) parameters: Vec<Residuals>,
}

/// Slopes of a window's residuals along its start state; several linearisations share them.
pub(in crate::diagnosis) struct StartSlopes {
    slopes: Vec<Residuals>,
    /// None where the window does not determine its start state.
    factor: Option<Cholesky>,
}

impl StartSlopes {
    pub(in crate::diagnosis) fn new(slopes: Vec<Residuals>, free: &[Channel]) -> StartSlopes {
        StartSlopes { factor: start_factor(&slopes, free), slopes }
    }

    /// Inner products with the slopes.
    fn against(&self, column: &Residuals) -> Vec<f64> {
        dots(column, &slices(&self.slopes))
    }
}

/// A window's columns once the start state is eliminated: what serves again beside further columns.
pub(in crate::diagnosis) struct Eliminated<'l> {
    window: &'l WindowLinear,
    factor: &'l Cholesky,
    /// Parts of residual and parameters that the start state takes.
    residual: Vec<f64>,
    parameters: Vec<Vec<f64>>,
    normal: Normal,
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
    /// What a window without information gives.
    pub(in crate::diagnosis) fn nothing(size: usize) -> Normal {
        Normal { matrix: vec![0.0; size * size], right: vec![0.0; size], chi2: 0.0 }
    }

    /// The same once all parameters have moved by a step, to first order, and without some of them.
    pub(in crate::diagnosis) fn after(&self, step: &[f64], without: &[usize]) -> Normal {
        let size = self.right.len();
        let row = |i: usize| &self.matrix[i * size..(i + 1) * size];
        let kept: Vec<usize> = (0..size).filter(|i| !without.contains(i)).collect();
        let right: Vec<f64> = (0..size).map(|i| self.right[i] - dot(row(i), step)).collect();
        Normal {
            matrix: kept.iter().flat_map(|i| kept.iter().map(|j| row(*i)[*j])).collect(),
            chi2: self.chi2 - dot(step, &self.right) - dot(step, &right),
            right: kept.iter().map(|i| right[*i]).collect(),
        }
    }

    /// Those of several windows as one.
    pub(in crate::diagnosis) fn sum<'n>(windows: impl IntoIterator<Item = &'n Normal>) -> Normal {
        let mut windows = windows.into_iter();
        let mut sum = windows.next().map_or_else(|| Normal::nothing(0), Normal::clone);
        for normal in windows {
            sum.matrix.iter_mut().zip(&normal.matrix).for_each(|(sum, value)| *sum += value);
            sum.right.iter_mut().zip(&normal.right).for_each(|(sum, value)| *sum += value);
            sum.chi2 += normal.chi2;
        }
        sum
    }
}

impl WindowLinear {
    /// The same of one.
    fn best_start(&self, step: &[f64]) -> (Vec<f64>, f64) {
        let mut residual = self.residual.clone();
        for (column, by) in self.parameters.iter().zip(step) {
            residual.iter_mut().zip(column).for_each(|(residual, slope)| *residual -= slope * by);
        }
        let Some(factor) = &self.start.factor else {
            return (vec![0.0; self.start.slopes.len()], dot(&residual, &residual));
        };
        let right = self.start.against(&residual);
        let best = factor.solve(&right);
        let chi2 = dot(&residual, &residual) - dot(&right, &best);
        (best, chi2)
    }

    /// The start state eliminated; nothing from a window that does not determine it.
    pub(in crate::diagnosis) fn eliminated(&self) -> Option<Eliminated<'_>> {
        let factor = self.start.factor.as_ref()?;
        let residual = factor.forward(&self.start.against(&self.residual));
        let chi2 = dot(&self.residual, &self.residual) - dot(&residual, &residual);
        let normal = Normal { matrix: Vec::new(), right: Vec::new(), chi2 };
        let alone = Eliminated { window: self, factor, residual, parameters: Vec::new(), normal };
        let (parameters, normal) = alone.with(&[], &self.parameters);
        Some(Eliminated { parameters, normal, ..alone })
    }
}

impl Eliminated<'_> {
    /// Normal equations of the parameters.
    pub(in crate::diagnosis) fn normal(self) -> Normal {
        self.normal
    }

    /// The same with further columns behind the parameters' own.
    pub(in crate::diagnosis) fn beside(&self, extra: &[Residuals]) -> Normal {
        self.with(&self.window.parameters, extra).1
    }

    /// What the start state takes of further columns, and the normal equations of all; `own` are those that are in
    /// already.
    fn with(&self, own: &[Residuals], extra: &[Residuals]) -> (Vec<Vec<f64>>, Normal) {
        let (before, size) = (own.len(), own.len() + extra.len());
        let columns: Vec<&[f64]> = own.iter().chain(extra).map(Vec::as_slice).collect();
        let taken: Vec<Vec<f64>> =
            extra.iter().map(|column| self.factor.forward(&self.window.start.against(column))).collect();
        let all: Vec<&Vec<f64>> = self.parameters.iter().chain(&taken).collect();
        let mut matrix = vec![0.0; size * size];
        for i in 0..before {
            matrix[i * size..i * size + before].copy_from_slice(&self.normal.matrix[i * before..(i + 1) * before]);
        }
        let mut right = self.normal.right.clone();
        for i in before..size {
            let products = dots(columns[i], &columns[..=i]);
            for (j, product) in products.into_iter().enumerate() {
                let value = product - dot(all[i], all[j]);
                (matrix[i * size + j], matrix[j * size + i]) = (value, value);
            }
            right.push(dot(columns[i], &self.window.residual) - dot(all[i], &self.residual));
        }
        (taken, Normal { matrix, right, chi2: self.normal.chi2 })
    }
}

fn slices(columns: &[Residuals]) -> Vec<&[f64]> {
    columns.iter().map(Vec::as_slice).collect()
}
