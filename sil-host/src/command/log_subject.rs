//! What a log is held against where nobody said it: never silently. A foreign log's vehicle is identified first; the
//! project's F450 is taken only for this project's own logs, and only where it fits.

use sil_host::diagnosis::{Identification, KnownScale, identify, mismatch};
use sil_host::log::Log;
use sil_host::model::{BenchModel, Rig, VehicleModel};

use super::Failure;
use super::log_arguments::LogArguments;

/// What was chosen, and how.
pub struct Chosen {
    /// None for separate axes.
    pub vehicle: Option<VehicleModel>,
    /// What is known of separate axes, where a model says it.
    pub bench: Option<BenchModel>,
    /// The first line of the answer; empty where there is nothing to say.
    pub said: String,
    /// The identification that the vehicle is from.
    pub identified: Option<Identification>,
}

impl Chosen {
    fn new(vehicle: Option<VehicleModel>, said: String) -> Chosen {
        Chosen { vehicle, bench: None, said, identified: None }
    }
}

/// The vehicle that was named, with what speaks against it; else one that the log itself shows.
pub fn chosen(arguments: &LogArguments, log: &Log, wants_vehicle: Option<&str>) -> Result<Chosen, Failure> {
    if let Some(bench) = arguments.bench()? {
        return match wants_vehicle {
            Some(option) => Err(super::bad_input(format!("--rig axis has no vehicle model: leave out {option}"))),
            None => Ok(Chosen { bench: Some(bench), ..Chosen::new(None, String::new()) }),
        };
    }
    if arguments.says_what_flew() {
        let vehicle = arguments.vehicle(log, wants_vehicle)?;
        let against = vehicle.as_ref().and_then(|model| mismatch(log, model));
        let said = against.map(|why| format!("MISMATCH: {why}. What follows is about the difference."));
        return Ok(Chosen::new(vehicle, said.unwrap_or_default()));
    }
    if !arguments.is_foreign(log) {
        let is_free = log.rig_shown().is_some_and(|shown| shown.is_free);
        let rig = if is_free { Rig::Free } else { Rig::Gimbal };
        let model = VehicleModel::nominal(rig);
        match mismatch(log, &model) {
            None => {
                let said = format!("No --model: held against the project's \"{}\", which fits roughly.", model.name);
                return Ok(Chosen::new(Some(model), said));
            }
            Some(why) if !log.shows_a_vehicle() => {
                let said = format!(
                    "No --model, and the project's \"{}\" does not fit: {why}. Each axis by itself.",
                    model.name
                );
                return axes(log, wants_vehicle, said);
            }
            Some(_) => (),
        }
    }
    if !log.shows_a_vehicle() {
        let said = "No --model, and the log is not known to be a free flight with motors: each axis by itself.";
        return axes(log, wants_vehicle, said.to_owned());
    }
    match identify(std::slice::from_ref(log), KnownScale::default()) {
        Ok(identified) => Ok(Chosen {
            vehicle: Some(identified.model.clone()),
            bench: None,
            said:
                "No --model: the vehicle was identified from this log first (sil identify); what follows is what that \
                   model lacks."
                    .to_owned(),
            identified: Some(identified),
        }),
        Err(error) => {
            let said = format!("No --model, and this log identifies no vehicle: {error}. Each axis by itself.");
            axes(log, wants_vehicle, said)
        }
    }
}

/// Separate axes, with which an option that wants a vehicle can't be given.
fn axes(log: &Log, wants_vehicle: Option<&str>, said: String) -> Result<Chosen, Failure> {
    match wants_vehicle {
        Some(option) => Err(super::bad_input(format!("{}: {said} {option} needs a vehicle: give --model", log.path))),
        None => Ok(Chosen::new(None, said)),
    }
}
