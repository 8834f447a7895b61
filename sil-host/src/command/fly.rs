//! `sil fly`: the test sequence or a script, under the cascade, the MPC, or both.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::RangedU64ValueParser;
use serde::Serialize;
use shared_control::config::Controller;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::{Flight, FlightSetup, RunSummary};
use sil_host::flight_log::flight_log;
use sil_host::margins::Margins;
use sil_host::model::Rig;
use sil_host::scenario::Scenario;

use super::figures::{FOLLOWING, Figure, ROBUSTNESS, WHOLE_FLIGHT, eigenvalues_text};
use super::text_table::{TextTable, number};
use super::{
    Failure, RigArgument, bad_input, failed, flight_report, make_folder, print, vehicle_model, write_file, write_json,
};

/// Fly the thesis' test sequence, or a script, in co-simulation
#[derive(Args)]
#[command(after_help = "Example: sil fly --controller both --rig gimbal --report out/flight.html\n\n\
A script is TOML: duration_s, then [[step]] with at_s, roll_deg, pitch_deg, yaw_rate_deg_s, throttle or (in free\n\
flight) climb_m. A controller file is TOML: controller, rate_hz, control_horizon, and [tuning] with what differs from\n\
the tuning that follows from the vehicle. docs/commands.md has both.")]
pub struct FlyArguments {
    /// Which controller flies: the PID cascade of APM:Copter, model predictive control with the cascade as fallback,
    /// one after the other, or what a file says
    #[arg(long, value_name = "pid|mpc|both|C.toml", default_value = BOTH)]
    controller: String,
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
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    prediction_step: Option<f32>,
    /// Write the flight as a log; with both controllers OUT-pid.csv and OUT-mpc.csv
    #[arg(long, value_name = "OUT.csv")]
    log: Option<PathBuf>,
    /// Write a report with plots
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the figures as JSON
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

/// A flight with what was measured around it.
pub struct FlownController {
    /// How it was set up.
    pub setup: FlightSetup,
    /// Series and figures.
    pub flight: Flight,
    /// Margins of roll and pitch; none if the loop oscillates by itself.
    pub margins: Option<[Margins; 2]>,
    /// Eigenvalues of roll and pitch under the unconstrained MPC.
    pub eigenvalues: Option<[[[f64; 2]; 4]; 2]>,
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
        .map(|choice| {
            fly_one(FlightSetup {
                model: model.clone(),
                controller_model: controller_model.clone(),
                choice,
                scenario: scenario.clone(),
                seed: arguments.seed,
            })
        })
        .collect::<Result<_, _>>()?;
    print(summary_text(&flown))?;
    for one in &flown {
        if let Some(path) = &arguments.log {
            let path = log_path(path, one.setup.choice.name(), flown.len() > 1);
            write_log(&path, one)?;
            print(format!("log     {}\n", path.display()))?;
        }
    }
    if let Some(path) = &arguments.report {
        write_file(path, flight_report::page(&flown, &command_line(arguments)).to_html().as_bytes())?;
        print(format!("report  {}\n", path.display()))?;
    }
    write_json(arguments.json.as_deref(), &FlyJson { runs: flown.iter().map(|one| &one.flight.summary).collect() })
}

/// The controllers asked for, with what the command line says of them.
fn choices(arguments: &FlyArguments) -> Result<Vec<ControllerChoice>, Failure> {
    let mut choices = match arguments.controller.as_str() {
        BOTH => [Controller::Cascade, Controller::Mpc].map(ControllerChoice::nominal).to_vec(),
        argument => vec![ControllerChoice::from_argument(argument).map_err(bad_input)?],
    };
    for choice in &mut choices {
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

/// Flies one controller and measures its margins.
pub fn fly_one(setup: FlightSetup) -> Result<FlownController, Failure> {
    let flight = setup.fly().map_err(bad_input)?;
    let margins = setup.margins().map_err(bad_input)?;
    let eigenvalues = setup.mpc_eigenvalues().map_err(bad_input)?;
    Ok(FlownController { setup, flight, margins, eigenvalues })
}

/// The command that repeats this run.
fn command_line(arguments: &FlyArguments) -> String {
    let mut line = format!("sil fly --controller {} --seed {}", arguments.controller, arguments.seed);
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

/// What the terminal shows.
pub fn summary_text(flown: &[FlownController]) -> String {
    let Some(first) = flown.first() else { return String::new() };
    let scenario = &first.setup.scenario;
    let mut text = format!(
        "{}: {}, {} s, seed {}\n\n",
        first.setup.model.name, scenario.name, scenario.duration_s, first.setup.seed
    );
    text.push_str(&axis_table(flown).to_string());
    text.push('\n');
    text.push_str(&flight_table(flown).to_string());
    for one in flown {
        let Some(eigenvalues) = one.eigenvalues else { continue };
        text.push_str(&format!("\n{}, |z| and angle per step:\n", eigenvalues_title(one)));
        for (name, axis) in ["roll", "pitch"].into_iter().zip(eigenvalues) {
            text.push_str(&format!("  {name:<6} {}\n", eigenvalues_text(axis).join(", ")));
        }
    }
    for remark in flown.iter().flat_map(remarks) {
        text.push_str(&format!("\n{remark}\n"));
    }
    text.push('\n');
    text
}

/// What the eigenvalues are of.
pub fn eigenvalues_title(flown: &FlownController) -> String {
    let period_ms = 1e3 / f64::from(flown.setup.choice.rate_hz);
    format!("closed-loop eigenvalues of the unconstrained MPC, one step = {period_ms} ms")
}

/// What somebody who reads the figures must know.
pub fn remarks(flown: &FlownController) -> Vec<String> {
    let name = flown.setup.choice.name();
    let summary = &flown.flight.summary;
    let mut remarks = Vec::new();
    if flown.flight.record.ended_early {
        remarks.push(format!(
            "{name}: the flight ended after {:.2} s, the state was no longer finite.",
            summary.duration_s
        ));
    }
    if flown.margins.is_none() {
        remarks.push(format!("{name}: at hover the loop oscillates by itself, so it has no margins."));
    }
    let unstable = |axes: &[[[f64; 2]; 4]; 2]| axes.iter().any(|axis| axis[0][0] >= 1.0);
    if flown.eigenvalues.as_ref().is_some_and(unstable) {
        remarks.push(format!("{name}: without active bounds this loop is unstable, an eigenvalue has |z| >= 1."));
    }
    let axes = [summary.axes.roll, summary.axes.pitch];
    if flown.setup.model.rig() == Rig::Free && axes.iter().any(|axis| axis.settling_time_s.is_none()) {
        remarks.push(format!(
            "{name}: in still air the accelerometer of a tilted vehicle measures its thrust, which the estimator takes \
             for gravity; the estimate, and with it the vehicle, drifts a few degrees towards level while a tilt is \
             held."
        ));
    }
    remarks
}

fn axis_table(flown: &[FlownController]) -> TextTable {
    let columns =
        flown.iter().flat_map(|one| ["roll", "pitch"].map(|axis| format!("{} {axis}", one.setup.choice.name())));
    let mut table = TextTable::new([String::new()].into_iter().chain(columns));
    for figure in FOLLOWING {
        let axes = flown.iter().flat_map(|one| [one.flight.summary.axes.roll, one.flight.summary.axes.pitch]);
        let cells = axes.map(|axis| number((figure.value)(&axis), figure.decimals));
        table.row([figure.name.to_owned()].into_iter().chain(cells));
    }
    for figure in ROBUSTNESS {
        let cells =
            flown.iter().flat_map(|one| margin_values(one, &figure).map(|value| number(value, figure.decimals)));
        table.row([figure.name.to_owned()].into_iter().chain(cells));
    }
    table
}

/// A margin of roll and pitch, none where the loop has none.
pub fn margin_values(flown: &FlownController, figure: &Figure<Margins>) -> [Option<f64>; 2] {
    flown.margins.map_or([None; 2], |axes| axes.map(|margins| (figure.value)(&margins)))
}

fn flight_table(flown: &[FlownController]) -> TextTable {
    let names = flown.iter().map(|one| one.setup.choice.name().to_owned());
    let mut table = TextTable::new([String::new()].into_iter().chain(names));
    for figure in WHOLE_FLIGHT {
        let cells = flown.iter().map(|one| (figure.text)(&one.flight.summary));
        table.row([figure.name.to_owned()].into_iter().chain(cells));
    }
    let speeds = flown.iter().map(|one| number(one.flight.summary.real_time_factor, 0));
    table.row(["simulated, times real time".to_owned()].into_iter().chain(speeds));
    table
}
