//! `sil fly`: the test sequence or a script, under the cascade, the MPC, or both.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::RangedU64ValueParser;
use serde::Serialize;
use shared_control::config::Controller;
use sil_host::answer::flight::flown::{FlownController, fly_one};
use sil_host::answer::flight::page::page;
use sil_host::answer::flight::text::summary_text;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::{FlightSetup, RunSummary};
use sil_host::flight_log::flight_log;
use sil_host::model::Rig;
use sil_host::scenario::Scenario;

use super::{Failure, RigArgument, bad_input, failed, make_folder, print, vehicle_model, write_file, write_json};

/// Fly the thesis' test sequence, or a script, in co-simulation
#[derive(Args)]
#[command(after_help = "Example: sil fly --controller both --rig gimbal --report out/flight.html\n\n\
A script is TOML: duration_s, then [[step]] with at_s, roll_deg, pitch_deg, yaw_rate_deg_s, throttle or (in free\n\
flight) climb_m. A controller file is TOML: controller, rate_hz, control_horizon, and [tuning] with what differs from\n\
the tuning that follows from the vehicle. docs/commands.md has both.")]
pub struct FlyArguments {
    /// Which controller flies: the PID cascade of APM:Copter, model predictive control with the cascade as fallback,
    /// one after the other, or what a file says; may be given several times, to compare what they do
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
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Prediction steps of the MPC, M to 30 [default: the file's, else 30]
    #[arg(long, value_name = "N")]
    horizon: Option<usize>,
    /// Free inputs per axis of the MPC, 1 to N [default: the file's, else 5]
    #[arg(long, value_name = "M", value_parser = control_horizon())]
    control_horizon: Option<usize>,
    /// Length of a prediction step of the MPC, s, whatever the rate [default: the file's, else 0.01]
    #[arg(long, value_name = "S")]
    prediction_step: Option<f32>,
    /// Write the flight as a log, ULog if its name ends in .ulg; with both controllers OUT-pid.csv and OUT-mpc.csv
    #[arg(long, value_name = "OUT.csv")]
    log: Option<PathBuf>,
    /// Write a report with plots
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the figures as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// Lengths of a prediction step that make sense, s: below, the whole horizon is shorter than a motor's lag; above, a
/// step is longer than a turn of the vehicle takes.
const PREDICTION_STEP_S: std::ops::RangeInclusive<f32> = 0.001..=0.1;

fn control_horizon() -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(1..=shared_control::mpc::HORIZON as u64)
}

/// One after the other.
const BOTH: &str = "both";

#[derive(Serialize)]
struct FlyJson<'a> {
    runs: Vec<&'a RunSummary>,
}

pub fn run(arguments: &FlyArguments) -> Result<(), Failure> {
    let model = vehicle_model(arguments.model.as_deref(), arguments.rig.map(Into::into))?;
    let controller_model = match &arguments.controller_model {
        None => None,
        Some(path) => Some(vehicle_model(Some(path), Some(model.rig()))?),
    };
    let scenario = match &arguments.script {
        None => Scenario::test_sequence(),
        Some(path) => Scenario::load(path).map_err(bad_input)?,
    };
    let flown: Vec<FlownController> = choices(arguments)?
        .into_iter()
        .map(|(name, choice)| {
            let (model, controller_model) = (model.clone(), controller_model.clone());
            let setup =
                FlightSetup { model, controller_model, choice, scenario: scenario.clone(), seed: arguments.seed };
            fly_one(&name, setup).map_err(bad_input)
        })
        .collect::<Result<_, _>>()?;
    print(summary_text(&flown))?;
    for one in &flown {
        if let Some(path) = &arguments.log {
            let path = log_path(path, &one.name, flown.len() > 1);
            write_log(&path, one)?;
            print(format!("log     {}\n", path.display()))?;
        }
    }
    if let Some(path) = &arguments.report {
        write_file(path, page(&flown, &command_line(arguments)).to_html().as_bytes())?;
        print(format!("report  {}\n", path.display()))?;
    }
    write_json(arguments.json.as_deref(), &FlyJson { runs: flown.iter().map(|one| &one.flight.summary).collect() })
}

