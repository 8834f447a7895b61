//! A flight under each controller, drawn as the report of `sil fly`, and the motion for the picture of the vehicle.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};
use sil_host::answer::flight::flown::{FlownController, fly_one, fly_only};
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
    controllers: Vec<Controlled>,
    /// A script; none for the test sequence.
    script: Option<String>,
    seed: u64,
    /// True to measure the margins too, which takes several times as long.
    margins: bool,
}

/// A controller, and how it differs from the one that follows from the vehicle.
#[derive(Deserialize)]
struct Controlled {
    /// `pid` or `mpc`.
    controller: String,
    rate_hz: u32,
    control_horizon: usize,
    /// Keys of a tuning, each with what its numbers are multiplied by.
    factors: BTreeMap<String, f64>,
    /// Keys of a tuning, each with its value.
    values: BTreeMap<String, Value>,
}

impl Fly {
    pub(super) fn answer(&self) -> Answer {
        let model = self.vehicle()?;
        let scenario = match &self.script {
            None => Scenario::test_sequence(),
            Some(script) => Scenario::parse(script, "script").map_err(message)?,
        };
        let fly = |of: &Controlled| {
            let nominal = FlightSetup {
                controller_model: self.known.then(|| model.clone()),
                model: model.clone(),
                choice: of.choice("")?,
                scenario: scenario.clone(),
                seed: self.seed,
            };
            let tuning = of.tuning(&TuningChange::all_of(&nominal.tuning()))?;
            let setup = FlightSetup { choice: of.choice(&tuning)?, ..nominal };
            let fly = if self.margins { fly_one } else { fly_only };
            Ok((fly(&of.controller, setup).map_err(message)?, of.file(&tuning)))
        };
        let (flown, files) =
            self.controllers.iter().map(fly).collect::<Result<(Vec<FlownController>, Vec<String>), String>>()?;
        Ok(json!({
            "fragment": page(&flown, &self.command()).to_fragment(),
            "motion": flown.iter().map(motion).collect::<Vec<_>>(),
            "tuning": flown.iter().map(|one| TuningChange::all_of(&one.setup.tuning())).collect::<Vec<_>>(),
            "files": files,
            "script": scenario.to_script(),
            "vehicle": model.to_toml(),
        }))
    }

    /// The command that flies the same with the files that the page gives.
    fn command(&self) -> String {
        let controllers = self.controllers.iter().map(|of| format!(" --controller {}.toml", of.controller));
        let known = if self.known { " --controller-model vehicle.toml" } else { "" };
        let controllers: String = controllers.collect();
        format!("sil fly --model vehicle.toml{known}{controllers} --script script.toml --seed {}", self.seed)
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

impl Controlled {
    fn choice(&self, tuning: &str) -> Result<ControllerChoice, String> {
        ControllerChoice::parse(&self.file(tuning), &format!("{}.toml", self.controller)).map_err(message)
    }

    /// The controller file with these lines under `[tuning]`.
    fn file(&self, tuning: &str) -> String {
        let Controlled { controller, rate_hz, control_horizon, .. } = self;
        let head = format!("controller = \"{controller}\"\nrate_hz = {rate_hz}\ncontrol_horizon = {control_horizon}\n");
        format!("{head}[tuning]\n{tuning}")
    }

    /// The lines of what differs from the nominal tuning.
    fn tuning(&self, nominal: &TuningChange) -> Result<String, String> {
        let nominal = toml::Table::try_from(nominal).map_err(message)?;
        let mut changed = toml::Table::new();
        for (key, factor) in &self.factors {
            let value = nominal.get(key).ok_or_else(|| format!("{key}: no number of a tuning"))?;
            changed.insert(key.clone(), times(value, *factor));
        }
        for (key, value) in &self.values {
            changed.insert(key.clone(), toml::Value::try_from(value).map_err(message)?);
        }
        toml::to_string(&changed).map_err(message)
    }
}

/// A number or numbers, multiplied; to four digits, which is what a slider means.
fn times(value: &toml::Value, factor: f64) -> toml::Value {
    let times = |number: f64| {
        let product = format!("{:.3e}", number * factor).parse();
        toml::Value::Float(product.unwrap_or(number))
    };
    match value {
        toml::Value::Float(number) => times(*number),
        toml::Value::Integer(number) => times(*number as f64),
        toml::Value::Array(numbers) => toml::Value::Array(numbers.iter().map(|one| self::times(one, factor)).collect()),
        other => other.clone(),
    }
}
