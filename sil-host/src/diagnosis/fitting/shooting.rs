//! Residuals of a log's windows as least squares take them, each window with a start state of its own, and their normal
//! equations.
//!
//! A window's start state is unknown and is estimated along with the parameters, from the window itself (multiple
//! shooting). Under the method's assumption, white sensor noise and commands that are known, the residuals of a true
//! model are white, in a closed loop too: given its start the motion is a function of known commands, and a sample's
//! noise reaches later commands only.

use std::f64::consts::TAU;
use std::sync::Arc;

use rayon::prelude::*;

use crate::axis::Axis;
use crate::diagnosis::fitting::axis_filter::{AxisFilter, AxisNoise, Lasting, filters, lasting};
use crate::diagnosis::fitting::carried_noise::CarriedNoise;
use crate::diagnosis::fitting::linearisation::{Linearisation, StartSlopes, WindowLinear};
use crate::diagnosis::fitting::shifted::{Moved, Shifted};
use crate::prediction::body::State;
use crate::prediction::windowed_log::{Driven, Residuals, WindowedLog};
use crate::prediction::{Channel, Window};

/// A log and the noise that its fit assumes.
pub(in crate::diagnosis) struct Shooting<'a> {
    pub(in crate::diagnosis) log: WindowedLog<'a>,
    /// Noise of each axis as innovations count it.
    pub(in crate::diagnosis) noise: [AxisNoise; 3],
    /// Noise of the channels that show forces, beyond their sensors'; none where those are all.
    pub(in crate::diagnosis) carried: Vec<CarriedNoise>,
    /// Per window, what makes innovations of its residuals.
    filters: Vec<Vec<(Axis, AxisFilter)>>,
}

impl<'a> Shooting<'a> {
    /// No more noise than the sensors'.
    pub(in crate::diagnosis) fn new(log: WindowedLog<'a>) -> Shooting<'a> {
        let noise = [AxisNoise::SENSORS; 3];
        Shooting { filters: filters(&log, &noise), log, noise, carried: Vec::new() }
    }

    /// The same, with more noise than the sensors': of moments, and of forces.
    pub(in crate::diagnosis) fn with_noise(self, noise: [AxisNoise; 3], carried: Vec<CarriedNoise>) -> Shooting<'a> {
        Shooting { filters: filters(&self.log, &noise), noise, carried, ..self }
    }

    /// What makes innovations of a window and of the rows that show its start, about axes under a disturbance that
    /// lasts.
    pub(in crate::diagnosis) fn lasting(&self, window: &Window) -> Vec<(Axis, AxisFilter)> {
        lasting(&self.log, &self.noise, window)
    }

    /// The disturbance that lasts about an axis; none where none does.
    pub(in crate::diagnosis) fn lasting_about(&self, axis: Axis) -> Option<Lasting> {
        Some(self.noise[axis.index()].lasting).filter(|lasting| lasting.std_rad_s2 > 0.0)
    }

    /// Does one last about any axis?
    pub(in crate::diagnosis) fn is_disturbed(&self) -> bool {
        Axis::ALL.into_iter().any(|axis| self.lasting_about(axis).is_some())
    }

    /// Innovations of one of the log's windows: residuals as least squares take them.
    pub(super) fn innovations(&self, driven: &Driven, window: &Window, start: &State) -> Residuals {
        let mut residual = self.log.residual(driven, window, start);
        self.unwind(window, &mut residual);
        for (axis, filter) in &self.filters[window.index] {
            filter.innovate(&mut residual, &self.log.restoring(driven, window, *axis));
        }
        self.whiten(window, &mut residual);
        residual
    }

