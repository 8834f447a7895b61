//! Residuals of a log's windows as least squares take them, each window with a start state of its own, and their normal
//! equations.
//!
//! A window's start state is unknown and is estimated along with the parameters, from the window itself (multiple
//! shooting). Under the method's assumption, white sensor noise and commands that are known, the residuals of a true
//! model are white, in a closed loop too: given its start the motion is a function of known commands, and a sample's
//! noise reaches later commands only.

use rayon::prelude::*;

use crate::diagnosis::fitting::carried_noise::CarriedNoise;
use crate::diagnosis::fitting::linearisation::{Linearisation, Normal, WindowLinear, slopes, turned};
use crate::diagnosis::fitting::process_noise::AxisNoise;
use crate::prediction::body::State;
use crate::prediction::start_state::START_STEP;
use crate::prediction::windowed_log::{Driven, Residuals, WindowedLog};
use crate::prediction::{Channel, Window};

/// A log and the noise that its fit assumes.
pub(in crate::diagnosis) struct Shooting<'a> {
    pub(in crate::diagnosis) log: WindowedLog<'a>,
    /// Noise of each axis as innovations count it.
    pub(in crate::diagnosis) noise: [AxisNoise; 3],
    /// Noise of the channels that show forces, beyond their sensors'; none where those are all.
    pub(in crate::diagnosis) carried: Vec<CarriedNoise>,
}

impl<'a> Shooting<'a> {
    /// No more noise than the sensors'.
    pub(in crate::diagnosis) fn new(log: WindowedLog<'a>) -> Shooting<'a> {
        Shooting { log, noise: [AxisNoise::SENSORS; 3], carried: Vec::new() }
    }

    /// The same, with more noise than the sensors': of moments, and of forces.
    pub(in crate::diagnosis) fn with_noise(self, noise: [AxisNoise; 3], carried: Vec<CarriedNoise>) -> Shooting<'a> {
        Shooting { noise, carried, ..self }
    }

    /// Innovations of one window: residuals as least squares take them.
    pub(super) fn innovations(&self, driven: &Driven, window: &Window, start: &State) -> Residuals {
        let mut residual = self.log.residual(driven, window, start);
        self.innovate(window, &mut residual);
        self.whiten(window, &mut residual);
        residual
    }

    /// Innovations of some windows.
    fn residuals(&self, driven: &Driven, which: &[usize], starts: &[State], shift: Option<Channel>) -> Vec<Residuals> {
        let one = |index: &usize| {
            let mut start = starts[*index];
            if let Some(value) = shift.and_then(|channel| channel.of_state(&mut start)) {
                *value += START_STEP;
            }
            self.innovations(driven, &self.log.windows[*index], &start)
        };
        which.par_iter().map(one).collect()
    }

    /// Residuals and slopes of some windows. `shifted` are models that differ from `base` in one parameter each, by a
    /// step. The slopes along the start states may come from a linearisation nearby: over half a second they hardly
    /// change with the parameters, and whatever they are, the fit ends where the residuals do not fall any more.
    pub(in crate::diagnosis) fn linearise(
        &self,
        base: &Driven,
        shifted: &[(Driven, f64)],
        which: &[usize],
        starts: &[State],
        nearby: Option<&Linearisation>,
    ) -> Linearisation {
        let residual = self.residuals(base, which, starts, None);
        let start: Vec<Vec<Residuals>> = match nearby {
            Some(nearby) => nearby.windows.iter().map(|window| window.start.clone()).collect(),
            None => {
                let along = |free: &Channel| match self.log.moves_alone(base, *free) {
                    true => which.iter().map(|index| self.log.moved_alone(&self.log.windows[*index], *free)).collect(),
                    false => slopes(&residual, self.residuals(base, which, starts, Some(*free)), START_STEP),
                };
                turned(self.log.free_at_start.iter().map(along).collect(), which.len())
            }
        };
        let parameters: Vec<Vec<Residuals>> = shifted
            .iter()
            .map(|(driven, step)| slopes(&residual, self.residuals(driven, which, starts, None), *step))
            .collect();
        let (mut start, mut parameters) = (start, turned(parameters, which.len()));
        let windows = residual
            .into_iter()
            .enumerate()
            .map(|(i, residual)| WindowLinear {
                residual,
                start: std::mem::take(&mut start[i]),
                parameters: std::mem::take(&mut parameters[i]),
            })
            .collect();
        Linearisation { windows }
    }

    /// Slopes along more parameters, the rest taken from a linearisation at the same values.
    pub(in crate::diagnosis) fn slopes_of(
        &self,
        linear: &Linearisation,
        shifted: &[(Driven, f64)],
        which: &[usize],
        starts: &[State],
    ) -> Vec<Vec<Residuals>> {
        let residual: Vec<Residuals> = linear.windows.iter().map(|window| window.residual.clone()).collect();
        let parameters = shifted
            .iter()
            .map(|(driven, step)| slopes(&residual, self.residuals(driven, which, starts, None), *step))
            .collect();
        turned(parameters, which.len())
    }

    /// The best start states of some windows under a model, from given ones on, and the sum of squares that remains per
    /// window.
    pub(in crate::diagnosis) fn settle(&self, driven: &Driven, which: &[usize], starts: &mut [State]) -> Vec<f64> {
        let mut left = Vec::new();
        let mut nearby = None;
        for _ in 0..2 {
            let linear = self.linearise(driven, &[], which, starts, nearby.as_ref());
            left.clear();
            for (index, window) in which.iter().zip(&linear.windows) {
                let (step, chi2) = window.best_start(&[], &self.log.free_at_start);
                self.log.move_start(&mut starts[*index], &step);
                left.push(chi2);
            }
            nearby = Some(linear);
        }
        left
    }

    /// Moves the start states along with a step of the parameters.
    pub(in crate::diagnosis) fn move_starts(
        &self,
        linear: &Linearisation,
        step: &[f64],
        which: &[usize],
        starts: &mut [State],
    ) {
        for (index, window) in which.iter().zip(&linear.windows) {
            let (start_step, _) = window.best_start(step, &self.log.free_at_start);
            self.log.move_start(&mut starts[*index], &start_step);
        }
    }

    /// Normal equations over all windows of a linearisation, with `extra` columns behind the parameters' own.
    pub(in crate::diagnosis) fn normal(&self, linear: &Linearisation, extra: Option<&[Vec<Residuals>]>) -> Normal {
        Normal::sum(&self.normals(linear, extra))
    }

    /// The same window by window.
    pub(in crate::diagnosis) fn normals(
        &self,
        linear: &Linearisation,
        extra: Option<&[Vec<Residuals>]>,
    ) -> Vec<Normal> {
        let of = |(i, window): (usize, &WindowLinear)| {
            let more = extra.map_or(&[][..], |extra| &extra[i]);
            window.reduced(more, &self.log.free_at_start)
        };
        linear.windows.par_iter().enumerate().map(of).collect()
    }

    /// Samples of some windows, less what their start states take.
    pub(in crate::diagnosis) fn degrees_of_freedom(&self, which: &[usize]) -> f64 {
        let rows: usize = which.iter().map(|index| self.log.windows[*index].end - self.log.windows[*index].start).sum();
        (rows * self.log.compared().count()) as f64 - (which.len() * self.log.free_at_start.len()) as f64
    }
}
