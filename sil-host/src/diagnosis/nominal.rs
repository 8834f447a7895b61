//! A model as it stands, held against a log: what `sil compare` shows, by the same prediction as the diagnosis' nominal
//! model.

use super::Subject;
use super::fitting::fit::{as_terms, model_of};
use super::fitting::sampling::Sampled;
use super::search::Search;
use crate::log::Log;
use crate::prediction::predicted_log::PredictedLog;
use crate::prediction::{Channel, ErrorAndFloor, NotPredictable};

/// The model's prediction of a log, and what of the model was fitted to it.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalPrediction {
    /// Window by window.
    pub predicted: PredictedLog,
    /// Input gains of separate axes (roll, pitch, yaw), rad/s^2 per unit of command, fitted to the windows that are not
    /// held out; none of a vehicle.
    pub input_gain_rad_s2: [Option<f64>; 3],
}

/// Predicts a log by a model as it stands. The controller's rate, Hz, is used where it is known; else the log decides
/// between its own and the usual one.
///
/// # Errors
/// The log has no window, or no commands for its rig, or an axis whose command is zero.
pub fn nominal_prediction(
    log: &Log,
    subject: &Subject<'_>,
    control_rate_hz: Option<f64>,
) -> Result<NominalPrediction, NotPredictable> {
    let thinned = log.thinned();
    let log = thinned.as_ref().unwrap_or(log);
    let sampled = Sampled::new(log, subject, control_rate_hz)?;
    // what a model says of a bench is held: how well that predicts another log is the question
    let fitted_along = if let Subject::Bench(_) = subject { Vec::new() } else { subject.fitted_along(log)? };
    let nominal = || subject.model(log);
    let (search, fitted) =
        sampled.nominal(|shooting| Search::new(shooting, &nominal, &[], as_terms(&fitted_along), &|_| ()));
    let windowed = &search.shooting.log;
    let fit = search.refitted(fitted.fit.terms, &fitted.fit.starts);
    let driven = windowed.drive(model_of(&nominal, &fit.terms));
    let mut input_gain_rad_s2 = [None; 3];
    for term in &fit.terms {
        if let Some(axis) = term.effect.axis() {
            input_gain_rad_s2[axis.index()] = term.values.first().copied();
        }
    }
    Ok(NominalPrediction { predicted: PredictedLog::new(windowed, &driven, subject.noise(log)), input_gain_rad_s2 })
}

/// Errors of a model as it stands over the held-out windows, of every channel that is compared, and those of an exact
/// one.
///
/// # Errors
/// As [`nominal_prediction`].
pub fn channel_prediction_errors(
    log: &Log,
    subject: &Subject<'_>,
    control_rate_hz: Option<f64>,
) -> Result<Vec<(Channel, ErrorAndFloor)>, NotPredictable> {
    let predicted = nominal_prediction(log, subject, control_rate_hz)?.predicted;
    Ok(predicted.channels().filter_map(|channel| Some((channel, predicted.error(channel)?))).collect())
}

#[cfg(test)]
mod axes_tests;
#[cfg(test)]
mod plant_tests;
