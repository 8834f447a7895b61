//! How well a model predicts windows, as docs/commands.md defines it: a start state from the rows around the start
//! (`start_state`), then open loop to the end of the window; and how well an exact model would.
//!
//! Of an exact model the residuals, in units of the noise, are n - J (J_m' J_m)^-1 J_m' n_m, J the slopes along the
//! start state and m the rows that it comes from; their variance is 1 - h in those rows and 1 + h in the others, h = J
//! (J_m' J_m)^-1 J'. To it comes what commands lost between the rows leave unknown (`lost_commands`). Angular
//! accelerations are difference quotients of the rates, of the measured ones as of the predicted.

use rayon::prelude::*;
use serde::Serialize;

use super::Channel;
use super::window::Window;
use super::windowed_log::{Driven, WindowedLog};
use crate::axis::Axis;
use crate::statistics::dot;

/// Of one quantity: sum of squares of the residuals and of an exact model's standard deviations, SI, and the number of
/// both.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) squares: f64,
    pub(crate) floor_squares: f64,
    pub(crate) count: f64,
}

/// What an error is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ErrorOf {
    /// A channel.
    Channel(Channel),
    /// The angular acceleration about a body axis: difference quotients of its rate.
    Acceleration(Axis),
}

impl ErrorOf {
    /// All of them, the channels first.
    pub(crate) fn all() -> impl Iterator<Item = ErrorOf> {
        Channel::ALL.into_iter().map(ErrorOf::Channel).chain(Axis::ALL.into_iter().map(ErrorOf::Acceleration))
    }

    /// Name in reports and JSON.
    pub(crate) fn name(self) -> &'static str {
        match self {
            ErrorOf::Channel(channel) => channel.name(),
            ErrorOf::Acceleration(axis) => ["p_dot", "q_dot", "r_dot"][axis.index()],
        }
    }

    /// Unit for people.
    pub(crate) fn unit(self) -> &'static str {
        match self {
            ErrorOf::Channel(channel) => channel.unit(),
            ErrorOf::Acceleration(_) => "deg/s2",
        }
    }

    /// A value in that unit.
    pub(crate) fn in_unit(self, value_si: f64) -> f64 {
        match self {
            ErrorOf::Channel(channel) => channel.in_unit(value_si),
            ErrorOf::Acceleration(_) => value_si.to_degrees(),
        }
    }
}

/// Errors of one window.
pub(crate) struct WindowTally(Vec<(ErrorOf, Tally)>);

/// What a difference quotient of rates is taken over, s: long enough for the gyro's noise not to hide all else.
const ACCELERATION_OVER_S: f64 = 0.02;

/// One window predicted open loop.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PredictedWindow {
    pub(crate) window: Window,
    pub(crate) series: Vec<Series>,
}

/// One quantity of it: measured less predicted, and the standard deviation that an exact model would leave, SI.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Series {
    pub(crate) of: ErrorOf,
    /// First row that each error belongs to.
    pub(crate) rows: Vec<usize>,
    pub(crate) error: Vec<f64>,
    pub(crate) floor: Vec<f64>,
}

impl PredictedWindow {
    /// The series of a channel.
    pub(crate) fn of(&self, channel: Channel) -> Option<&Series> {
        self.series.iter().find(|series| series.of == ErrorOf::Channel(channel))
    }
}

/// Predicts windows from the rows around their starts.
pub(crate) fn predict(log: &WindowedLog<'_>, driven: &Driven, windows: &[Window]) -> Vec<PredictedWindow> {
    windows.par_iter().map(|window| predict_window(log, driven, window)).collect()
}

/// Sums of the errors, window by window.
pub(crate) fn tallies<'p>(predicted: impl IntoIterator<Item = &'p PredictedWindow>) -> Vec<WindowTally> {
    let of = |predicted: &PredictedWindow| {
        let square = |values: &[f64]| values.iter().map(|value| value * value).sum();
        let tally = |series: &Series| Tally {
            squares: square(&series.error),
            floor_squares: square(&series.floor),
            count: series.error.len() as f64,
        };
        WindowTally(predicted.series.iter().map(|series| (series.of, tally(series))).collect())
    };
    predicted.into_iter().map(of).collect()
}

/// Root mean square over windows, of the errors and of an exact model's.
pub(crate) fn root_mean_square(windows: &[WindowTally], of: ErrorOf) -> Option<(f64, f64)> {
    let tallies = || windows.iter().flat_map(|window| &window.0).filter(|(what, _)| *what == of);
    let sum = |part: fn(&Tally) -> f64| tallies().map(|(_, tally)| part(tally)).sum::<f64>();
    let count = sum(|tally| tally.count);
    (count > 0.0).then(|| ((sum(|t| t.squares) / count).sqrt(), (sum(|t| t.floor_squares) / count).sqrt()))
}

