//! A flight under each controller, drawn as the report of `sil fly`, and the motion for the picture of the vehicle.

use serde::Deserialize;
use serde_json::{Value, json};
use sil_host::answer::flight::flown::{FlownController, fly_one};
use sil_host::answer::flight::page::page;
use sil_host::controller_file::{ControllerChoice, TuningChange};
use sil_host::effects::Effect;
use sil_host::flight::FlightSetup;
use sil_host::model::VehicleModel;
use sil_host::scenario::Scenario;

use super::{Answer, message, models};

/// Pictures of the vehicle per second of flight.
const PICTURES_HZ: f64 = 25.0;

/// What is flown.
#[derive(Deserialize)]
pub(super) struct Fly {
    /// A model that ships.
    model: String,
    /// What the vehicle does beyond it, in the short form of the command line.
    effects: Vec<String>,
    /// True if the controllers know these effects.
    #[serde(default)]
    known: bool,
    /// Controller files, each with the name it is shown by.
    controllers: Vec<(String, String)>,
    /// A script; none for the test sequence.
    script: Option<String>,
    seed: u64,
}

impl Fly {
    pub(super) fn answer(&self) -> Answer {
        let model = self.vehicle()?;
        let scenario = match &self.script {
            None => Scenario::test_sequence(),
            Some(script) => Scenario::parse(script, "script").map_err(message)?,
        };
        let fly = |(name, file): &(String, String)| {
            let choice = ControllerChoice::parse(file, &format!("{name}.toml")).map_err(message)?;
            let controller_model = self.known.then(|| model.clone());
            let (model, scenario) = (model.clone(), scenario.clone());
            fly_one(name, FlightSetup { model, controller_model, choice, scenario, seed: self.seed }).map_err(message)
        };
        let flown = self.controllers.iter().map(fly).collect::<Result<Vec<_>, _>>()?;
        Ok(json!({
            "fragment": page(&flown, "the page").to_fragment(),
            "motion": flown.iter().map(motion).collect::<Vec<_>>(),
            "tuning": flown.iter().map(tuning).collect::<Vec<_>>(),
        }))
    }

    fn vehicle(&self) -> Result<VehicleModel, String> {
        let mut model = models::vehicle(&self.model)?;
        for effect in &self.effects {
            let effect = Effect::parse_for(effect, model.rig(), model.inertia_kg_m2);
            model.effects.push(effect.map_err(message)?);
        }
        Ok(model)
    }
}

/// A few times per second: time, s; roll and pitch of the reference, rad; roll, pitch and yaw, rad; the motors'
/// commands.
fn motion(flown: &FlownController) -> Value {
    let record = &flown.flight.record;
    let step = (f64::from(flown.setup.choice.rate_hz) / PICTURES_HZ).round().max(1.0) as usize;
    let picture = |row: usize| {
        json!([record.time_s[row], record.reference_rad[row], record.angle_rad[row], record.commands[row]])
    };
    json!({ "name": flown.name, "pictures": (0..record.len()).step_by(step).map(picture).collect::<Vec<_>>() })
}

/// All gains and weights that flew.
fn tuning(flown: &FlownController) -> Value {
    let choice = &flown.setup.choice;
    json!({
        "name": flown.name,
        "rate_hz": choice.rate_hz,
        "control_horizon": choice.control_horizon,
        "tuning": TuningChange::all_of(&flown.setup.tuning()),
    })
}
