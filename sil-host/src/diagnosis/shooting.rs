//! A log in windows, each with a start state of its own: residuals of a model, and their normal equations.
//!
//! A window's start state is unknown and is estimated along with the parameters, from the window itself (multiple shooting). Under the
//! method's assumption, white sensor noise and commands that are known, the residuals of a true model are white, in a closed loop too:
//! given its start the motion is a function of known commands, and a sample's noise reaches later commands only.

use rayon::prelude::*;

use super::actuation::{Commands, ForceTrack};
use super::body::State;
use super::linear::{Cholesky, dot};
use super::prediction::{Model, Scene, track};
use super::process_noise::{self, AxisNoise, AxisSensors, AxisWindow, Filter};
use crate::fidelity::{SensorNoise, Window};
use crate::log::Log;

/// Start states are free in so far as these are far beyond any error of a measured one.
const START_PRIOR_ANGLE_RAD: f64 = 0.5;
const START_PRIOR_RATE_RAD_S: f64 = 10.0;
/// Change of a start state for a difference quotient, rad or rad/s.
const START_STEP: f64 = 1e-5;
/// The least noise that a channel is taken to have: the rounding of logs and the accuracy of the integration, rad and rad/s.
const NOISE_MIN: [f64; 2] = [2e-5, 2e-4];

/// What a rig lets turn and what of it is compared.
#[derive(Clone, Debug)]
pub(super) struct RigChannels {
    /// Components of the state that a window's start may choose.
    pub(super) start_components: Vec<usize>,
    /// Places of a report that are compared where the log has them.
    pub(super) compared: Vec<usize>,
    /// True where angles are known up to full turns.
    pub(super) wraps: bool,
}

/// One measured column.
struct Channel<'a> {
    /// Place in a [`super::prediction::Report`].
    place: usize,
    column: &'a [f64],
    sigma: f64,
}

/// Windows of a log that have been cut for a fit.
pub(super) struct Shooting<'a> {
    log: &'a Log,
    pub(super) commands: Commands,
    volts_lost: Vec<f64>,
    channels: Vec<Channel<'a>>,
    pub(super) windows: Vec<Window>,
    /// Components of the state that a window may choose.
    start_components: Vec<usize>,
    wraps: bool,
    /// Noise of each axis beyond the sensors', where some was found.
    noise: Option<[AxisNoise; 3]>,
}

/// A model with the forces that the log's commands make in it.
pub(super) struct Driven {
    pub(super) model: Model,
    pub(super) track: std::sync::Arc<ForceTrack>,
}

/// Whitened residuals of one window, or their change with a parameter.
pub(super) type Column = Vec<f64>;

/// Per window: residuals, and their slopes along the start state and the parameters.
pub(super) struct Linearisation {
    pub(super) windows: Vec<WindowLinear>,
}

/// One window of it.
pub(super) struct WindowLinear {
    residual: Column,
    start: Vec<Column>,
    parameters: Vec<Column>,
}

/// Normal equations of the parameters, the start states eliminated.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    /// Rows one behind the other.
    pub(super) matrix: Vec<f64>,
    pub(super) right: Vec<f64>,
    /// Sum of squares that the best start states leave at the present parameters.
    pub(super) chi2: f64,
}