fn predict_window(log: &WindowedLog<'_>, driven: &Driven, window: &Window) -> PredictedWindow {
    let (whole, start) = log.window_with_start(driven, window);
    let around = Window { end: window.tail, ..whole };
    let (_, near) = log.start_slopes(driven, &around, &start);
    let (residual, slopes) = log.start_slopes(driven, &whole, &start);
    let factor = log.start_factor(&near);
    let forward = |at: usize| -> Vec<f64> {
        let slope: Vec<f64> = slopes.iter().map(|slope| slope[at]).collect();
        factor.as_ref().map_or_else(Vec::new, |factor| factor.forward(&slope))
    };
    let rows = window.end - window.lead;
    let mut predicted = PredictedWindow { window: *window, series: Vec::new() };
    for (index, (channel, sigma)) in log.compared().enumerate() {
        let samples: Vec<Sample> = (window.start..window.end)
            .map(|row| {
                let at = index * rows + row - window.lead;
                Sample { row, error: sigma * residual[at], forward: forward(at), serves: row < window.tail }
            })
            .collect();
        predicted
            .series
            .push(Series::of(channel, sigma, &samples, |row| log.unknown_variance(channel, window.start, row)));
        if let Channel::Rate(axis) = channel {
            predicted.series.push(Series::quotients(axis, sigma, &samples, log));
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
    fn quotients(axis: Axis, sigma: f64, samples: &[Sample], log: &WindowedLog<'_>) -> Series {
        let time_s = log.rows();
        let mut series =
            Series { of: ErrorOf::Acceleration(axis), rows: Vec::new(), error: Vec::new(), floor: Vec::new() };
        for (i, first) in samples.iter().enumerate() {
            let is_later = |later: &&Sample| time_s[later.row] - time_s[first.row] > ACCELERATION_OVER_S - 1e-6;
            let Some(later) = samples[i..].iter().find(is_later) else { break };
            let per_s = 1.0 / (time_s[later.row] - time_s[first.row]);
            series.rows.push(first.row);
            series.error.push(per_s * (later.error - first.error));
            let unknown = per_s * per_s * log.unknown_variance(Channel::Rate(axis), first.row, later.row);
            let known = sigma * sigma * variance(&[(-per_s, first), (per_s, later)]);
            series.floor.push((known + unknown).sqrt());
        }
        series
    }
}

/// Variance of a sum of an exact model's residuals, in units of the noise: with c the factors, d = c' J and s the part
/// of d from the rows that the start comes from, c' c + d P d' - 2 d P s', P = (J_m' J_m)^-1.
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
pub(crate) fn worst_ratio(windows: &[WindowTally]) -> f64 {
    let ratio =
        |channel| root_mean_square(windows, ErrorOf::Channel(channel)).map_or(0.0, |(error, floor)| error / floor);
    Channel::ALL.into_iter().map(ratio).fold(0.0, f64::max)
}

/// Root mean square per channel of what turns, in degrees and degrees per second; `None` (null in JSON) where the log
/// has no such channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ChannelErrors {
    /// Roll, degrees.
    pub roll_deg: Option<f64>,
    /// Pitch, degrees.
    pub pitch_deg: Option<f64>,
    /// Body rate p, degrees per second.
    pub p_deg_s: Option<f64>,
    /// Body rate q, degrees per second.
    pub q_deg_s: Option<f64>,
}

impl ChannelErrors {
    /// An exact model's, none above what any of some models reached.
    pub(crate) fn at_most(self, models: &[ChannelErrors]) -> ChannelErrors {
        let least = |of: fn(&ChannelErrors) -> Option<f64>| {
            of(&self).map(|own| models.iter().filter_map(of).fold(own, f64::min))
        };
        ChannelErrors {
            roll_deg: least(|errors| errors.roll_deg),
            pitch_deg: least(|errors| errors.pitch_deg),
            p_deg_s: least(|errors| errors.p_deg_s),
            q_deg_s: least(|errors| errors.q_deg_s),
        }
    }
}

/// Root mean square errors of a model's windows, and an exact model's.
pub(crate) fn channel_errors(windows: &[WindowTally]) -> [ChannelErrors; 2] {
    let of = |which: fn((f64, f64)) -> f64| {
        let degrees = |channel: Channel| {
            root_mean_square(windows, ErrorOf::Channel(channel)).map(|both| channel.in_unit(which(both)))
        };
        ChannelErrors {
            roll_deg: degrees(Channel::Angle(Axis::Roll)),
            pitch_deg: degrees(Channel::Angle(Axis::Pitch)),
            p_deg_s: degrees(Channel::Rate(Axis::Roll)),
            q_deg_s: degrees(Channel::Rate(Axis::Pitch)),
        }
    };
    [of(|(error, _)| error), of(|(_, floor)| floor)]
}