    /// An angle's residual is known but for whole turns, and changes by less than half of one from row to row. Under a
    /// disturbance that its commands answer a prediction may be off by more before a window ends.
    pub(super) fn unwind(&self, window: &Window, residual: &mut [f64]) {
        let rows = window.end - window.start;
        for (place, (channel, sigma)) in self.log.compared().enumerate() {
            if !matches!(channel, Channel::Angle(_)) {
                continue;
            }
            let (own, turn) = (&mut residual[place * rows..(place + 1) * rows], TAU / sigma);
            for row in 1..rows {
                let turns = (own[row] - own[row - 1]) / turn;
                if turns.abs() >= 0.5 {
                    own[row] -= turn * turns.round();
                }
            }
        }
    }

    /// Residuals and slopes of some windows. `shifted` are models that differ from `base` by steps of its numbers. The
    /// slopes along the start states may come from a linearisation nearby: over half a second they hardly change with
    /// the parameters, and whatever they are, the fit ends where the residuals do not fall any more.
    pub(in crate::diagnosis) fn linearise(
        &self,
        base: &Driven,
        shifted: &[Shifted],
        which: &[usize],
        starts: &[State],
        nearby: Option<&Linearisation>,
    ) -> Linearisation {
        let one = |(place, index): (usize, &usize)| {
            let (window, start) = (&self.log.windows[*index], &starts[*index]);
            let (residual, slopes) = match nearby {
                Some(nearby) => (self.innovations(base, window, start), Arc::clone(&nearby.windows[place].start)),
                None => {
                    let (residual, slopes) = self.innovation_slopes(base, window, start);
                    (residual, Arc::new(StartSlopes::new(slopes, &self.log.free_at_start)))
                }
            };
            let parameters = self.window_slopes(&residual, shifted, window, start);
            WindowLinear { residual, start: slopes, parameters }
        };
        Linearisation { windows: which.par_iter().enumerate().map(one).collect() }
    }

    /// Slopes of some windows along more parameters, the rest taken from a linearisation at the same values.
    pub(in crate::diagnosis) fn slopes_of(
        &self,
        linear: &Linearisation,
        shifted: &[Shifted],
        which: &[usize],
        starts: &[State],
    ) -> Vec<Vec<Residuals>> {
        let one = |(index, linear): (&usize, &WindowLinear)| {
            self.window_slopes(&linear.residual, shifted, &self.log.windows[*index], &starts[*index])
        };
        which.par_iter().zip(&linear.windows).map(one).collect()
    }

    /// Slopes of one window, number by number in their order.
    fn window_slopes(
        &self,
        residual: &Residuals,
        shifted: &[Shifted],
        window: &Window,
        start: &State,
    ) -> Vec<Residuals> {
        let mut slopes = vec![Residuals::new(); shifted.iter().map(|shifted| shifted.numbers.len()).sum()];
        for Shifted { driven, numbers } in shifted {
            let moved = self.innovations(driven, window, start);
            for Moved { place, step, axis } in numbers {
                slopes[*place] = self.log.slope(residual, &moved, *step, *axis);
            }
        }
        slopes
    }

    /// The best start states of some windows under a model, from given ones on, and the sum of squares that remains per
    /// window.
    pub(in crate::diagnosis) fn settle(&self, driven: &Driven, which: &[usize], starts: &mut [State]) -> Vec<f64> {
        let mut left = Vec::new();
        let mut nearby = None;
        for _ in 0..2 {
            let linear = self.linearise(driven, &[], which, starts, nearby.as_ref());
            left.clear();
            for (index, (step, chi2)) in which.iter().zip(linear.best_starts(&[])) {
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
        for (index, (start_step, _)) in which.iter().zip(linear.best_starts(step)) {
            self.log.move_start(&mut starts[*index], &start_step);
        }
    }

    /// Samples of some windows, less what their start states take.
    pub(in crate::diagnosis) fn degrees_of_freedom(&self, which: &[usize]) -> f64 {
        let rows: usize = which.iter().map(|index| self.log.windows[*index].end - self.log.windows[*index].start).sum();
        (rows * self.log.compared().count()) as f64 - (which.len() * self.log.free_at_start.len()) as f64
    }
}
