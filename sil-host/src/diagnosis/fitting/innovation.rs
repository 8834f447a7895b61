//! A log's residuals as innovations, where there is noise beyond the sensors': that of commands lost between rows
//! (`sampling`), or of disturbances (`process_noise`). What each row adds to what the rows before it have shown of the
//! motion's departure from the prediction is white and of unit variance under the model's own noise, as plain residuals
//! are where the forces are known; and being linear in the residuals innovations serve the same least squares (Ljung,
//! System Identification, 2nd ed., 7.2).

use crate::axis::Axis;
use crate::diagnosis::fitting::axis_filter::{AxisNoise, passage};
use crate::diagnosis::fitting::carried_noise::CarriedNoise;
use crate::diagnosis::fitting::process_noise::{AxisWindow, Disturbance, most_likely, unlikeliness};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::prediction::Window;
use crate::prediction::body::State;
use crate::prediction::windowed_log::{Driven, Residuals};

impl Shooting<'_> {
    /// Innovations of one window and their slopes along its start state.
    pub(in crate::diagnosis) fn innovation_slopes(
        &self,
        driven: &Driven,
        window: &Window,
        start: &State,
    ) -> (Residuals, Vec<Residuals>) {
        self.log.slopes_along_start(driven, window, start, |start| self.innovations(driven, window, start))
    }

    /// The noise of the forces under which what a model leaves is most likely.
    pub(in crate::diagnosis) fn carried_noise(
        &self,
        driven: &Driven,
        which: &[usize],
        starts: &[State],
    ) -> Vec<CarriedNoise> {
        let left = |index: &usize| self.log.residual(driven, &self.log.windows[*index], &starts[*index]);
        let residuals: Vec<Vec<f64>> = which.iter().map(left).collect();
        let channels = self.log.compared().enumerate().filter(|(_, (channel, _))| channel.turning_axis().is_none());
        let of = |(channel, _): (usize, _)| {
            let mut windows: Vec<&[f64]> = Vec::new();
            for (residual, index) in residuals.iter().zip(which) {
                let rows = self.log.windows[*index].end - self.log.windows[*index].start;
                windows.push(&residual[channel * rows..(channel + 1) * rows]);
            }
            CarriedNoise::of(channel, &windows)
        };
        channels.map(of).collect()
    }

    /// Whitens the channels of a window that have such noise.
    pub(in crate::diagnosis) fn whiten(&self, window: &Window, residual: &mut [f64]) {
        let rows = window.end - window.start;
        for noise in &self.carried {
            noise.whiten(&mut residual[noise.channel * rows..(noise.channel + 1) * rows]);
        }
    }

    /// Under which noise what a model leaves is most likely, per axis.
    pub(in crate::diagnosis) fn most_likely_noise(
        &self,
        driven: &Driven,
        which: &[usize],
        starts: &[State],
        may_be: Disturbance,
    ) -> [AxisNoise; 3] {
        // about yaw a vehicle also turns while its rotors gain speed, at once and by more than their drag does later:
        // with all that is slow left to a disturbance that would pass for what the command does
        let may_be = [may_be, may_be, Disturbance::White];
        let axes = self.axis_windows(driven, which, starts);
        [0, 1, 2].map(|axis| most_likely(&axes[axis], AxisNoise::SENSORS.lost, may_be[axis]))
    }

    /// Twice the negative logarithm of the likelihood of what a model leaves of some windows, start states quite free,
    /// up to a constant of the log; with that share of what lost commands leave unknown, of some, that makes it
    /// likeliest.
    pub(in crate::diagnosis) fn unlikeliness(
        &self,
        driven: &Driven,
        which: &[usize],
        starts: &[State],
        shares: &[f64],
    ) -> f64 {
        let axes = self.axis_windows(driven, which, starts);
        let under = |share: &f64| {
            let of_axis = |(windows, noise): (&Vec<AxisWindow<'_>>, &AxisNoise)| -> f64 {
                let noise = AxisNoise { lost: *share, ..*noise };
                windows.iter().map(|window| unlikeliness(window, &noise)).sum()
            };
            axes.iter().zip(&self.noise).map(of_axis).sum()
        };
        shares.iter().map(under).fold(f64::INFINITY, f64::min)
    }

    /// The same under the disturbance that makes it likeliest.
    pub(in crate::diagnosis) fn least_unlikeliness(
        &self,
        driven: &Driven,
        which: &[usize],
        starts: &[State],
        shares: &[f64],
    ) -> f64 {
        let of_axis = |windows: &Vec<AxisWindow<'_>>| -> f64 {
            // a disturbance can stand in for lost commands, but not the other way round
            let disturbed = most_likely(windows, 0.0, Disturbance::White);
            let under = |share: &f64| -> f64 {
                let noise = AxisNoise { lost: *share, ..disturbed };
                windows.iter().map(|window| unlikeliness(window, &noise)).sum()
            };
            shares.iter().map(under).fold(f64::INFINITY, f64::min)
        };
        self.axis_windows(driven, which, starts).iter().map(of_axis).sum()
    }

    /// What a model leaves of some windows, axis by axis.
    fn axis_windows(&self, driven: &Driven, which: &[usize], starts: &[State]) -> [Vec<AxisWindow<'_>>; 3] {
        let left_of = |index: &usize| {
            let window = &self.log.windows[*index];
            let (mut residual, slopes) = self.log.start_slopes(driven, window, &starts[*index]);
            self.unwind(window, &mut residual);
            (residual, slopes)
        };
        let left: Vec<(Residuals, Vec<Residuals>)> = which.iter().map(left_of).collect();
        Axis::ALL.map(|axis| {
            let window = |(index, (residual, slopes)): (&usize, &(Residuals, Vec<Residuals>))| {
                let window = &self.log.windows[*index];
                let mut passage = passage(&self.log, axis, window);
                let rows = passage.time_s.len();
                let mut shown: Vec<usize> = passage.seen.iter().flatten().map(|(channel, _)| *channel).collect();
                shown.sort_unstable();
                shown.dedup();
                for (channel, _) in passage.seen.iter_mut().flatten() {
                    *channel = shown.partition_point(|shown| shown < channel);
                }
                let own = |column: &Residuals| -> Residuals {
                    shown.iter().flat_map(|channel| &column[channel * rows..(channel + 1) * rows]).copied().collect()
                };
                let restoring = self.log.restoring(driven, window, axis);
                AxisWindow { passage, restoring, residual: own(residual), slopes: slopes.iter().map(own).collect() }
            };
            which.iter().zip(&left).map(window).collect()
        })
    }
}
