//! What is flown, by whom and in which vehicle: the arguments that `sil fly` and `sil montecarlo` share.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::RangedU64ValueParser;
use shared_control::config::Controller;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::FlightSetup;
use sil_host::model::Rig;
use sil_host::scenario::Scenario;

use super::{Failure, RigArgument, bad_input, vehicle_model};

/// What is flown, by whom and in which vehicle.
#[derive(Args)]
pub struct FlightArguments {
    /// Which controller flies: the PID cascade of APM:Copter, model predictive control with the cascade as fallback,
    /// one after the other, `mpc-quick`, or what a file says; may be given several times, to compare what they do
    #[arg(long, value_name = "pid|mpc|both|C.toml", default_value = BOTH)]
    controller: Vec<String>,
    /// Which rig holds the vehicle [default: that of the model, else gimbal]
    #[arg(long, value_enum)]
    rig: Option<RigArgument>,
    /// Vehicle model [default: the project's F450 on that rig]
    #[arg(long, value_name = "M.toml")]
    model: Option<PathBuf>,
    /// What the controllers take the vehicle for, effects included [default: the flown model without its effects]
    #[arg(long, value_name = "M.toml")]
    controller_model: Option<PathBuf>,
    /// Steps of the controller per second [default: the file's, else 400]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(50..=1000))]
    rate: Option<u32>,
    /// Fly this instead of the test sequence
    #[arg(long, value_name = "S.toml")]
    script: Option<PathBuf>,
    /// Prediction steps of the MPC, M to 30 [default: the file's, else 30]
    #[arg(long, value_name = "N")]
    horizon: Option<usize>,
    /// Free inputs per axis of the MPC, 1 to N [default: the file's, else 5]
    #[arg(long, value_name = "M", value_parser = control_horizon())]
    control_horizon: Option<usize>,
    /// Length of a prediction step of the MPC, s, whatever the rate [default: the file's, else 0.01]
    #[arg(long, value_name = "S")]
    prediction_step: Option<f32>,
}

/// Lengths of a prediction step that make sense, s: below, the whole horizon is shorter than a motor's lag; above, a
/// step is longer than a turn of the vehicle takes.
const PREDICTION_STEP_S: std::ops::RangeInclusive<f32> = 0.001..=0.1;

fn control_horizon() -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(1..=shared_control::mpc::HORIZON as u64)
}

/// One after the other.
const BOTH: &str = "both";

/// A flight of one controller.
pub struct NamedFlight {
    /// What the controller is called beside others.
    pub name: String,
    /// The argument that named it: `pid`, `mpc`, a file.
    pub argument: String,
    /// All that decides about the flight.
    pub setup: FlightSetup,
}

impl FlightArguments {
    /// A flight for each controller, all of the same vehicle and scenario.
    pub fn flights(&self, seed: u64) -> Result<Vec<NamedFlight>, Failure> {
        let model = vehicle_model(self.model.as_deref(), self.rig.map(Into::into))?;
        let controller_model = match &self.controller_model {
            None => None,
            Some(path) => Some(vehicle_model(Some(path), Some(model.rig()))?),
        };
        let scenario = match &self.script {
            None => Scenario::test_sequence(),
            Some(path) => Scenario::load(path).map_err(bad_input)?,
        };
        let of = |(name, argument, choice): (String, String, ControllerChoice)| {
            let (model, controller_model, scenario) = (model.clone(), controller_model.clone(), scenario.clone());
            NamedFlight { name, argument, setup: FlightSetup { model, controller_model, choice, scenario, seed } }
        };
        Ok(self.choices()?.into_iter().map(of).collect())
    }

    /// The controllers requested, with what the command line says of them, each by a name of its own.
    fn choices(&self) -> Result<Vec<(String, String, ControllerChoice)>, Failure> {
        let mut choices: Vec<(String, String, ControllerChoice)> = Vec::new();
        for argument in &self.controller {
            let given = match argument.as_str() {
                BOTH => [Controller::Cascade, Controller::Mpc].map(ControllerChoice::nominal).to_vec(),
                argument => vec![ControllerChoice::from_argument(argument).map_err(bad_input)?],
            };
            for choice in given {
                let file = Path::new(argument).file_stem().filter(|_| self.controller.len() > 1 && argument != BOTH);
                let name = file.map_or_else(|| choice.name().into(), |stem| stem.to_string_lossy().into_owned());
                if choices.iter().any(|(other, ..)| *other == name) {
                    return Err(bad_input(format!("--controller {argument}: {name} was given before")));
                }
                let argument = if argument == BOTH { choice.name().to_owned() } else { argument.clone() };
                choices.push((name, argument, choice));
            }
        }
        for (.., choice) in &mut choices {
            choice.rate_hz = self.rate.unwrap_or(choice.rate_hz);
            choice.control_horizon = self.control_horizon.unwrap_or(choice.control_horizon);
            choice.tuning.mpc_horizon = self.horizon.or(choice.tuning.mpc_horizon);
            choice.tuning.mpc_prediction_step_s = self.prediction_step.or(choice.tuning.mpc_prediction_step_s);
            check(choice)?;
        }
        Ok(choices)
    }

    /// The controllers as they were given, as options of a command.
    pub fn controller_options(&self) -> String {
        self.controller.iter().map(|one| format!(" --controller {one}")).collect()
    }

    /// All but the controllers, as options of a command.
    pub fn other_options(&self) -> String {
        let mut line = String::new();
        let numbers = [
            ("--rate", self.rate.map(|rate_hz| rate_hz.to_string())),
            ("--horizon", self.horizon.map(|steps| steps.to_string())),
            ("--control-horizon", self.control_horizon.map(|inputs| inputs.to_string())),
            ("--prediction-step", self.prediction_step.map(|step_s| step_s.to_string())),
        ];
        for (flag, number) in numbers {
            if let Some(number) = number {
                line.push_str(&format!(" {flag} {number}"));
            }
        }
        if let Some(rig) = self.rig {
            line.push_str(&format!(" --rig {}", Rig::from(rig).name()));
        }
        for (flag, path) in
            [("--model", &self.model), ("--controller-model", &self.controller_model), ("--script", &self.script)]
        {
            if let Some(path) = path {
                line.push_str(&format!(" {flag} {}", path.display()));
            }
        }
        line
    }
}

fn check(choice: &ControllerChoice) -> Result<(), Failure> {
    let horizon = choice.tuning.mpc_horizon.unwrap_or(shared_control::mpc::HORIZON);
    let horizons = choice.control_horizon..=shared_control::mpc::HORIZON;
    if !horizons.contains(&horizon) {
        let (min, max) = (horizons.start(), horizons.end());
        return Err(bad_input(format!("--horizon {horizon}: expected {min} (the control horizon) to {max} steps")));
    }
    match choice.tuning.mpc_prediction_step_s {
        Some(step_s) if !PREDICTION_STEP_S.contains(&step_s) => {
            let (min, max) = (PREDICTION_STEP_S.start(), PREDICTION_STEP_S.end());
            Err(bad_input(format!("--prediction-step {step_s}: expected {min} to {max} s")))
        }
        _ => Ok(()),
    }
}
