//! How well a model predicts the held-out windows, as docs/commands.md defines it: a start state from the rows around the start, at most 50 ms
//! before it, then open loop to the end of the window; and how well an exact model would.
//!
//! The state is estimated at the first of those rows by least squares over all of them (the residuals linear in it), with the model
//! under test. Of an exact model the residuals, in units of the noise, are n - J (J_m' J_m)^-1 J_m' n_m, J the slopes along the start state
//! and m the rows that it comes from; their variance is 1 - h in those rows and 1 + h in the others, h = J (J_m' J_m)^-1 J'. Angular
//! accelerations are difference quotients of the rates, of the measured ones as of the predicted.

use rayon::prelude::*;

use crate::axis::Axis;
use crate::diagnosis::fitting::linear::dot;
use crate::diagnosis::fitting::shooting::{Driven, Shooting};
use crate::fidelity::Window;
use crate::prediction::Channel;
use crate::prediction::body::State;

/// Of one quantity: sum of squares of the residuals and of an exact model's standard deviations, SI, and the number of both.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) squares: f64,
    pub(super) floor_squares: f64,
    pub(super) count: f64,
}

/// What an error is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ErrorOf {
    /// A channel.
    Channel(Channel),
    /// The angular acceleration about a body axis: difference quotients of its rate.
    Acceleration(Axis),
}

impl ErrorOf {
    /// All of them, the channels first.
    pub(super) fn all() -> impl Iterator<Item = ErrorOf> {
        Channel::ALL.into_iter().map(ErrorOf::Channel).chain(Axis::ALL.into_iter().map(ErrorOf::Acceleration))
    }

    /// Name in reports and JSON.
    pub(super) fn name(self) -> &'static str {
        match self {
            ErrorOf::Channel(channel) => channel.name(),
            ErrorOf::Acceleration(axis) => ["p_dot", "q_dot", "r_dot"][axis.index()],
        }
    }

    /// Unit for people.
    pub(super) fn unit(self) -> &'static str {
        match self {
            ErrorOf::Channel(channel) => channel.unit(),
            ErrorOf::Acceleration(_) => "deg/s2",
        }
    }

    /// A value in that unit.
    pub(super) fn in_unit(self, value_si: f64) -> f64 {
        match self {
            ErrorOf::Channel(channel) => channel.in_unit(value_si),
            ErrorOf::Acceleration(_) => value_si.to_degrees(),
        }
    }
}

/// Errors of one window.
pub(super) struct WindowTally(Vec<(ErrorOf, Tally)>);

/// What a difference quotient of rates is taken over, s: long enough for the gyro's noise not to hide all else.
const ACCELERATION_OVER_S: f64 = 0.02;

/// One window predicted open loop.
pub(super) struct Predicted {
    pub(super) window: Window,
    pub(super) series: Vec<Series>,
}

/// One quantity of it: measured less predicted, and the standard deviation that an exact model would leave, SI.
pub(super) struct Series {
    pub(super) of: ErrorOf,
    /// First row that each error belongs to.
    pub(super) rows: Vec<usize>,
    pub(super) error: Vec<f64>,
    pub(super) floor: Vec<f64>,
}

/// Predicts windows from the rows around their starts.
pub(super) fn predict(shooting: &Shooting<'_>, driven: &Driven, windows: &[Window]) -> Vec<Predicted> {
    windows.par_iter().map(|window| predict_window(shooting, driven, window)).collect()
}

/// Sums of the errors, window by window.
pub(super) fn tallies(predicted: &[Predicted]) -> Vec<WindowTally> {
    let of = |predicted: &Predicted| {
        let square = |values: &[f64]| values.iter().map(|value| value * value).sum();
        let tally = |series: &Series| Tally {
            squares: square(&series.error),
            floor_squares: square(&series.floor),
            count: series.error.len() as f64,
        };
        WindowTally(predicted.series.iter().map(|series| (series.of, tally(series))).collect())
    };
    predicted.iter().map(of).collect()
}

/// Root mean square over windows, of the errors and of an exact model's.
pub(super) fn root_mean_square(windows: &[WindowTally], of: ErrorOf) -> Option<(f64, f64)> {
    let tallies = || windows.iter().flat_map(|window| &window.0).filter(|(what, _)| *what == of);
    let sum = |part: fn(&Tally) -> f64| tallies().map(|(_, tally)| part(tally)).sum::<f64>();
    let count = sum(|tally| tally.count);
    (count > 0.0).then(|| ((sum(|t| t.squares) / count).sqrt(), (sum(|t| t.floor_squares) / count).sqrt()))
}

