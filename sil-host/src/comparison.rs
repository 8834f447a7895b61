//! A measured log against the simulation: in closed loop (the thesis' table 5.1) and by the open-loop prediction of its
//! windows.

use serde::Serialize;

use crate::axis::Axis;
use crate::closed_loop::{ClosedLoop, ClosedLoopDeviation, LogRefused, closed_loop, missing_for_closed_loop};
use crate::controller_file::ControllerChoice;
use crate::diagnosis::{NominalPrediction, nominal_prediction};
use crate::log::Log;
use crate::prediction::{ChannelErrors, Subject, WINDOW_S};

/// The result of holding a log against the simulation.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Simulated closed loop against measured; none without a controller or references.
    pub closed_loop: Option<ClosedLoop>,
    /// Every window predicted open loop from the logged commands.
    pub prediction: NominalPrediction,
    /// What a reader of the figures should know.
    pub notes: Vec<String>,
}

/// What `sil compare --json` writes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparisonSummary {
    /// The thesis' table 5.1.
    pub closed_loop: Option<ClosedLoopDeviation>,
    /// Of the open-loop prediction, over the held-out windows.
    pub prediction_error: PredictionError,
}

/// `prediction_error` of the JSON of `sil compare`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictionError {
    /// Length of a window, s.
    pub window_s: f64,
    /// Of the model as it stands.
    pub nominal: ChannelErrors,
    /// Of an exact model: sensor noise, the start state's uncertainty, commands lost between rows.
    pub noise_floor: ChannelErrors,
    /// The same of every channel that is compared.
    pub channels: Vec<ChannelError>,
}

/// Root mean square error of one channel, and an exact model's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChannelError {
    /// roll, pitch, yaw, p, q or r; of a free vehicle ax, ay, az, vn, ve, vd and height too.
    pub quantity: &'static str,
    /// deg, deg/s; m/s2, m/s, m.
    pub unit: &'static str,
    /// Of the model as it stands.
    pub nominal: f64,
    /// Of an exact model.
    pub noise_floor: f64,
}

impl Comparison {
    /// The figures alone.
    pub fn summary(&self) -> ComparisonSummary {
        ComparisonSummary {
            closed_loop: self.closed_loop.as_ref().map(|closed_loop| closed_loop.deviation),
            prediction_error: self.prediction_error(),
        }
    }

    /// Errors of the open-loop prediction.
    pub fn prediction_error(&self) -> PredictionError {
        let predicted = &self.prediction.predicted;
        let [nominal, noise_floor] = predicted.channel_errors();
        let channels = predicted.channels().filter_map(|channel| {
            let error = predicted.error(channel)?;
            Some(ChannelError {
                quantity: channel.name(),
                unit: channel.unit(),
                nominal: channel.in_unit(error.error),
                noise_floor: channel.in_unit(error.noise_floor),
            })
        });
        PredictionError { window_s: WINDOW_S, nominal, noise_floor, channels: channels.collect() }
    }
}

/// Holds a log against the simulation: a vehicle on its rig or in free flight, with the controller that flew it where
/// that is known, or separate axes.
///
/// # Errors
/// [`LogRefused`]: a column that the subject needs is missing, no window is long enough, the controller can't fly.
pub fn compare(
    log: &Log,
    subject: &Subject<'_>,
    controller: Option<ControllerChoice>,
) -> Result<Comparison, LogRefused> {
    // first the prediction: it refuses a log whose time is in another unit, which would be simulated for hours
    let prediction = nominal_prediction(log, subject, controller.map(|choice| f64::from(choice.rate_hz)))?;
    let mut notes = notes_on(log, &prediction);
    let closed_loop = match (subject, controller) {
        (Subject::Vehicle(model), Some(choice)) => {
            let closed_loop = closed_loop(log, model, choice)?;
            if closed_loop.is_none() {
                notes.push(format!("no closed loop: the log lacks {}", missing_for_closed_loop(log)));
            }
            closed_loop
        }
        _ => None,
    };
    Ok(Comparison { closed_loop, prediction, notes })
}

/// What a reader of the prediction's errors should know.
fn notes_on(log: &Log, prediction: &NominalPrediction) -> Vec<String> {
    let mut notes = Vec::new();
    for axis in Axis::ALL {
        let Some(gain) = prediction.input_gain_rad_s2[axis.index()] else { continue };
        if log.axis_command[axis.index()].is_none() {
            notes.push(format!("{}: no axis command in the log, made of its motors", axis.name()));
        }
        if gain < 0.0 {
            notes.push(format!(
                "{}: the fitted input gain is negative; something that a rigid axis lacks moves it more than the \
                 command",
                axis.name()
            ));
        }
    }
    if prediction.predicted.commands_are_lost {
        let lost = "the controller ran faster than the log: the commands between rows are unknown and count in the \
                    noise floor";
        notes.push(lost.to_owned());
    }
    notes
}

#[cfg(test)]
mod tests;
