//! The figures that people know of a prediction, channel by channel, over the held-out windows.
//!
//! Size of the error ([`Agreement`]): open loop from the rows around a window's start. Whiteness and correlation with
//! the input: the same windows with the start state at its best in each, where an exact model leaves white noise; what
//! the fit of the start takes out of the noise is allowed for.

use serde::Serialize;

use super::commanded::{Commanded, commanded};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::diagnosis::remainder::structure::Settled;
use crate::prediction::accuracy::{PredictedWindow, Series, predict};
use crate::prediction::body::State;
use crate::prediction::windowed_log::{Driven, WindowedLog};
use crate::prediction::{Channel, Window};
use crate::statistics::{Agreement, Correlogram, InputCorrelation, LjungBox, dot, input_correlation, variance};

/// Rows apart up to which residuals are correlated with each other and with the input.
const LAGS: usize = 20;
/// Standard deviation of a measurement that moves, in errors of an exact model: such a model fits it by 67 %.
const VARIATION_MIN: f64 = 3.0;
/// Standard deviation of a command that moves, of the full one.
const COMMAND_MIN: f64 = 5e-3;
/// Fit of what is moved by its commands, %: a third of the variance is theirs.
const COMMANDED_MIN_PCT: f64 = 20.0;
/// Share of the error of the start alone by which that fit's error must be less: a slow motion is near its start.
const BEYOND_START_MIN: f64 = 0.2;

/// How one channel is predicted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChannelStatistics {
    /// roll, pitch, yaw, p, q or r; of a free vehicle ax, ay, az, vn, ve, vd and height too.
    pub quantity: &'static str,
    /// deg, deg/s, m/s2, m/s or m.
    pub unit: &'static str,
    /// True of an angle or rate that moves, by more than three times what an exact model would miss, while the command
    /// of its axis does.
    pub moved: bool,
    /// How well the best linear response to its axis' command fits it over windows that the response is not taken from,
    /// %: what there is to be had, whatever the vehicle is. None where the channel has no command.
    pub commands_fit_pct: Option<f64>,
    /// True if it moves because of its commands, so that a model could show what it knows: that response or the model
    /// with the findings fits it by 20 % or more, and misses a fifth less than who knows no commands. False where its
    /// commands hold against a disturbance.
    pub excited: bool,
    /// By the model without any effect.
    pub nominal: ModelStatistics,
    /// With the base model alone.
    pub base: ModelStatistics,
    /// With the findings.
    pub extended: ModelStatistics,
}

/// One model's figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModelStatistics {
    /// Size of the error.
    #[serde(flatten)]
    pub agreement: Agreement,
    /// Whiteness of the residual.
    pub ljung_box: Option<LjungBox>,
    /// Its correlation with the axis' command; none for what belongs to no axis.
    pub input_correlation: Option<InputCorrelation>,
}

/// A model, what it predicts for the held-out windows, and the start states at their best.
pub(in crate::diagnosis) struct Judged<'a> {
    pub(in crate::diagnosis) driven: &'a Driven,
    pub(in crate::diagnosis) predicted: &'a [PredictedWindow],
    pub(in crate::diagnosis) starts: &'a [State],
}

