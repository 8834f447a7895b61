//! A vehicle's model from its logs: what the diagnosis calls the base model, made a file.
//!
//! ```text
//! logs -> commands at one battery voltage (log::supply) -> one log (Log::joined)
//!      -> start: angular accelerations per command (log::sanity), weight against hover
//!      -> rough fit from several lags and delays -> folded into the model's own numbers
//!      -> fit in the noise of all that the model does not know, on the windows that are not the report's
//!      -> numbers with intervals (numbers) -> model file (file)
//! ```
//!
//! The fit is the diagnosis': multiple shooting, innovations, priors. The unknowns are effects of the catalogue
//! and two numbers of level `box`, so that nothing is identified in two ways. What a log does not excite stays where
//! such vehicles usually are, as far as a prior allows, and is marked.
//!
//! A log shows ratios only: angular acceleration per command, lift over weight. Mass and arm give them a scale; where
//! neither is known both are set, and all forces and moments of the file go with them.

mod bench;
mod file;
mod fitting;
mod folding;
mod mismatch;
mod numbers;
mod seen;
mod shown_flight;
mod start;

use super::denied::denied;
use super::estimate::Estimate;
use super::progress::Observer;
use crate::log::sanity::by_reference;
use crate::log::{Log, LogError};
use crate::model::VehicleModel;
use crate::prediction::NotPredictable;
pub use bench::{BenchIdentification, identify_axes, identify_axes_observed};
use fitting::Fine;
pub use mismatch::mismatch;
pub use numbers::{Identified, effectiveness_rad_s2, manoeuvres_for};
pub use shown_flight::ShownFlight;

/// What gives the ratios that a log shows a scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KnownScale {
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Distance from a motor's axis to the centre, m.
    pub arm_m: Option<f64>,
}

/// Why a vehicle can't be identified.
#[derive(Debug, thiserror::Error)]
pub enum NotIdentified {
    /// The log can't be predicted by any model.
    #[error(transparent)]
    NotPredictable(#[from] NotPredictable),
    /// The logs can't be taken as one.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Four motors' commands are what a vehicle's model is about.
    #[error(
        "a vehicle's model needs the commands of four motors, and the log has none (a log of axis commands: \
         `sil diagnose LOG --rig axis` fits each axis)"
    )]
    NoMotors,
    /// No window shows what the motors do about roll or pitch.
    #[error(
        "what the motors do about roll or pitch does not show: the log is too short, too quiet or too slow to \
         identify a vehicle, or something else moves it more. Here: {0}. Wanted: steps of roll and pitch to 20 degrees \
         for 15 s, logged at 100 rows/s or more"
    )]
    Quiet(Box<ShownFlight>),
    /// Motors without any lag, which a fit takes for something else.
    #[error(
        "what fits best has motors that act at once, as none do: the commands follow the motion rather than make it, \
         or their times are not those of the rates. Here: {0}. Wanted: steps of roll and pitch to 20 degrees for 15 s"
    )]
    AtOnce(Box<ShownFlight>),
    /// The gains are a controller's answer to disturbances.
    #[error(
        "most of the commands hold against something that no log shows (wind, the propellers' own wake), and a fit to \
         all of them takes gains for too small: {0}. Wanted: the same steps in calm air"
    )]
    Held(String),
    /// The numbers fit no vehicle.
    #[error("what was fitted is no vehicle: {0}")]
    Impossible(String),
}

/// An identified vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// The model, its deviations from four equal motors on a balanced body as effects.
    pub model: VehicleModel,
    /// What the logs showed, with intervals.
    pub numbers: Vec<Identified>,
    /// Scale that was given.
    pub scale: KnownScale,
    /// The logs, and what was used of them.
    pub source: String,
}

/// Identifies a free vehicle from its logs.
///
/// # Errors
/// No motors, too quiet, or numbers that no vehicle has.
pub fn identify(logs: &[Log], scale: KnownScale) -> Result<Identification, NotIdentified> {
    identify_observed(logs, scale, &|_| ())
}

/// The same, and says on the way how far it is.
///
/// # Errors
/// As [`identify`].
pub fn identify_observed(
    logs: &[Log],
    scale: KnownScale,
    observer: Observer<'_>,
) -> Result<Identification, NotIdentified> {
    let one_voltage = Log::at_one_voltage(logs);
    let (battery_v, held) =
        one_voltage.as_ref().map_or((None, logs), |(battery_v, held)| (Some(*battery_v), &held[..]));
    let joined = Log::joined(held)?;
    let thinned = joined.thinned();
    let log = thinned.as_ref().unwrap_or(&joined);
    if shown_flight::slow_commands_hz(log).is_some() {
        return Err(NotIdentified::Quiet(Box::new(ShownFlight::of(log))));
    }
    let start = start::vehicle(log, scale, battery_v)?;
    let rough = fitting::rough(log, &start, observer)?;
    let Fine { model, numbers, gains: [roll, pitch, _] } = fitting::fine(log, &rough, observer)?;
    if numbers.iter().filter(|number| number.is_of_tilt()).all(|number| number.to_fly.is_some()) {
        return Err(NotIdentified::Quiet(Box::new(ShownFlight::of(log))));
    }
    let model = VehicleModel::parse(&model.to_toml(), "the identified model")
        .map_err(|error| NotIdentified::Impossible(error.to_string()))?;
    // about yaw rotors turn a vehicle while they gain speed, too
    refuse_denied(&joined, &[roll, pitch, None])?;
    Ok(Identification { model, numbers, scale, source: source(logs, &joined) })
}

/// Refuses gains that what follows from the log's references surely denies.
fn refuse_denied(log: &Log, gains: &[Option<Estimate>; 3]) -> Result<(), NotIdentified> {
    match denied(by_reference(log).iter().flatten(), gains).as_slice() {
        [] => Ok(()),
        denied => Err(NotIdentified::Held(denied.join("; "))),
    }
}

/// What a model is called whose log is this.
fn name_of(log: &Log) -> String {
    format!("identified from {}", log.file_name())
}

/// The logs, and what was used of them.
fn source(logs: &[Log], joined: &Log) -> String {
    let names: Vec<&str> = logs.iter().map(|log| log.path.as_str()).collect();
    format!(
        "{}: {:.1} s at {:.0} rows/s, three quarters of the windows of 0.5 s (the fourth is left to judge by)",
        names.join(", "),
        logs.iter().map(Log::duration_s).sum::<f64>(),
        joined.rate_hz(),
    )
}

/// What stands above each identified model.
fn head(source: &str) -> String {
    format!(
        "# Identified by `sil identify` from {source}.\n\
         # Intervals hold the truth in 95 of 100 logs, if the noise is what it was taken for.\n"
    )
}

impl Identification {
    /// A number by its name.
    pub fn number(&self, name: &str) -> Option<Estimate> {
        self.numbers.iter().find(|number| number.name == name).map(|number| number.own)
    }
}
