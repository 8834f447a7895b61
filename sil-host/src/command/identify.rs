//! `sil identify`: a model of the vehicle, or of the bench, from its own logs.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use sil_host::answer::board_parameters::{board_parameters, params_file};
use sil_host::answer::identified::{table, table_of};
use sil_host::diagnosis::{Holding, Identified, KnownScale, NotIdentified, identify_axes_observed, identify_observed};
use sil_host::log::Log;

use super::log_arguments::LogArguments;
use super::progress_line::ProgressLine;
use super::{Failure, bad_input, print, to_stdout, write_file, write_json};

/// Make a model of a vehicle from its own logs: what each motor does, how late, how lift grows with the command
#[derive(Args)]
#[command(after_help = "Example: sil identify flight.ulg -o vehicle.toml\n\
Example: sil identify flight1.bin flight2.bin --known mass_kg=1.35 --known arm_m=0.225 -o vehicle.toml\n\
Example: sil identify bench.csv.gz --map antx -o bench.toml\n\
Example: sil identify flight.bin --known mass_kg=1.35 --known arm_m=0.225 --params vehicle.params\n\
Example: sil diagnose other.ulg --model vehicle.toml\n\n\
All logs are of one vehicle. A free flight with the commands of four motors gives a vehicle; any other log, and a\n\
flight that shows no vehicle, gives separate axes. Each number of the file says how sure it is; what the logs do not\n\
show is marked, with what to fly to know it. docs/identification.md explains it.")]
pub struct IdentifyArguments {
    #[command(flatten)]
    log: LogArguments,
    /// More logs of the same vehicle, fitted together with the first
    #[arg(value_name = "MORE")]
    more: Vec<PathBuf>,
    /// What was weighed or measured, so that the numbers are absolute: mass_kg=VALUE, arm_m=VALUE (motor to centre)
    #[arg(long, value_name = "NAME=VALUE")]
    known: Vec<String>,
    /// Write the model here instead of on the terminal
    #[arg(short, long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
    /// Write the parameters with which a board flies this vehicle, as a ground station loads them
    #[arg(long, value_name = "OUT.params")]
    params: Option<PathBuf>,
    /// Write the numbers as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// What stands in the JSON.
#[derive(Serialize)]
struct Answer {
    /// The logs, and what was used of them.
    source: String,
    /// What they show.
    numbers: Vec<Identified>,
    /// Disturbances that last and that the commands hold against.
    holding: Vec<Holding>,
}

/// A model, as a table and as a file, and its numbers.
struct Made {
    shown: String,
    toml: String,
    answer: Answer,
    /// What a board flies it with, or why none can; of a vehicle.
    parameters: Option<Result<String, String>>,
}

pub fn run(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let scale = scale(&arguments.known)?;
    let mut logs = vec![arguments.log.read_examined(arguments.log.path())?];
    for path in &arguments.more {
        logs.push(arguments.log.read_examined(path)?);
    }
    let refused = |error: NotIdentified| bad_input(format!("{}: {error}", logs[0].path));
    let is_of_vehicle = arguments.log.is_of_vehicle(&logs)?;
    let (note, made) = match is_of_vehicle.then(|| vehicle(&logs, scale)) {
        None => (None, axes_asked_for(arguments, &logs)?.map_err(refused)?),
        Some(Ok(made)) => (None, made),
        // what no vehicle can be had from may show what the commands do about each axis
        Some(Err(error)) => match axes_of_flight(arguments, &logs, &error) {
            Some(axes) => (Some(format!("no vehicle could be identified: {error}; instead each axis by itself")), axes),
            None => return Err(refused(error)),
        },
    };
    let Made { shown, toml, answer, parameters } = made;
    let of_note = |start: &str| note.as_ref().map(|note| format!("{start}{note}\n")).unwrap_or_default();
    let toml = of_note("# ") + &toml;
    match &arguments.out {
        Some(out) => {
            print(format!("{}{}\n{shown}", heads(&logs), of_note("")))?;
            write_file(out, toml.as_bytes())?;
            print(format!("model           {}\n", out.display()))?;
        }
        // the model is the result, unless its numbers were requested
        None if arguments.json.is_none() => to_stdout(toml)?,
        None => print(toml)?,
    }
    write_json(arguments.json.as_deref(), &answer)?;
    // last, so that model and numbers are there where a board can't fly them
    match (&arguments.params, parameters) {
        (Some(path), Some(parameters)) => write_file(path, parameters.map_err(bad_input)?.as_bytes()),
        _ => Ok(()),
    }
}

/// A vehicle of logs, and the parameters for a board to fly it.
fn vehicle(logs: &[Log], scale: KnownScale) -> Result<Made, NotIdentified> {
    let line = ProgressLine::new();
    let identified = identify_observed(logs, scale, &|progress| line.show(progress))?;
    drop(line);
    let not_for_a_board =
        |reason| format!("--params: {reason}; without --params, what these logs do not show is marked");
    let parameters = board_parameters(&identified.model).map_err(not_for_a_board);
    let parameters = parameters.map(|parameters| params_file(&identified.source, &parameters));
    let (shown, toml) = (table(&identified), identified.to_toml());
    Ok(Made {
        shown,
        toml,
        answer: Answer { source: identified.source, numbers: identified.numbers, holding: Vec::new() },
        parameters: Some(parameters),
    })
}

/// Separate axes, which have no scale and fly no board.
fn axes_asked_for(arguments: &IdentifyArguments, logs: &[Log]) -> Result<Result<Made, NotIdentified>, Failure> {
    if let Some(known) = arguments.known.first() {
        return Err(bad_input(format!("--known {known}: separate axes have neither mass nor arm: leave it out")));
    }
    if arguments.params.is_some() {
        return Err(bad_input("--params: separate axes are no vehicle that a board could fly"));
    }
    Ok(axes(logs))
}

fn axes(logs: &[Log]) -> Result<Made, NotIdentified> {
    let line = ProgressLine::new();
    let identified = identify_axes_observed(logs, &|progress| line.show(progress))?;
    let (shown, toml) = (table_of(&identified.numbers), identified.to_toml());
    Ok(Made {
        shown,
        toml,
        answer: Answer { source: identified.source, numbers: identified.numbers, holding: identified.holding },
        parameters: None,
    })
}

/// Separate axes of a flight that gave no vehicle, where nothing was asked for that only a vehicle has, and where they
/// show what the commands do about roll or pitch.
fn axes_of_flight(arguments: &IdentifyArguments, logs: &[Log], error: &NotIdentified) -> Option<Made> {
    let asks_for_vehicle = !arguments.known.is_empty() || arguments.params.is_some() || arguments.log.names_a_rig();
    let may_be = matches!(error, NotIdentified::Quiet(_) | NotIdentified::AtOnce(_) | NotIdentified::Held(_));
    let made = (may_be && !asks_for_vehicle).then(|| axes(logs).ok())??;
    let shows = |number: &Identified| number.is_of_tilt() && number.to_fly.is_none();
    made.answer.numbers.iter().any(shows).then_some(made)
}

/// What gives the numbers a scale.
fn scale(known: &[String]) -> Result<KnownScale, Failure> {
    let mut scale = KnownScale::default();
    for text in known {
        let wrong = || bad_input(format!("--known {text}: expected mass_kg=VALUE (kg) or arm_m=VALUE (m), above 0"));
        let (name, value) = text.split_once('=').ok_or_else(wrong)?;
        let value = value.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
        let place = match name.trim() {
            "mass_kg" => &mut scale.mass_kg,
            "arm_m" => &mut scale.arm_m,
            _ => return Err(wrong()),
        };
        *place = Some(value.ok_or_else(wrong)?);
    }
    Ok(scale)
}

/// The logs, and what was taken of each.
fn heads(logs: &[Log]) -> String {
    let mut text = String::new();
    for log in logs {
        let (rows, duration_s, rate_hz) = (log.rows(), log.duration_s(), log.rate_hz());
        text.push_str(&format!("{}: {rows} rows, {duration_s:.2} s, {rate_hz:.1} Hz\n", log.path));
        log.notes.iter().for_each(|note| text.push_str(&format!("  {note}\n")));
    }
    text
}
