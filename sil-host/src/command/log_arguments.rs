//! The arguments of every command that takes a measured log: the log, what its columns mean, and what made it.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sil_host::closed_loop::LogRefused;
use sil_host::controller_file::ControllerChoice;
use sil_host::log::flown::Flown;
use sil_host::log::{self, Log, Map, sanity};
use sil_host::model::{BenchModel, Rig, VehicleModel};

use super::output::STANDARD_STREAM;
use super::{Failure, bad_input, vehicle_model};

// A doc comment here would stand in the place of the command's own help.
#[derive(Args)]
pub struct LogArguments {
    /// The log: CSV, ULog (PX4), DataFlash (ArduPilot), Blackbox (Betaflight, INAV) or usdlog (Crazyflie), each
    /// compressed by gzip or not; - reads it from stdin
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// What the log's columns mean: a file, or a map that ships (antx, crazyflie_arplab, crazypad_controller,
    /// crazypad_motor, sharif, sharif_pitch, sharif_roll_pitch, sharif_yaw)
    #[arg(long, value_name = "MAP")]
    map: Option<String>,
    /// Only the rows from this time on, s
    #[arg(long, value_name = "S")]
    from: Option<f64>,
    /// Only the rows up to this time, s
    #[arg(long, value_name = "S")]
    to: Option<f64>,
    /// Only this flight of a log that holds several, counted from 1 [default: all that flew]
    #[arg(long, value_name = "N", conflicts_with_all = ["from", "to", "whole"])]
    flight: Option<usize>,
    /// All rows, also those on the ground or with idle motors; with --from or --to nothing else is cut
    #[arg(long)]
    whole: bool,
    /// Compare even if the log contradicts its labels (a unit, a sign, an axis, the motors' order)
    #[arg(long)]
    unchecked: bool,
    /// Model of the vehicle or of the bench [default: diagnose identifies a foreign log's vehicle first, and takes the
    /// project's F450 for the project's own logs where that fits]
    #[arg(long, value_name = "M.toml")]
    model: Option<PathBuf>,
    /// Which rig held the vehicle [default: axis for a log read by a map or without motors, else the model's]
    #[arg(long, value_enum)]
    rig: Option<LogRig>,
    /// Controller that flew: pid, mpc, or a controller file; without it the controller is not examined
    #[arg(long, value_name = "CONFIG.toml|pid|mpc")]
    controller: Option<String>,
}

/// The rigs that a log can come from.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum LogRig {
    /// The thesis' testbed
    Gimbal,
    /// Free flight
    Free,
    /// Any bench: each axis a rigid body of unit inertia with one input gain, fitted to the log
    Axis,
}

impl LogArguments {
    /// Reads the log, or the part of it that was requested.
    pub fn read(&self) -> Result<Log, Failure> {
        self.read_other(&self.log)
    }

    /// Reads another log of the same kind, the same part of it.
    pub fn read_other(&self, path: &Path) -> Result<Log, Failure> {
        let map = self.map.as_deref().map(Map::load).transpose().map_err(bad_input)?;
        let log = if path == Path::new(STANDARD_STREAM) {
            log::read_from(Path::new("stdin"), &mut std::io::stdin().lock(), map.as_ref())
        } else {
            log::read(path, map.as_ref())
        };
        let log = log.map_err(bad_input)?;
        let mut part = self.part(log)?;
        if self.unchecked {
            part.notes.push("not checked against itself (--unchecked)".to_owned());
            return Ok(part);
        }
        let examination = sanity::gate(&part, map.as_ref()).map_err(|error| {
            bad_input(format!("{error}\n(sil map {} drafts a map; --unchecked compares nevertheless)", path.display()))
        })?;
        part.notes.push(match examination.confirmed.as_slice() {
            [] => "too short or too quiet to check units, signs and order of its columns".to_owned(),
            confirmed => format!("checked: {}", confirmed.join("; ")),
        });
        Ok(part)
    }

    /// The rows that were requested, else what flew.
    fn part(&self, log: Log) -> Result<Log, Failure> {
        if self.from.is_some() || self.to.is_some() {
            let (from_s, to_s) = (self.from.unwrap_or(f64::NEG_INFINITY), self.to.unwrap_or(f64::INFINITY));
            return log.between(from_s, to_s).map_err(bad_input);
        }
        if self.whole {
            return Ok(log);
        }
        Flown::of(&log).part(&log, self.flight).map_err(|error| bad_input(format!("{}: {error}", log.path)))
    }

    /// Are logs to be identified as a vehicle's, and not as separate axes? The rig that was said decides, else the
    /// logs.
    pub fn is_of_vehicle(&self, logs: &[Log]) -> Result<bool, Failure> {
        if let Some(option) = self.model.as_ref().map(|_| "--model").or(self.controller_option()) {
            return Err(bad_input(format!("identify finds the vehicle by its log: leave out {option}")));
        }
        match self.rig {
            Some(LogRig::Gimbal) => Err(bad_input(
                "--rig gimbal: a vehicle on the gimbal has the project's model; `sil diagnose LOG --extended OUT.toml` \
                 gives its numbers, --rig axis those of any bench",
            )),
            Some(rig) => Ok(rig == LogRig::Free),
            None => Ok(logs.iter().all(Log::shows_a_vehicle)),
        }
    }