/// The controllers requested, with what the command line says of them, each by a name of its own.
fn choices(arguments: &FlyArguments) -> Result<Vec<(String, ControllerChoice)>, Failure> {
    let mut choices: Vec<(String, ControllerChoice)> = Vec::new();
    for argument in &arguments.controller {
        let given = match argument.as_str() {
            BOTH => [Controller::Cascade, Controller::Mpc].map(ControllerChoice::nominal).to_vec(),
            argument => vec![ControllerChoice::from_argument(argument).map_err(bad_input)?],
        };
        for choice in given {
            let file = Path::new(argument).file_stem().filter(|_| arguments.controller.len() > 1 && argument != BOTH);
            let name = file.map_or_else(|| choice.name().into(), |stem| stem.to_string_lossy().into_owned());
            if choices.iter().any(|(other, _)| *other == name) {
                return Err(bad_input(format!("--controller {argument}: {name} was given before")));
            }
            choices.push((name, choice));
        }
    }
    for (_, choice) in &mut choices {
        choice.rate_hz = arguments.rate.unwrap_or(choice.rate_hz);
        choice.control_horizon = arguments.control_horizon.unwrap_or(choice.control_horizon);
        choice.tuning.mpc_horizon = arguments.horizon.or(choice.tuning.mpc_horizon);
        choice.tuning.mpc_prediction_step_s = arguments.prediction_step.or(choice.tuning.mpc_prediction_step_s);
        check(choice)?;
    }
    Ok(choices)
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

/// The command that repeats this run.
fn command_line(arguments: &FlyArguments) -> String {
    let controllers: String = arguments.controller.iter().map(|one| format!(" --controller {one}")).collect();
    let mut line = format!("sil fly{controllers} --seed {}", arguments.seed);
    let numbers = [
        ("--rate", arguments.rate.map(|rate_hz| rate_hz.to_string())),
        ("--horizon", arguments.horizon.map(|steps| steps.to_string())),
        ("--control-horizon", arguments.control_horizon.map(|inputs| inputs.to_string())),
        ("--prediction-step", arguments.prediction_step.map(|step_s| step_s.to_string())),
    ];
    for (flag, number) in numbers {
        if let Some(number) = number {
            line.push_str(&format!(" {flag} {number}"));
        }
    }
    if let Some(rig) = arguments.rig {
        line.push_str(&format!(" --rig {}", Rig::from(rig).name()));
    }
    for (flag, path) in [
        ("--model", &arguments.model),
        ("--controller-model", &arguments.controller_model),
        ("--script", &arguments.script),
    ] {
        if let Some(path) = path {
            line.push_str(&format!(" {flag} {}", path.display()));
        }
    }
    line
}

fn log_path(path: &Path, controller: &str, several: bool) -> PathBuf {
    if !several {
        return path.to_owned();
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let (plain, compression) = name.strip_suffix(".gz").map_or((&*name, ""), |plain| (plain, ".gz"));
    let (stem, extension) = plain.rfind('.').map_or((plain, ""), |dot| plain.split_at(dot));
    path.with_file_name(format!("{stem}-{controller}{extension}{compression}"))
}

fn write_log(path: &Path, flown: &FlownController) -> Result<(), Failure> {
    let mut log = flight_log(&flown.flight.record, flown.setup.choice.rate_hz);
    let summary = &flown.flight.summary;
    log.comments = vec![
        "SYNTHETIC: a simulated flight (sil fly), measured nowhere".to_owned(),
        format!(
            "model: {}; controller: {} at {} Hz; seed {}",
            summary.model, summary.controller, summary.rate_hz, summary.seed
        ),
    ];
    make_folder(path)?;
    sil_host::log::write_file(&log, path).map_err(failed)
}