impl<'a> Shooting<'a> {
    /// A log whose columns are compared where the model reports them.
    pub(super) fn new(
        log: &'a Log,
        commands: Commands,
        windows: Vec<Window>,
        noise: &SensorNoise,
        rig: &RigChannels,
    ) -> Shooting<'a> {
        let mut channels = Vec::new();
        for axis in 0..3 {
            if let (Some(column), Some(sigma)) = (&log.angle_rad[axis], noise.angle_rad[axis]) {
                channels.push(Channel { place: axis, column, sigma: sigma.max(NOISE_MIN[0]) });
            }
            if let (Some(column), Some(sigma)) = (&log.rate_rad_s[axis], noise.rate_rad_s[axis]) {
                channels.push(Channel { place: 3 + axis, column, sigma: sigma.max(NOISE_MIN[1]) });
            }
        }
        channels.retain(|channel| rig.compared.contains(&channel.place));
        channels.sort_by_key(|channel| channel.place);
        let start_components = rig.start_components.clone();
        let (volts_lost, wraps) = (volts_lost(log), rig.wraps);
        Shooting { log, commands, volts_lost, channels, windows, start_components, wraps, noise: None }
    }

    /// The same, with more noise than the sensors'.
    pub(super) fn with_noise(self, noise: [AxisNoise; 3]) -> Shooting<'a> {
        Shooting { noise: Some(noise), ..self }
    }

    /// Under which noise what a model leaves is most likely, per axis.
    pub(super) fn most_likely_noise(&self, driven: &Driven, which: &[usize], starts: &[State]) -> [AxisNoise; 3] {
        let linear = self.linearise(driven, &[], which, starts, None);
        [0, 1, 2].map(|axis| {
            let sensors = self.sensors_of(axis);
            let window = |(index, linear): (&usize, &WindowLinear)| {
                let window = &self.windows[*index];
                let rows = window.end - window.start;
                let own = |column: &Column| [axis, 3 + axis].map(|place| self.part_of(column, rows, place).to_vec());
                AxisWindow {
                    time_s: &self.log.time_s[window.start..window.end],
                    residual: own(&linear.residual),
                    slopes: linear.start.iter().map(own).collect(),
                }
            };
            let windows: Vec<AxisWindow<'_>> = which.iter().zip(&linear.windows).map(window).collect();
            process_noise::most_likely(&windows, sensors)
        })
    }

    /// Standard deviations of an axis' angle and rate.
    fn sensors_of(&self, axis: usize) -> AxisSensors {
        let std =
            |place: usize| self.channels.iter().find(|channel| channel.place == place).map(|channel| channel.sigma);
        AxisSensors { angle_rad: std(axis), rate_rad_s: std(3 + axis) }
    }

    /// The rows of a channel in a window's residuals; empty for a channel that is not compared.
    fn part_of<'c>(&self, column: &'c [f64], rows: usize, place: usize) -> &'c [f64] {
        let index = self.channels.iter().position(|channel| channel.place == place);
        index.map_or(&[], |index| &column[index * rows..(index + 1) * rows])
    }

    /// Residuals, or their slopes, turned into innovations where there is noise beyond the sensors'.
    fn whitened(&self, window: &Window, mut column: Column) -> Column {
        let Some(noise) = &self.noise else { return column };
        let rows = window.end - window.start;
        for (axis, noise) in noise.iter().enumerate() {
            let filter = Filter::new(&self.log.time_s[window.start..window.end], self.sensors_of(axis), noise);
            let places = [axis, 3 + axis];
            let mut parts = places.map(|place| self.part_of(&column, rows, place).to_vec());
            let [angle, rate] = &mut parts;
            filter.apply(angle, rate);
            for (place, part) in places.into_iter().zip(parts) {
                if let Some(index) = self.channels.iter().position(|channel| channel.place == place) {
                    column[index * rows..(index + 1) * rows].copy_from_slice(&part);
                }
            }
        }
        column
    }

    /// Puts a log's forces beside a model, taken over from another where the commands go the same way.
    pub(super) fn drive(&self, model: Model, like: Option<&Driven>) -> Driven {
        let track = match like {
            Some(other) if other.model.chain == model.chain => std::sync::Arc::clone(&other.track),
            _ => std::sync::Arc::new(track(&model, &self.commands)),
        };
        Driven { model, track }
    }

    /// The measured state in a row.
    pub(super) fn measured_state(&self, model: &Model, row: usize) -> State {
        let at = |column: &crate::log::Column| column.as_ref().map_or(0.0, |column| column[row]);
        model.body.state_of(self.log.angle_rad.each_ref().map(at), self.log.rate_rad_s.each_ref().map(at))
    }

    /// The measured states at the windows' starts.
    pub(super) fn measured_starts(&self, model: &Model) -> Vec<State> {
        self.windows.iter().map(|window| self.measured_state(model, window.start)).collect()
    }

    /// Runs of windows without a gap: first row, and the row that ends the last.
    pub(super) fn stretches(&self) -> Vec<(usize, usize)> {
        let mut stretches: Vec<(usize, usize)> = Vec::new();
        for window in &self.windows {
            match stretches.last_mut() {
                Some((_, end)) if *end == window.start => *end = window.end,
                _ => stretches.push((window.start, window.end)),
            }
        }
        stretches
    }

    /// Times of the log's rows, s.
    pub(super) fn rows(&self) -> &[f64] {
        &self.log.time_s
    }

    /// Per row, what the battery has lost, V; empty where nothing is known of it.
    pub(super) fn volts_lost(&self) -> &[f64] {
        &self.volts_lost
    }

    /// The measured body rate of an axis that is compared.
    pub(super) fn measured_rate(&self, axis: usize) -> Option<&[f64]> {
        self.measured(3 + axis)
    }

    /// True for an axis about which the rig lets the vehicle turn by itself.
    pub(super) fn turns(&self, axis: usize) -> bool {
        self.start_components.contains(&(3 + axis))
    }

    /// The measured column at a place of a report, where it is compared.
    pub(super) fn measured(&self, place: usize) -> Option<&[f64]> {
        self.channels.iter().find(|channel| channel.place == place).map(|channel| channel.column)
    }

    /// Commands between which 96 % of all lie.
    pub(super) fn command_range(&self) -> [f64; 2] {
        let mut all: Vec<f64> = self.commands.value.iter().flatten().copied().collect();
        all.sort_by(f64::total_cmp);
        let at =
            |share: f64| all.get((share * (all.len().saturating_sub(1)) as f64) as usize).copied().unwrap_or_default();
        [at(0.02), at(0.98)]
    }

    /// Whitened residuals of one window.
    pub(super) fn residual(&self, driven: &Driven, window: &Window, start: &State) -> Column {
        let scene = Scene { time_s: &self.log.time_s, track: &driven.track, volts_lost: &self.volts_lost };
        let reports = driven.model.predict(&scene, start, window.start, window.end);
        let mut residual = Vec::with_capacity(reports.len() * self.channels.len());
        for channel in &self.channels {
            for (row, report) in (window.start..window.end).zip(&reports) {
                let mut error = channel.column[row] - report[channel.place];
                if self.wraps && channel.place < 3 {
                    error = wrapped(error);
                }
                residual.push(error / channel.sigma);
            }
        }
        residual
    }

    /// Whitened residuals of some windows.
    fn residuals(&self, driven: &Driven, which: &[usize], starts: &[State], shift: Option<usize>) -> Vec<Column> {
        let one = |index: &usize| {
            let mut start = starts[*index];
            if let Some(component) = shift {
                start[component] += START_STEP;
            }
            self.whitened(&self.windows[*index], self.residual(driven, &self.windows[*index], &start))
        };
        which.par_iter().map(one).collect()
    }

    /// Residuals and slopes of some windows. `shifted` are models that differ from `base` in one parameter each, by a step.
    /// The slopes along the start states may come from a linearisation nearby: over half a second they hardly change with the
    /// parameters, and whatever they are, the fit ends where the residuals do not fall any more.
    pub(super) fn linearise(
        &self,
        base: &Driven,
        shifted: &[(Driven, f64)],
        which: &[usize],
        starts: &[State],
        nearby: Option<&Linearisation>,
    ) -> Linearisation {
        let residual = self.residuals(base, which, starts, None);
        let start: Vec<Vec<Column>> = match nearby {
            Some(nearby) => nearby.windows.iter().map(|window| window.start.clone()).collect(),
            None => {
                let along = |component: &usize| {
                    slopes(&residual, self.residuals(base, which, starts, Some(*component)), START_STEP)
                };
                turned(self.start_components.iter().map(along).collect(), which.len())
            }
        };
        let parameters: Vec<Vec<Column>> = shifted
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
    pub(super) fn slopes_of(
        &self,
        linear: &Linearisation,
        shifted: &[(Driven, f64)],
        which: &[usize],
        starts: &[State],
    ) -> Vec<Vec<Column>> {
        let residual: Vec<Column> = linear.windows.iter().map(|window| window.residual.clone()).collect();
        let parameters = shifted
            .iter()
            .map(|(driven, step)| slopes(&residual, self.residuals(driven, which, starts, None), *step))
            .collect();
        turned(parameters, which.len())
    }

    /// The best start states of some windows under a model, from given ones on, and the sum of squares that is left per window.
    pub(super) fn settle(&self, driven: &Driven, which: &[usize], starts: &mut [State]) -> Vec<f64> {
        let mut left = Vec::new();
        let mut nearby = None;
        for _ in 0..2 {
            let linear = self.linearise(driven, &[], which, starts, nearby.as_ref());
            left.clear();
            for (index, window) in which.iter().zip(&linear.windows) {
                let (step, chi2) = window.best_start(&[], &self.start_components);
                self.move_start(&mut starts[*index], &step);
                left.push(chi2);
            }
            nearby = Some(linear);
        }
        left
    }

    /// Moves the start states by what a step of the parameters asks for.
    pub(super) fn move_starts(&self, linear: &Linearisation, step: &[f64], which: &[usize], starts: &mut [State]) {
        for (index, window) in which.iter().zip(&linear.windows) {
            let (start_step, _) = window.best_start(step, &self.start_components);
            self.move_start(&mut starts[*index], &start_step);
        }
    }

    /// Normal equations over all windows of a linearisation, with `extra` columns behind the parameters' own.
    pub(super) fn normal(&self, linear: &Linearisation, extra: Option<&[Vec<Column>]>) -> Normal {
        let of = |(i, window): (usize, &WindowLinear)| {
            let more = extra.map_or(&[][..], |extra| &extra[i]);
            window.reduced(more, &self.start_components)
        };
        let reduced: Vec<Normal> = linear.windows.par_iter().enumerate().map(|(i, window)| of((i, window))).collect();
        let size = reduced.first().map_or(0, |normal| normal.right.len());
        let mut sum = Normal { matrix: vec![0.0; size * size], right: vec![0.0; size], chi2: 0.0 };
        for normal in &reduced {
            sum.matrix.iter_mut().zip(&normal.matrix).for_each(|(sum, value)| *sum += value);
            sum.right.iter_mut().zip(&normal.right).for_each(|(sum, value)| *sum += value);
            sum.chi2 += normal.chi2;
        }
        sum
    }

    /// Places of a report that are compared, and the noise of each.
    pub(super) fn compared(&self) -> impl Iterator<Item = (usize, f64)> {
        self.channels.iter().map(|channel| (channel.place, channel.sigma))
    }

    /// Whitened residuals of one window and their slopes along its start state.
    pub(super) fn start_slopes(&self, driven: &Driven, window: &Window, start: &State) -> (Column, Vec<Column>) {
        let residual = self.residual(driven, window, start);
        let along = |component: &usize| {
            let mut shifted = *start;
            shifted[*component] += START_STEP;
            slope(&residual, self.residual(driven, window, &shifted), START_STEP)
        };
        let slopes = self.start_components.iter().map(along).collect();
        (residual, slopes)
    }

    /// Normal equations of a start state, factored.
    pub(super) fn start_factor(&self, slopes: &[Column]) -> Option<Cholesky> {
        start_factor(slopes, &self.start_components)
    }

    /// Moves a start state by a step of its free components.
    pub(super) fn move_start(&self, start: &mut State, step: &[f64]) {
        for (component, by) in self.start_components.iter().zip(step) {
            start[*component] += by;
        }
    }

    /// Samples of some windows, less what their start states take.
    pub(super) fn degrees_of_freedom(&self, which: &[usize]) -> f64 {
        let rows: usize = which.iter().map(|index| self.windows[*index].end - self.windows[*index].start).sum();
        (rows * self.channels.len()) as f64 - (which.len() * self.start_components.len()) as f64
    }

    /// Index of the windows that are, or are not, held out.
    pub(super) fn part(&self, held_out: bool) -> Vec<usize> {
        self.windows.iter().filter(|window| window.held_out == held_out).map(|window| window.index).collect()
    }
}

