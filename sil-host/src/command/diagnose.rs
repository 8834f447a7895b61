//! `sil diagnose`: what the simulation gets wrong, its cause, the extended model, the gain on held-out data.

use std::path::{Path, PathBuf};

use clap::Args;
use sil_host::comparison::ComparisonError;
use sil_host::controller_file::ControllerChoice;
use sil_host::diagnosis::{Diagnosis, Subject, Verdict, diagnose, diagnose_flown_by};
use sil_host::log::{self, Log, Map};
use sil_host::model::{Rig, VehicleModel};

use super::log_rig::{self, LogRig};
use super::text_table::{TextTable, number};
use super::{Failure, bad_input, diagnose_report, print, vehicle_model, write_file, write_json};

/// Find what the simulation gets wrong in a measured log, and name the cause
#[derive(Args)]
#[command(
    after_help = "Example: sil diagnose out/rig.csv --report out/diagnosis.html   (sil synth out/rig.csv makes a log)\n\
Example: sil diagnose bench.csv.gz --map antx\n\n\
Each effect of the catalogue is fitted to every second window of 0.5 s and judged on the windows in between. Then\n\
`sil compare LOG --model out/extended.toml` shows what is left."
)]
pub struct DiagnoseArguments {
    /// The log: CSV or CSV.gz
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// What the log's columns mean: a file, or a map that ships (antx, crazyflie_arplab, crazypad_controller, crazypad_motor)
    #[arg(long, value_name = "MAP")]
    map: Option<String>,
    /// Vehicle model [default: the project's F450 on that rig]
    #[arg(long, value_name = "M.toml")]
    model: Option<PathBuf>,
    /// What held the vehicle [default: axis for a log read by a map or without motors, else the model's]
    #[arg(long, value_enum)]
    rig: Option<LogRig>,
    /// What flew: pid, mpc, or a controller file; without it nothing is said of the controller
    #[arg(long, value_name = "CONFIG.toml|pid|mpc")]
    controller: Option<String>,
    /// Write the model with the findings in it
    #[arg(long, value_name = "OUT.toml")]
    extended: Option<PathBuf>,
    /// Write a report for the browser
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the answer as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

pub fn run(arguments: &DiagnoseArguments) -> Result<(), Failure> {
    let map = arguments.map.as_deref().map(Map::load).transpose().map_err(bad_input)?;
    let log = log::read(&arguments.log, map.as_ref()).map_err(bad_input)?;
    let controller =
        arguments.controller.as_deref().map(ControllerChoice::from_argument).transpose().map_err(bad_input)?;
    let model = match log_rig::of(&log, arguments.rig, arguments.map.is_some(), arguments.model.is_some()) {
        Some(LogRig::Axis) if arguments.model.is_some() || arguments.extended.is_some() => {
            return Err(bad_input("--rig axis knows no vehicle: leave out --model and --extended"));
        }
        Some(LogRig::Axis) if controller.is_some() => {
            return Err(bad_input("--rig axis knows no vehicle: leave out --controller"));
        }
        Some(LogRig::Axis) => None,
        Some(LogRig::Gimbal) => Some(vehicle_model(arguments.model.as_deref(), Some(Rig::Gimbal))?),
        Some(LogRig::Free) => Some(vehicle_model(arguments.model.as_deref(), Some(Rig::Free))?),
        None => Some(vehicle_model(arguments.model.as_deref(), None)?),
    };
    let answer = match (&model, controller) {
        (Some(model), Some(choice)) => diagnose_flown_by(&log, model, choice),
        (Some(model), None) => diagnose(&log, &Subject::Vehicle(model)).map_err(ComparisonError::from),
        (None, _) => diagnose(&log, &Subject::Axes).map_err(ComparisonError::from),
    };
    let answer = answer.map_err(|error| match (&error, &arguments.controller) {
        (ComparisonError::Setup(_), Some(controller)) => bad_input(format!("--controller {controller}: {error}")),
        _ => bad_input(format!("{}: {error}", log.path)),
    })?;
    print(answer_text(&log, &answer))?;
    if let (Some(path), Some(model)) = (&arguments.extended, &model) {
        write_extended(path, model, &answer)?;
        print(format!("extended model  {}\n", path.display()))?;
    }
    if let Some(path) = &arguments.report {
        let command = format!("sil diagnose {}", arguments.log.display());
        write_file(path, diagnose_report::page(&log, &answer, &command).to_html().as_bytes())?;
        print(format!("report          {}\n", path.display()))?;
    }
    write_json(arguments.json.as_deref(), &answer)
}

fn write_extended(path: &Path, model: &VehicleModel, answer: &Diagnosis) -> Result<(), Failure> {
    let extended = answer.extended(model).map_err(bad_input)?;
    write_file(path, extended.to_toml().as_bytes())
}

fn answer_text(log: &Log, answer: &Diagnosis) -> String {
    let mut text = format!("{}: {} rows, {:.2} s, {:.1} Hz\n", log.path, log.rows(), log.duration_s(), log.rate_hz());
    for note in &log.notes {
        text.push_str(&format!("  {note}\n"));
    }
    text.push_str(&verdict_text(answer));
    text
}

/// What was found, and how much better the model predicts with it.
pub fn verdict_text(answer: &Diagnosis) -> String {
    let mut text = String::from(match answer.verdict {
        Verdict::NoDiscrepancy => "\nThe simulation agrees with this log: what is left is noise.\n",
        Verdict::Explained => "\nWhat the simulation gets wrong here, and all of it:\n",
        Verdict::PartlyExplained => "\nWhat the simulation gets wrong here, but not all of it:\n",
        Verdict::UnknownEffect => {
            "\nThe simulation misses something in this log that no effect of the catalogue explains.\n"
        }
    });
    for finding in &answer.findings {
        text.push_str(&format!("  {:5.1} %  {}\n", finding.gain_pct, finding.statement));
    }
    if !answer.unexplained.signature.is_empty() {
        text.push_str(&format!("  left over: {}\n", answer.unexplained.signature));
    }
    for rejected in answer.rejected.iter().filter(|rejected| rejected.effect == "controller_mismatch") {
        text.push_str(&format!("  controller: {}\n", rejected.reason));
    }
    let errors = &answer.prediction_error;
    let title = format!("open loop over {} s, held-out windows, RMSE", errors.window_s);
    let mut table = TextTable::new([title.as_str(), "roll, deg", "pitch, deg", "p, deg/s", "q, deg/s"]);
    let rows = [
        ("nominal model", errors.nominal),
        ("with the findings", errors.extended),
        ("an exact model", errors.noise_floor),
    ];
    for (name, errors) in rows {
        table.row([
            name.to_owned(),
            number(errors.roll_deg, 3),
            number(errors.pitch_deg, 3),
            number(errors.p_deg_s, 3),
            number(errors.q_deg_s, 3),
        ]);
    }
    text.push_str(&format!("\n{table}\n"));
    if let Some(closed_loop) = &answer.closed_loop {
        let mut table = TextTable::new(["closed loop, mean |simulated - measured|", "roll, deg", "pitch, deg"]);
        for (name, deviation) in [("nominal model", closed_loop.nominal), ("with the findings", closed_loop.extended)] {
            table.row([name.into(), number(deviation.roll_mean_abs_deg, 2), number(deviation.pitch_mean_abs_deg, 2)]);
        }
        text.push_str(&format!("{table}\n"));
    }
    text
}
