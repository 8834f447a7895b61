//! A log's residuals as innovations, where there is noise beyond the sensors': that of commands lost between rows (`sampling`), or of
//! disturbances (`process_noise`). What each row adds to what the rows before it have told of the motion's departure from the prediction is white
//! and of unit variance under the model's own noise, as plain residuals are where the forces are known; and being linear in the
//! residuals innovations serve the same least squares (Ljung, System Identification, 2nd ed., 7.2).

use crate::diagnosis::fitting::linearisation::Column;
use crate::diagnosis::fitting::process_noise::{AxisNoise, AxisSensors, AxisWindow, Departure, most_likely};
use crate::diagnosis::fitting::shooting::{Driven, Shooting};
use crate::diagnosis::vehicle::body::State;
use crate::fidelity::Window;

/// How the departure of an axis shows in the compared channels at a row: channel, slopes along (angle, rate) in units of the channel's noise.
type Seen = Vec<(usize, [f64; 2])>;

impl Shooting<'_> {
    /// Turns the plain residuals of a window, or their slopes, in units of the sensors' noise into innovations in units of their own.
    pub(in crate::diagnosis) fn innovate(&self, window: &Window, residual: &mut [f64]) {
        let rows = window.end - window.start;
        for (axis, noise) in self.noise.iter().enumerate().filter(|(_, noise)| **noise != AxisNoise::SENSORS) {
            let mut departure = Departure::default();
            for row in window.start..window.end {
                for (channel, slope) in self.seen(axis, row) {
                    let at = &mut residual[channel * rows + row - window.start];
                    let (innovation, variance) = departure.correct(*at, slope, noise.sensors);
                    *at = innovation / variance.sqrt();
                }
                if row + 1 < window.end {
                    departure.pass(self.rows()[row + 1] - self.rows()[row], noise.acceleration);
                }
            }
        }
    }

    /// Variance, SI, that commands lost since an earlier row give to a plain residual, by its place in a report.
    pub(in crate::diagnosis) fn unknown_variance(&self, place: usize, since: usize, row: usize) -> f64 {
        let Some(lost) = self.lost else { return 0.0 };
        let Some((channel, sigma)) =
            self.compared().enumerate().find(|(_, (compared, _))| *compared == place).map(|(k, (_, sigma))| (k, sigma))
        else {
            return 0.0;
        };
        let mut variance = 0.0;
        for (axis, noise) in lost.iter().enumerate() {
            let seen = self.seen(axis, row).into_iter().find(|(seen, _)| *seen == channel);
            let Some((_, [angle, rate])) = seen else { continue };
            for at in since..row {
                let (from_s, to_s) = (self.rows()[at], self.rows()[at + 1]);
                let moved = sigma * (angle * (self.rows()[row] - 0.5 * (from_s + to_s)) + rate);
                variance += noise.acceleration * noise.acceleration * (to_s - from_s) * moved * moved;
            }
        }
        variance
    }

    fn seen(&self, axis: usize, row: usize) -> Seen {
        let (sin_roll, cos_roll) = self.measured(0).map_or((0.0, 1.0), |roll| libm::sincos(roll[row]));
        let slope = |place: usize| match place {
            _ if place == axis => Some([1.0, 0.0]),
            // the gimbal's pitch axis lies across the body
            4 if axis == 1 && self.is_gimbal() => Some([0.0, cos_roll]),
            5 if axis == 1 && self.is_gimbal() => Some([0.0, -sin_roll]),
            _ if place == axis + 3 && self.turns(axis) => Some([0.0, 1.0]),
            _ => None,
        };
        let scaled = |(channel, (place, sigma)): (usize, (usize, f64))| {
            Some((channel, slope(place)?.map(|slope| slope / sigma)))
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
        let left: Vec<(Column, Vec<Column>)> =
            which.iter().map(|index| self.start_slopes(driven, &self.windows[*index], &starts[*index])).collect();
        [0, 1, 2].map(|axis| {
            let window = |(index, (residual, slopes)): (&usize, &(Column, Vec<Column>))| {
                let window = &self.windows[*index];
                let rows = window.end - window.start;
                let own = |column: &Column| [axis, 3 + axis].map(|place| self.part_of(column, rows, place).to_vec());
                AxisWindow {
                    time_s: &self.rows()[window.start..window.end],
                    residual: own(residual),
                    slopes: slopes.iter().map(own).collect(),
                }
            };
            let windows: Vec<AxisWindow<'_>> = which.iter().zip(&left).map(window).collect();
            most_likely(&windows, self.sensors_of(axis))
        })
    }

    /// Standard deviations of an axis' angle and rate.
    fn sensors_of(&self, axis: usize) -> AxisSensors {
        let std = |place: usize| self.compared().find(|(compared, _)| *compared == place).map(|(_, sigma)| sigma);
        AxisSensors { angle_rad: std(axis), rate_rad_s: std(3 + axis) }
    }

    /// The rows of a channel in a window's residuals; empty for a channel that is not compared.
    fn part_of<'c>(&self, column: &'c [f64], rows: usize, place: usize) -> &'c [f64] {
        let index = self.compared().position(|(compared, _)| compared == place);
        index.map_or(&[], |index| &column[index * rows..(index + 1) * rows])
    }
}