impl WindowLinear {
    /// The best change of the start state once the parameters have changed by `step`, and the sum of squares that is left.
    fn best_start(&self, step: &[f64], components: &[usize]) -> (Vec<f64>, f64) {
        let mut residual = self.residual.clone();
        for (column, by) in self.parameters.iter().zip(step) {
            residual.iter_mut().zip(column).for_each(|(residual, slope)| *residual -= slope * by);
        }
        let right: Vec<f64> = self.start.iter().map(|column| dot(column, &residual)).collect();
        let Some(factor) = start_factor(&self.start, components) else {
            return (vec![0.0; components.len()], dot(&residual, &residual));
        };
        let best = factor.solve(&right);
        let chi2 = dot(&residual, &residual) - dot(&right, &best);
        (best, chi2)
    }

    fn reduced(&self, extra: &[Column], components: &[usize]) -> Normal {
        let columns: Vec<&Column> = self.parameters.iter().chain(extra).collect();
        let size = columns.len();
        let against = |column: &Column| -> Vec<f64> { self.start.iter().map(|start| dot(start, column)).collect() };
        let Some(factor) = start_factor(&self.start, components) else {
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

fn start_factor(slopes: &[Column], components: &[usize]) -> Option<Cholesky> {
    let size = slopes.len();
    let mut matrix = vec![0.0; size * size];
    for i in 0..size {
        for j in 0..size {
            matrix[i * size + j] = dot(&slopes[i], &slopes[j]);
        }
        let prior = if components[i] < 3 { START_PRIOR_ANGLE_RAD } else { START_PRIOR_RATE_RAD_S };
        matrix[i * size + i] += 1.0 / (prior * prior);
    }
    Cholesky::new(&matrix, size)
}

/// How a prediction changes with a parameter: minus the change of the residual.
fn slopes(residual: &[Column], shifted: Vec<Column>, step: f64) -> Vec<Column> {
    residual.iter().zip(shifted).map(|(base, shifted)| slope(base, shifted, step)).collect()
}

fn slope(base: &Column, mut shifted: Column, step: f64) -> Column {
    shifted.iter_mut().zip(base).for_each(|(shifted, base)| *shifted = (base - *shifted) / step);
    shifted
}

/// From column by column to window by window.
fn turned(columns: Vec<Vec<Column>>, windows: usize) -> Vec<Vec<Column>> {
    let mut turned: Vec<Vec<Column>> = (0..windows).map(|_| Vec::with_capacity(columns.len())).collect();
    for column in columns {
        for (window, part) in turned.iter_mut().zip(column) {
            window.push(part);
        }
    }
    turned
}

fn wrapped(angle_rad: f64) -> f64 {
    let turn = core::f64::consts::TAU;
    angle_rad - turn * (angle_rad / turn).round()
}

fn volts_lost(log: &Log) -> Vec<f64> {
    let Some(volts) = &log.battery_v else { return Vec::new() };
    let first = log.time_s.iter().zip(volts).take_while(|(time_s, _)| **time_s <= log.time_s[0] + 1.0);
    let (sum, count) = first.fold((0.0, 0.0), |(sum, count), (_, volts)| (sum + volts, count + 1.0));
    volts.iter().map(|volts| sum / count - volts).collect()
}