    /// The model of a bench that was named; none where it is of another rig, or none was.
    pub fn bench(&self) -> Result<Option<BenchModel>, Failure> {
        let Some(file) = &self.model else { return Ok(None) };
        let bench = BenchModel::load(file).map_err(bad_input)?;
        match self.rig {
            Some(rig) if bench.is_some() && rig != LogRig::Axis => {
                Err(bad_input(format!("{} is a model for the rig axis, but --rig says another", file.display())))
            }
            _ if bench.is_some() && self.controller.is_some() => {
                Err(bad_input("the rig axis has no controller to simulate: leave out --controller"))
            }
            _ => Ok(bench),
        }
    }

    /// True where a model, a rig or a controller was named: then nothing is to be guessed.
    pub fn says_what_flew(&self) -> bool {
        self.model.is_some() || self.rig.is_some() || self.controller.is_some()
    }

    /// Is the log in other people's columns or format, so that its vehicle is other people's?
    pub fn is_foreign(&self, log: &Log) -> bool {
        self.map.is_some() || log.flight_controller.is_some() || log.driven_by_axis_commands()
    }

    /// What flew, where that was said.
    pub fn controller(&self) -> Result<Option<ControllerChoice>, Failure> {
        self.controller.as_deref().map(ControllerChoice::from_argument).transpose().map_err(bad_input)
    }

    /// The failure for a log that does not fit the options given for it.
    pub fn refused(&self, log: &Log, error: &LogRefused) -> Failure {
        match (error, &self.controller) {
            (LogRefused::Setup(_), Some(controller)) => bad_input(format!("--controller {controller}: {error}")),
            _ => bad_input(format!("{}: {error}", log.path)),
        }
    }

    /// The vehicle that the log is of; none for separate axes, with which an option that `wants_vehicle` can't be
    /// given. The rig is the one that was said; else the model's; else `axis` for a log in other people's columns,
    /// which is of other people's vehicle, or without motors. For a flight controller's own log there is no default:
    /// nobody said what it is to be held against.
    pub fn vehicle(&self, log: &Log, wants_vehicle: Option<&str>) -> Result<Option<VehicleModel>, Failure> {
        if let (Some(flight_controller), None, None, None) =
            (&log.flight_controller, &self.map, &self.rig.map(|_| ()), &self.model)
        {
            let path = &log.path;
            return Err(bad_input(format!(
                "{path}: a log of {flight_controller} does not say which vehicle flew: give its model with --model, \
                 or take each axis by itself with --rig axis"
            )));
        }
        let foreign = self.map.is_some() || log.driven_by_axis_commands();
        let rig = match self.rig {
            None if foreign && self.model.is_none() => Some(LogRig::Axis),
            said => said,
        };
        let rig = match rig {
            Some(LogRig::Axis) => {
                let controller = self.controller.as_ref().map(|_| "--controller");
                return match self.model.as_ref().map(|_| "--model").or(wants_vehicle).or(controller) {
                    Some(option) => Err(bad_input(format!("--rig axis has no vehicle model: leave out {option}"))),
                    None => Ok(None),
                };
            }
            Some(LogRig::Gimbal) => Some(Rig::Gimbal),
            Some(LogRig::Free) => Some(Rig::Free),
            None => None,
        };
        vehicle_model(self.model.as_deref(), rig).map(Some)
    }

    /// The option that names a controller, where it was given.
    pub fn controller_option(&self) -> Option<&'static str> {
        self.controller.as_ref().map(|_| "--controller")
    }

    /// How the command was called, for a page that shows how to make it again.
    pub fn command(&self, name: &str) -> String {
        let mut command = format!("sil {name} {}", quoted(&self.log.display().to_string()));
        let rig = self.rig.and_then(|rig| rig.to_possible_value()).map(|value| value.get_name().to_owned());
        let model = self.model.as_ref().map(|model| model.display().to_string());
        let number = |value: Option<f64>| value.map(|value| value.to_string());
        let said = [
            ("--map", self.map.clone()),
            ("--from", number(self.from)),
            ("--to", number(self.to)),
            ("--flight", self.flight.map(|flight| flight.to_string())),
            ("--model", model),
            ("--rig", rig),
            ("--controller", self.controller.clone()),
        ];
        for (option, value) in said {
            if let Some(value) = value {
                command.push_str(&format!(" {option} {}", quoted(&value)));
            }
        }
        for (option, is_given) in [("--whole", self.whole), ("--unchecked", self.unchecked)] {
            if is_given {
                command.push_str(&format!(" {option}"));
            }
        }
        command
    }
}

/// A word for a shell.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+:=,@%".contains(c);
    if word.chars().all(is_plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}
