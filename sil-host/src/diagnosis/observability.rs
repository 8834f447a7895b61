//! Can a log show anything? Where it lacks what a window's start depends on, even an exact model would miss by more
//! than the vehicle ever moved. Whatever were found there would be about nothing: it is said what is missing instead.

use super::fitting::fit::{Fit, model_of};
use super::search::Search;
use crate::axis::Axis;
use crate::log::Log;
use crate::prediction::accuracy::{ErrorOf, predict, root_mean_square, tallies};
use crate::prediction::{Channel, NotPredictable, Window};
use crate::statistics::variance;

/// Lengths of the predictions, s.
const HORIZONS_S: [f64; 2] = [0.1, 0.5];
/// An exact model's error over the measurement's standard deviation from which on a channel shows nothing: a vehicle at
/// rest, whose measurements are all noise, is at two or three.
const UNSEEN: f64 = 10.0;

/// Refuses a log none of whose channels shows anything.
///
/// # Errors
/// With the worst of them, and the columns that the log lacks.
pub(super) fn check(log: &Log, search: &Search<'_>, nominal: &Fit<'_>) -> Result<(), NotPredictable> {
    let windowed = &search.shooting.log;
    let driven = windowed.drive(model_of(search.nominal, &nominal.terms));
    let of_horizon = |horizon_s: f64| {
        let windows = Window::of_length(windowed.rows(), &search.windows(&search.report), horizon_s);
        tallies(&predict(windowed, &driven, &windows))
    };
    let predicted = HORIZONS_S.map(of_horizon);
    let floor = |channel: Channel| {
        let floors = predicted.iter().filter_map(|of| Some(root_mean_square(of, ErrorOf::Channel(channel))?.1));
        floors.fold(0.0, f64::max)
    };
    let turning = windowed.compared().map(|(channel, _)| channel).filter(|channel| channel.turning_axis().is_some());
    let mut unseen: Vec<(Channel, f64, f64)> = Vec::new();
    for channel in turning {
        let (floor, moved) = (floor(channel), variation(search, channel));
        if floor <= UNSEEN * moved {
            return Ok(());
        }
        unseen.push((channel, floor, moved));
    }
    let Some((channel, floor, moved)) = unseen.into_iter().max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2))) else {
        return Ok(());
    };
    let of = |value: f64| format!("{:.3} {}", channel.in_unit(value), channel.unit());
    Err(NotPredictable::Unseen {
        channel: channel.name(),
        moved: of(moved),
        floor: of(floor),
        lacking: lacking(log, search).join(", "),
    })
}

/// Standard deviation of a measurement over the windows of the report.
fn variation(search: &Search<'_>, channel: Channel) -> f64 {
    let Some(measured) = search.shooting.log.measured(channel) else { return 0.0 };
    let windows = search.windows(&search.report);
    variance(windows.iter().flat_map(|window| &measured[window.start..window.end]).copied()).sqrt()
}

/// Columns of angles and rates that the log has not.
fn lacking(log: &Log, search: &Search<'_>) -> Vec<String> {
    let turns = |axis: &Axis| search.shooting.log.turns(*axis);
    let channels = Axis::ALL.into_iter().filter(turns).flat_map(|axis| [Channel::Angle(axis), Channel::Rate(axis)]);
    channels.filter(|channel| log.column(channel.quantity()).is_none()).map(|one| one.quantity().name()).collect()
}