/// The window, begun where the rows for its start begin, and its state there, estimated from the rows around the start.
pub(super) fn window_with_start(shooting: &Shooting<'_>, driven: &Driven, window: &Window) -> (Window, State) {
    let around = Window { start: window.lead, end: window.tail, ..*window };
    let mut start = shooting.measured_state(&driven.model, window.lead);
    for _ in 0..2 {
        let (residual, slopes) = shooting.start_slopes(driven, &around, &start);
        let Some(factor) = shooting.start_factor(&slopes) else { break };
        let right: Vec<f64> = slopes.iter().map(|slope| dot(slope, &residual)).collect();
        shooting.move_start(&mut start, &factor.solve(&right));
    }
    (Window { start: window.lead, ..*window }, start)
}

fn predict_window(shooting: &Shooting<'_>, driven: &Driven, window: &Window) -> Predicted {
    let (whole, start) = window_with_start(shooting, driven, window);
    let around = Window { end: window.tail, ..whole };
    let (_, near) = shooting.start_slopes(driven, &around, &start);
    let (residual, slopes) = shooting.start_slopes(driven, &whole, &start);
    let factor = shooting.start_factor(&near);
    let forward = |at: usize| -> Vec<f64> {
        let slope: Vec<f64> = slopes.iter().map(|slope| slope[at]).collect();
        factor.as_ref().map_or_else(Vec::new, |factor| factor.forward(&slope))
    };
    let rows = window.end - window.lead;
    let mut predicted = Predicted { window: *window, series: Vec::new() };
    for (index, (channel, sigma)) in shooting.compared().enumerate() {
        let samples: Vec<Sample> = (window.start..window.end)
            .map(|row| {
                let at = index * rows + row - window.lead;
                Sample { row, error: sigma * residual[at], forward: forward(at), serves: row < window.tail }
            })
            .collect();
        predicted
            .series
            .push(Series::of(channel, sigma, &samples, |row| shooting.unknown_variance(channel, window.start, row)));
        if let Channel::Rate(axis) = channel {
            predicted.series.push(Series::quotients(axis, sigma, &samples, shooting));
        }
    }
    predicted
}

/// One row of one channel.
struct Sample {
    row: usize,
    /// SI.
    error: f64,
    /// Row of L^-1 J.
    forward: Vec<f64>,
    /// True if the start state comes from this row too.
    serves: bool,
}

impl Series {
    fn of(channel: Channel, sigma: f64, samples: &[Sample], unknown_variance: impl Fn(usize) -> f64) -> Series {
        let floor = |sample: &Sample| sigma * sigma * variance(&[(1.0, sample)]) + unknown_variance(sample.row);
        Series {
            of: ErrorOf::Channel(channel),
            rows: samples.iter().map(|sample| sample.row).collect(),
            error: samples.iter().map(|sample| sample.error).collect(),
            floor: samples.iter().map(|sample| floor(sample).sqrt()).collect(),
        }
    }

    /// The angular acceleration of a rate.
    fn quotients(axis: Axis, sigma: f64, samples: &[Sample], shooting: &Shooting<'_>) -> Series {
        let time_s = shooting.rows();
        let mut series =
            Series { of: ErrorOf::Acceleration(axis), rows: Vec::new(), error: Vec::new(), floor: Vec::new() };
        for (i, first) in samples.iter().enumerate() {
            let is_later = |later: &&Sample| time_s[later.row] - time_s[first.row] > ACCELERATION_OVER_S - 1e-6;
            let Some(later) = samples[i..].iter().find(is_later) else { break };
            let per_s = 1.0 / (time_s[later.row] - time_s[first.row]);
            series.rows.push(first.row);
            series.error.push(per_s * (later.error - first.error));
            let unknown = per_s * per_s * shooting.unknown_variance(Channel::Rate(axis), first.row, later.row);
            let known = sigma * sigma * variance(&[(-per_s, first), (per_s, later)]);
            series.floor.push((known + unknown).sqrt());
        }
        series
    }
}

/// Variance of a sum of an exact model's residuals, in units of the noise: with c the factors, d = c' J and s the part of d from the rows that the start
/// comes from, c' c + d P d' - 2 d P s', P = (J_m' J_m)^-1.
fn variance(sum: &[(f64, &Sample)]) -> f64 {
    let components = sum.first().map_or(0, |(_, sample)| sample.forward.len());
    let (mut all, mut serving, mut own) = (vec![0.0; components], vec![0.0; components], 0.0);
    for (factor, sample) in sum {
        own += factor * factor;
        for (i, value) in sample.forward.iter().enumerate() {
            all[i] += factor * value;
            serving[i] += if sample.serves { factor * value } else { 0.0 };
        }
    }
    (own + dot(&all, &all) - 2.0 * dot(&all, &serving)).max(0.0)
}

/// The largest of the channels' errors over an exact model's.
pub(super) fn worst_ratio(windows: &[WindowTally]) -> f64 {
    let ratio =
        |channel| root_mean_square(windows, ErrorOf::Channel(channel)).map_or(0.0, |(error, floor)| error / floor);
    Channel::ALL.into_iter().map(ratio).fold(0.0, f64::max)
}
