//! Does the fitted model know how an axis turns? Over a tenth of a second it must be nearer to the measured rate than a
//! vehicle that nothing turns, on windows that it was not fitted to. A fit of what is no such vehicle has narrow
//! intervals and none of that. Of an axis whose commands hold against a disturbance that says nothing (`holding`): how
//! sure its gain is must do.

use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, model_of};
use crate::diagnosis::search::Search;
use crate::prediction::accuracy::predict;
use crate::prediction::{Channel, Window};

/// Length of the predictions, s.
const HORIZON_S: f64 = 0.1;
/// Share of the rate's variation about its mean that a model may leave.
const LEFT_MAX: f64 = 0.8;

/// Roll, pitch and yaw.
pub(super) fn axes<'e>(search: &Search<'e>, fit: &Fit<'e>) -> [bool; 3] {
    let log = &search.shooting.log;
    let driven = log.drive(model_of(search.nominal, &fit.terms));
    let windows = Window::of_length(log.rows(), &search.windows(&search.report), HORIZON_S);
    let predicted = predict(log, &driven, &windows);
    Axis::ALL.map(|axis| {
        if search.shooting.lasting_about(axis).is_some() {
            return true;
        }
        let rate = Channel::Rate(axis);
        let channel = if log.measured(rate).is_some() { rate } else { Channel::Angle(axis) };
        let Some(measured) = log.measured(channel) else { return false };
        let (mut left, mut varied) = (0.0, 0.0);
        for series in predicted.iter().filter_map(|window| window.of(channel)) {
            let mean = series.rows.iter().map(|row| measured[*row]).sum::<f64>() / series.rows.len().max(1) as f64;
            left += series.error.iter().map(|error| error * error).sum::<f64>();
            varied += series.rows.iter().map(|row| (measured[*row] - mean) * (measured[*row] - mean)).sum::<f64>();
        }
        left < LEFT_MAX * LEFT_MAX * varied
    })
}
