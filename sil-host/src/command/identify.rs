//! `sil identify`: a model of the vehicle from its own logs.

use std::path::PathBuf;

use clap::Args;
use sil_host::diagnosis::{Identification, KnownScale, identify};
use sil_host::log::Log;

use super::log_arguments::LogArguments;
use super::text_table::TextTable;
use super::{Failure, bad_input, print, write_file};

/// Make a model of a vehicle from its own logs: what each motor does, how late, how lift grows with the command
#[derive(Args)]
#[command(after_help = "Example: sil identify flight.ulg -o vehicle.toml\n\
Example: sil identify flight1.bin flight2.bin --known mass_kg=1.35 --known arm_m=0.225 -o vehicle.toml\n\
Example: sil diagnose other.ulg --model vehicle.toml\n\n\
The logs are of one vehicle in free flight, with the commands of its four motors. Each number of the file says how\n\
sure it is and where it is from; what the logs do not show is marked, with what to fly to know it.\n\
docs/identification.md explains it.")]
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
}

pub fn run(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let scale = scale(&arguments.known)?;
    arguments.log.is_identified_from()?;
    let mut logs = vec![arguments.log.read()?];
    for path in &arguments.more {
        logs.push(arguments.log.read_other(path)?);
    }
    let identified = identify(&logs, scale).map_err(|error| bad_input(format!("{}: {error}", logs[0].path)))?;
    match &arguments.out {
        Some(out) => {
            print(text(&logs, &identified))?;
            write_file(out, identified.to_toml().as_bytes())?;
            print(format!("model           {}\n", out.display()))
        }
        None => print(identified.to_toml()),
    }
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

/// What the terminal shows beside the file.
fn text(logs: &[Log], identified: &Identification) -> String {
    let mut text = String::new();
    for log in logs {
        text.push_str(&format!(
            "{}: {} rows, {:.2} s, {:.1} Hz\n",
            log.path,
            log.rows(),
            log.duration_s(),
            log.rate_hz()
        ));
        log.notes.iter().for_each(|note| text.push_str(&format!("  {note}\n")));
    }
    text.push_str(&format!("\n{}", table(identified)));
    text
}

/// The numbers, and what to fly for those that the logs do not show.
pub fn table(identified: &Identification) -> String {
    let mut table = TextTable::new(["identified", "value", "95 % interval"]);
    for number in identified.numbers.iter().filter(|number| !is_of_one_motor_and_axis(&number.name)) {
        let digits = number.own.decimals().unwrap_or(6);
        let [low, high] = number.interval();
        let mark = if number.to_fly.is_some() { "   not excited" } else { "" };
        table.row([
            format!(
                "{}{}",
                number.name,
                if number.unit.is_empty() { String::new() } else { format!(", {}", number.unit) }
            ),
            format!("{:.digits$}", number.own.value),
            format!("{low:.digits$} to {high:.digits$}{mark}"),
        ]);
    }
    let mut text = table.to_string();
    for to_fly in identified.suggestions() {
        text.push_str(&format!("to know what is not excited: {to_fly}\n"));
    }
    text
}

/// True of the twelve numbers of single motors about single axes, which stand in the file.
fn is_of_one_motor_and_axis(name: &str) -> bool {
    name.starts_with("motor") && ["roll", "pitch", "yaw"].iter().any(|axis| name.ends_with(axis))
}
