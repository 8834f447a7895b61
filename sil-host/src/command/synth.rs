//! `sil synth`: a rig log with chosen effects, for tests and for learning.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use sil_host::controller_file::ControllerChoice;
use sil_host::effects::Effect;
use sil_host::model::SensorNoise;
use sil_host::synthesis::Synthesis;

use super::{Failure, RigArgument, bad_input, failed, make_folder, print, vehicle_model, write_json};

/// Make a synthetic rig log with chosen effects, noise and rates
#[derive(Args)]
#[command(after_help = examples())]
pub struct SynthArguments {
    /// What the vehicle does beyond its model, as NAME:KEY=VALUE,...; may be given several times
    #[arg(long, value_name = "EFFECT")]
    effect: Vec<String>,
    /// Length of the log, s
    #[arg(long, value_name = "S", default_value_t = 29.75)]
    duration: f64,
    /// Rows per second
    #[arg(long, value_name = "HZ", default_value_t = 200, value_parser = clap::value_parser!(u32).range(10..=1000))]
    rate: u32,
    /// Steps of the controller per second
    /// [default: that of the controller file, else the larger of 400 and the log's rate]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(50..=1000))]
    control_rate: Option<u32>,
    /// Collective command at hover, 0..1 [default: the model's]
    #[arg(long, value_name = "C")]
    throttle: Option<f64>,
    /// Standard deviations of attitude and gyro [default: the model's]
    #[arg(long, value_name = "ANGLE_RAD,RATE_RAD_S")]
    noise: Option<String>,
    /// Delay each row by |N(0, S)|, s
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    jitter: f64,
    /// Leave out this share of the rows, at random
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    drop_out: f64,
    /// Log the battery's voltage even where no effect depends on it
    #[arg(long)]
    battery: bool,
    /// Write nothing into the log's comments but that it is synthetic
    #[arg(long)]
    blind: bool,
    /// Seed of noise, jitter and drop-outs
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// What flies: pid, mpc, or a controller file
    #[arg(long, value_name = "pid|mpc|CONFIG.toml", default_value = "pid")]
    controller: String,
    /// Which rig holds the vehicle [default: that of the model, else gimbal]
    #[arg(long, value_enum)]
    rig: Option<RigArgument>,
    /// Vehicle model [default: the project's F450 on that rig]
    #[arg(long, value_name = "M.toml")]
    model: Option<PathBuf>,
    /// Write rows, length and rate as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    /// The log to write
    #[arg(value_name = "OUT.csv")]
    out: PathBuf,
}

fn examples() -> String {
    format!(
        "Example: sil synth --effect \"cg_offset:axis=pitch,cos_moment_nm=0.1\" --rate 200 --seed 3 out/rig.csv\n\n\
         Effects, with all of their parameters:\n{}",
        Effect::help()
    )
}

#[derive(Serialize)]
struct SynthJson {
    log: LogJson,
}

/// As in the JSON of `sil diagnose`.
#[derive(Serialize)]
struct LogJson {
    path: String,
    rows: usize,
    duration_s: f64,
    rate_hz: f64,
}

pub fn run(arguments: &SynthArguments) -> Result<(), Failure> {
    let mut model = vehicle_model(arguments.model.as_deref(), arguments.rig.map(Into::into))?;
    for text in &arguments.effect {
        let effect = Effect::parse_for(text, model.rig(), model.inertia_kg_m2);
        model.effects.push(effect.map_err(|problem| bad_input(format!("--effect {text}: {problem}")))?);
    }
    let mut choice = ControllerChoice::from_argument(&arguments.controller).map_err(bad_input)?;
    let named = matches!(arguments.controller.as_str(), "pid" | "mpc");
    // a file says at what rate its controller flew; a name does not
    let usual_hz = if named { choice.rate_hz.max(arguments.rate) } else { choice.rate_hz };
    choice.rate_hz = arguments.control_rate.unwrap_or(usual_hz);
    check(arguments, choice.rate_hz)?;
    let noise = arguments.noise.as_deref().map(|text| noise(text, &model.noise)).transpose()?;
    let synthesis = Synthesis {
        choice,
        duration_s: arguments.duration,
        log_rate_hz: arguments.rate,
        throttle: arguments.throttle,
        noise,
        jitter_s: arguments.jitter,
        drop_out_share: arguments.drop_out,
        battery: arguments.battery,
        blind: arguments.blind,
        seed: arguments.seed,
        ..Synthesis::of(model)
    };
    let log = synthesis.log().map_err(|error| bad_input(format!("--controller {}: {error}", arguments.controller)))?;
    make_folder(&arguments.out)?;
    sil_host::log::write_file(&log, &arguments.out).map_err(failed)?;
    let path = arguments.out.display().to_string();
    print(format!("{}\nlog     {path} ({} rows)\n", log.comments.join("\n"), log.rows()))?;
    let log = LogJson { path, rows: log.rows(), duration_s: log.duration_s(), rate_hz: log.rate_hz() };
    write_json(arguments.json.as_deref(), &SynthJson { log })
}

fn check(arguments: &SynthArguments, control_rate_hz: u32) -> Result<(), Failure> {
    if !(arguments.duration >= 1.0 && arguments.duration <= 3600.0) {
        return Err(bad_input(format!("--duration {}: expected 1 to 3600 s", arguments.duration)));
    }
    if arguments.rate > control_rate_hz {
        return Err(bad_input(format!(
            "--rate {}: a row needs a control step, and there are {control_rate_hz} a second (--control-rate)",
            arguments.rate
        )));
    }
    if !(0.0..=0.1).contains(&arguments.jitter) {
        return Err(bad_input(format!("--jitter {}: expected 0 to 0.1 s", arguments.jitter)));
    }
    if !(0.0..=0.9).contains(&arguments.drop_out) {
        return Err(bad_input(format!("--drop-out {}: expected 0 to 0.9 of the rows", arguments.drop_out)));
    }
    match arguments.throttle {
        Some(throttle) if !(0.05..=0.95).contains(&throttle) => {
            Err(bad_input(format!("--throttle {throttle}: expected 0.05 to 0.95")))
        }
        _ => Ok(()),
    }
}

fn noise(text: &str, model: &SensorNoise) -> Result<SensorNoise, Failure> {
    let problem = || bad_input(format!("--noise {text}: expected two numbers from 0 to below 1, ANGLE_RAD,RATE_RAD_S"));
    let (angle, rate) = text.split_once(',').ok_or_else(problem)?;
    let parse =
        |part: &str| part.trim().parse::<f64>().ok().filter(|value| (0.0..1.0).contains(value)).ok_or_else(problem);
    Ok(SensorNoise { attitude_rad: parse(angle)?, gyro_rad_s: parse(rate)?, ..*model })
}
