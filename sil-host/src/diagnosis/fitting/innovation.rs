//! A log's residuals as innovations, where there is noise beyond the sensors': that of commands lost between rows (`sampling`), or of
//! disturbances (`process_noise`). What each row adds to what the rows before it have told of the motion's departure from the prediction is white
//! and of unit variance under the model's own noise, as plain residuals are where the forces are known; and being linear in the
//! residuals innovations serve the same least squares (Ljung, System Identification, 2nd ed., 7.2).

use crate::axis::Axis;
use crate::diagnosis::fitting::linearisation::Column;
use crate::diagnosis::fitting::process_noise::{AxisNoise, AxisWindow, Passage, most_likely, unlikeliness};
use crate::diagnosis::fitting::shooting::{Driven, Shooting};
use crate::fidelity::Window;
use crate::prediction::Channel;
use crate::prediction::body::State;

impl Shooting<'_> {
    /// Turns the plain residuals of a window, or their slopes, in units of the sensors' noise into innovations in units of their own.
    pub(in crate::diagnosis) fn innovate(&self, window: &Window, residual: &mut [f64]) {
        for (axis, noise) in Axis::ALL.into_iter().zip(&self.noise) {
            if self.lost.is_some() || *noise != AxisNoise::SENSORS {
                self.passage(axis, window).innovate(noise, residual);
            }
        }
    }

    /// A window as an axis shows in it.
    fn passage(&self, axis: Axis, window: &Window) -> Passage<'_> {
        Passage {
            time_s: &self.rows()[window.start..window.end],
            lost: self.lost.as_ref().map_or(&[], |lost| &lost[axis.index()][window.start..window.end]),
            seen: (window.start..window.end).map(|row| self.seen(axis, row)).collect(),
        }
    }

    /// Variance, SI, that commands lost since an earlier row give to a channel's plain residual.
    pub(in crate::diagnosis) fn unknown_variance(&self, of: Channel, since: usize, row: usize) -> f64 {
        let Some(lost) = &self.lost else { return 0.0 };
        let Some((channel, sigma)) =
            self.compared().enumerate().find(|(_, (compared, _))| *compared == of).map(|(k, (_, sigma))| (k, sigma))
        else {
            return 0.0;
        };
        let mut variance = 0.0;
        for (axis, lost) in Axis::ALL.into_iter().zip(lost) {
            let seen = self.seen(axis, row).into_iter().find(|(seen, _)| *seen == channel);
            let Some((_, [angle, rate])) = seen else { continue };
            for (passed, density) in self.rows()[since..=row].windows(2).zip(&lost[since..row]) {
                let moved = sigma * (angle * (self.rows()[row] - 0.5 * (passed[0] + passed[1])) + rate);
                variance += density * density * (passed[1] - passed[0]) * moved * moved;
            }
        }
        variance
    }

    /// How the departure of an axis shows in the compared channels at a row.
    fn seen(&self, axis: Axis, row: usize) -> Vec<(usize, [f64; 2])> {
        let (sin_roll, cos_roll) =
            self.measured(Channel::Angle(Axis::Roll)).map_or((0.0, 1.0), |roll| libm::sincos(roll[row]));
        let is_across = axis == Axis::Pitch && self.is_gimbal();
        let slope = |channel: Channel| match channel {
            Channel::Angle(of) if of == axis => Some([1.0, 0.0]),
            // the gimbal's pitch axis lies across the body
            Channel::Rate(Axis::Pitch) if is_across => Some([0.0, cos_roll]),
            Channel::Rate(Axis::Yaw) if is_across => Some([0.0, -sin_roll]),
            Channel::Rate(of) if of == axis && self.turns(axis) => Some([0.0, 1.0]),
            _ => None,
        };
        let scaled = |(number, (channel, sigma)): (usize, (Channel, f64))| {
            Some((number, slope(channel)?.map(|slope| slope / sigma)))
        };
        self.compared().enumerate().filter_map(scaled).collect()
    }

    /// Under which noise what a model leaves is most likely, per axis.
    pub(in crate::diagnosis) fn most_likely_noise(
        &self,
        driven: &Driven,
        which: &[usize],
        starts: &[State],
    ) -> [AxisNoise; 3] {
        self.axis_windows(driven, which, starts).map(|windows| most_likely(&windows))
    }

    /// Twice the negative logarithm of the likelihood of what a model leaves of some windows, start states quite free, up to a constant of the log;
    /// with that share of what lost commands leave unknown, of some, that makes it likeliest.
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

    /// What a model leaves of some windows, axis by axis.
    fn axis_windows(&self, driven: &Driven, which: &[usize], starts: &[State]) -> [Vec<AxisWindow<'_>>; 3] {
        let left: Vec<(Column, Vec<Column>)> =
            which.iter().map(|index| self.start_slopes(driven, &self.windows[*index], &starts[*index])).collect();
        Axis::ALL.map(|axis| {
            let window = |(index, (residual, slopes)): (&usize, &(Column, Vec<Column>))| {
                let window = &self.windows[*index];
                let mut passage = self.passage(axis, window);
                let rows = passage.time_s.len();
                let mut shown: Vec<usize> = passage.seen.iter().flatten().map(|(channel, _)| *channel).collect();
                shown.sort_unstable();
                shown.dedup();
                for (channel, _) in passage.seen.iter_mut().flatten() {
                    *channel = shown.partition_point(|shown| shown < channel);
                }
                let own = |column: &Column| -> Column {
                    shown.iter().flat_map(|channel| &column[channel * rows..(channel + 1) * rows]).copied().collect()
                };
                AxisWindow { passage, residual: own(residual), slopes: slopes.iter().map(own).collect() }
            };
            which.iter().zip(&left).map(window).collect()
        })
    }
}