/// All channels that are compared; `commands` are the axes' (roll, pitch, yaw) per row.
pub(in crate::diagnosis) fn statistics(
    shooting: &Shooting<'_>,
    models: [Judged<'_>; 3],
    commands: &[[f64; 4]],
) -> Vec<ChannelStatistics> {
    let settled = models.each_ref().map(|model| settle(shooting, model));
    let all: Vec<Window> = shooting.log.in_use().iter().map(|index| shooting.log.windows[*index]).collect();
    let everywhere = predict(&shooting.log, models[2].driven, &all);
    let of_channel = |(number, (channel, _)): (usize, (Channel, f64))| {
        let of = |model: usize| {
            let agreement = agreement(&shooting.log, models[model].predicted, channel)?;
            let (ljung_box, input_correlation) = remainder(&settled[model], number, channel, commands);
            Some(ModelStatistics { agreement, ljung_box, input_correlation })
        };
        let [nominal, base, extended] = [of(0)?, of(1)?, of(2)?];
        let moved = is_moved(&shooting.log, models[2].predicted, channel, commands);
        let commanded = by_commands(&shooting.log, &everywhere, channel, commands);
        let commands_fit_pct = commanded.map(|commanded| commanded.fit_pct);
        let best_pct = commands_fit_pct.into_iter().chain(extended.agreement.fit_pct).fold(f64::MIN, f64::max);
        let is_beyond = |start: Commanded| 100.0 - best_pct <= (1.0 - BEYOND_START_MIN) * (100.0 - start.held_pct);
        // commands that hold against a disturbance are no cause that a prediction open loop could show
        let holds = channel.turning_axis().is_some_and(|axis| shooting.lasting_about(axis).is_some());
        let excited = moved && !holds && best_pct >= COMMANDED_MIN_PCT && commanded.is_none_or(is_beyond);
        let (quantity, unit) = (channel.name(), channel.unit());
        Some(ChannelStatistics { quantity, unit, moved, commands_fit_pct, excited, nominal, base, extended })
    };
    shooting.log.compared().enumerate().filter_map(of_channel).collect()
}

fn by_commands(
    log: &WindowedLog<'_>,
    everywhere: &[PredictedWindow],
    channel: Channel,
    commands: &[[f64; 4]],
) -> Option<Commanded> {
    let axis = channel.turning_axis()?;
    let command: Vec<f64> = commands.iter().map(|of_axes| of_axes[axis.index()]).collect();
    commanded(log.rows(), log.measured(channel)?, &command, channel, everywhere)
}

fn is_moved(log: &WindowedLog<'_>, predicted: &[PredictedWindow], channel: Channel, commands: &[[f64; 4]]) -> bool {
    let (Some(axis), Some(measured)) = (channel.turning_axis(), log.measured(channel)) else { return false };
    let series: Vec<&Series> = predicted.iter().filter_map(|predicted| predicted.of(channel)).collect();
    let rows = || series.iter().flat_map(|series| &series.rows).copied();
    let floors = || series.iter().flat_map(|series| &series.floor);
    let floor = (floors().map(|floor| floor * floor).sum::<f64>() / floors().count().max(1) as f64).sqrt();
    variance(rows().map(|row| measured[row])).sqrt() > VARIATION_MIN * floor
        && variance(rows().map(|row| commands[row][axis.index()])).sqrt() > COMMAND_MIN
}

/// Held-out windows by their first row.
fn settle(shooting: &Shooting<'_>, model: &Judged<'_>) -> Vec<(usize, Settled)> {
    let of = |predicted: &PredictedWindow| {
        let window = &predicted.window;
        Some((window.start, Settled::of(shooting, model.driven, window, &model.starts[window.index])?))
    };
    model.predicted.iter().filter_map(of).collect()
}

fn agreement(log: &WindowedLog<'_>, predicted: &[PredictedWindow], channel: Channel) -> Option<Agreement> {
    let measured = log.measured(channel)?;
    let mut samples = Vec::new();
    for series in predicted.iter().filter_map(|predicted| predicted.of(channel)) {
        // an error the short way round, whatever turn the measurement is in
        let pairs = series.rows.iter().zip(&series.error);
        let sample = |row: usize, error: f64| (channel.in_unit(measured[row]), channel.in_unit(measured[row] - error));
        samples.extend(pairs.map(|(row, error)| sample(*row, *error)));
    }
    Agreement::of(&samples)
}

fn remainder(
    settled: &[(usize, Settled)],
    number: usize,
    channel: Channel,
    commands: &[[f64; 4]],
) -> (Option<LjungBox>, Option<InputCorrelation>) {
    let mut correlogram = Correlogram::new(LAGS);
    let mut stretches = Vec::new();
    for (start, settled) in settled {
        let (residual, forward) = settled.channel(number);
        correlogram.take_fitted(residual, |i, j| dot(&forward[i], &forward[j]));
        if let Some(axis) = channel.turning_axis() {
            let input = commands[*start..start + residual.len()].iter().map(|command| command[axis.index()]).collect();
            stretches.push((residual.to_vec(), input));
        }
    }
    let with_input = channel.turning_axis().and_then(|_| input_correlation(&stretches, LAGS));
    (correlogram.ljung_box(), with_input)
}
