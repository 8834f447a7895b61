//! `sil fly`: the test sequence or a script, under the cascade, the MPC, or both.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use sil_host::answer::flight::flown::{FlownController, fly_one};
use sil_host::answer::flight::page::page;
use sil_host::answer::flight::text::summary_text;
use sil_host::answer::montecarlo::drawn_text;
use sil_host::flight::{LearntSummary, RunSummary};
use sil_host::flight_log::flight_log;
use sil_host::montecarlo::{Draw, Lot};

use super::flight_arguments::{FlightArguments, NamedFlight};
use super::{Failure, bad_input, failed, make_folder, print, write_file, write_json};

/// Fly the thesis' test sequence, or a script, in co-simulation
#[derive(Args)]
#[command(after_help = "Example: sil fly --controller both --rig gimbal --report out/flight.html\n\n\
A script is TOML: duration_s, then [[step]] with at_s, roll_deg, pitch_deg, yaw_rate_deg_s, throttle or (in free\n\
flight) climb_m. A controller file is TOML: controller, rate_hz, control_horizon, and [tuning] with what differs from\n\
the tuning that follows from the vehicle. docs/commands.md has both.")]
pub struct FlyArguments {
    #[command(flatten)]
    flight: FlightArguments,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Fly a vehicle out of those that the model's tolerances stand for, with the noise of that run of `sil montecarlo`
    #[arg(long, value_name = "SEED:RUN", conflicts_with = "seed")]
    draw: Option<Draw>,
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

#[derive(Serialize)]
struct FlyJson<'a> {
    runs: Vec<&'a RunSummary>,
}

pub fn run(arguments: &FlyArguments) -> Result<(), Failure> {
    let mut flown: Vec<FlownController> = Vec::new();
    for NamedFlight { name, setup, .. } in arguments.flight.flights(arguments.seed)? {
        let setup = match arguments.draw {
            None => setup,
            Some(draw) => {
                let lot = Lot::of(&setup.model).map_err(bad_input)?;
                let vehicle = lot.draw(draw).map_err(bad_input)?;
                if flown.is_empty() {
                    print(drawn_text(&lot, draw, &vehicle))?;
                }
                draw.of_flight(&setup, vehicle)
            }
        };
        flown.push(fly_one(&name, setup).map_err(bad_input)?);
    }
    print(summary_text(&flown))?;
    for one in &flown {
        print(learnt_text(&one.name, &one.flight.summary.learning))?;
    }
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

/// What was learnt in flight, a line each.
fn learnt_text(controller: &str, learnt: &[LearntSummary]) -> String {
    let line = |LearntSummary { time_s, gain: [roll, pitch], lag_s, is_flown }: &LearntSummary| {
        let lag_ms = 1e3 * lag_s;
        let what = if *is_flown { "flown with from then on" } else { "refused by the rehearsal" };
        format!(
            "{controller} at {time_s:.1} s: roll {roll:.2} and pitch {pitch:.2} times the model's acceleration per \
             torque, motors' lag {lag_ms:.0} ms; {what}\n"
        )
    };
    learnt.iter().map(line).collect()
}

/// The command that repeats this run.
fn command_line(arguments: &FlyArguments) -> String {
    let drawn = arguments.draw.map_or_else(|| format!(" --seed {}", arguments.seed), |draw| format!(" --draw {draw}"));
    format!("sil fly{}{drawn}{}", arguments.flight.controller_options(), arguments.flight.other_options())
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
