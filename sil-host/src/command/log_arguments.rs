//! The arguments of every command that takes a measured log: the log, what its columns mean, and what made it.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sil_host::answer::{Said, SaidModel, SaidRig};
use sil_host::controller_file::ControllerChoice;
use sil_host::log::{self, Log, Map, Rows, Wanted};
use sil_host::model::Rig;

use super::output::STANDARD_STREAM;
use super::progress_line::ProgressLine;
use super::{Failure, bad_input};

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
    /// Turn the log's body axes about yaw, clockwise seen from above, so that the motors stand as an X: 45 for a plus
    /// frame. Where the log's head or the map says so, it is done without this
    #[arg(long, value_name = "DEG")]
    frame_turn: Option<f64>,
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
    /// Model of the vehicle or of the bench [default: a foreign flight's vehicle is identified from the log first; the
    /// project's F450 serves the project's own logs where it fits; else each axis by itself]
    #[arg(long, value_name = "M.toml")]
    model: Option<PathBuf>,
    /// Which rig held the vehicle [default: the model's; without a model as the log shows]
    #[arg(long, value_enum)]
    rig: Option<LogRig>,
    /// Controller that flew: pid, mpc, or a controller file; without it the controller is not examined. `compare` takes
    /// several, and shows what each makes of the log's references
    #[arg(long, value_name = "CONFIG.toml|pid|mpc")]
    controller: Vec<String>,
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

impl From<LogRig> for SaidRig {
    fn from(rig: LogRig) -> SaidRig {
        match rig {
            LogRig::Gimbal => SaidRig::Vehicle(Rig::Gimbal),
            LogRig::Free => SaidRig::Vehicle(Rig::Free),
            LogRig::Axis => SaidRig::Axis,
        }
    }
}

impl LogArguments {
    /// The log's path, as it was given.
    pub fn path(&self) -> &Path {
        &self.log
    }

    /// Reads a log as requested, or the part of it that was.
    pub fn read(&self, path: &Path) -> Result<Log, Failure> {
        let wanted = self.wanted()?;
        if path == Path::new(STANDARD_STREAM) {
            return wanted.read(Path::new("stdin"), &mut std::io::stdin().lock()).map_err(bad_input);
        }
        let log = {
            let line = ProgressLine::new();
            log::read_observed(path, wanted.map.as_ref(), &|done, of| line.show_read(done, of)).map_err(bad_input)?
        };
        wanted.of(log).map_err(bad_input)
    }

    /// The same, and of a long log no more than is examined. Gaps would end a controller's replay: where one is named,
    /// the log stays whole.
    pub fn read_examined(&self, path: &Path) -> Result<Log, Failure> {
        let log = self.read(path)?;
        Ok(if self.controller.is_empty() { log.examined() } else { log })
    }

    /// What of a log was requested.
    fn wanted(&self) -> Result<Wanted, Failure> {
        let map = self.map.as_deref().map(Map::load).transpose().map_err(bad_input)?;
        let rows = match (self.from, self.to, self.flight) {
            (None, None, _) if self.whole => Rows::All,
            (None, None, Some(number)) => Rows::Flight(number),
            (None, None, None) => Rows::Flown,
            (from, to, _) => Rows::Between(from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY)),
        };
        let frame_turn_deg = self.frame_turn.unwrap_or(0.0);
        if !(-360.0..=360.0).contains(&frame_turn_deg) {
            return Err(bad_input(format!("--frame-turn {frame_turn_deg}: expected an angle of -360 to 360 degrees")));
        }
        Ok(Wanted { map, frame_turn_deg, rows, unchecked: self.unchecked })
    }

    /// What was said of the vehicle and of the one controller that flew it.
    pub fn said(&self) -> Result<Said, Failure> {
        match self.controller.as_slice() {
            [_, second, ..] => {
                Err(bad_input(format!("--controller {second}: one controller flew a log; `sil compare` takes several")))
            }
            _ => self.said_of_several().map(|(said, _)| said),
        }
    }

    /// The same with all controllers, of which it has the first.
    pub fn said_of_several(&self) -> Result<(Said, Vec<(String, ControllerChoice)>), Failure> {
        let model = |file: &PathBuf| Ok((file.display().to_string(), SaidModel::load(file).map_err(bad_input)?));
        let controller = |name: &String| Ok((name.clone(), ControllerChoice::from_argument(name).map_err(bad_input)?));
        if let Some(again) = (1..).zip(&self.controller).find(|(rest, name)| self.controller[*rest..].contains(name)) {
            return Err(bad_input(format!("--controller {} was given before", again.1)));
        }
        let controllers = self.controller.iter().map(controller).collect::<Result<Vec<_>, _>>()?;
        let said = Said {
            is_mapped: self.map.is_some(),
            rig: self.rig.map(SaidRig::from),
            model: self.model.as_ref().map(model).transpose()?,
            controller: controllers.first().cloned(),
        };
        Ok((said, controllers))
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

    /// Was it said what carries the vehicle?
    pub fn names_a_rig(&self) -> bool {
        self.rig.is_some()
    }

    /// The option that names a controller, where it was given.
    pub fn controller_option(&self) -> Option<&'static str> {
        self.controller.first().map(|_| "--controller")
    }

    /// How the command was called, for a page that shows how to make it again.
    pub fn command(&self, name: &str, more: &[PathBuf]) -> String {
        let mut command = format!("sil {name}");
        for log in [&self.log].into_iter().chain(more) {
            command.push_str(&format!(" {}", quoted(&log.display().to_string())));
        }
        let rig = self.rig.and_then(|rig| rig.to_possible_value()).map(|value| value.get_name().to_owned());
        let model = self.model.as_ref().map(|model| model.display().to_string());
        let number = |value: Option<f64>| value.map(|value| value.to_string());
        let said = [
            ("--map", self.map.clone()),
            ("--frame-turn", number(self.frame_turn)),
            ("--from", number(self.from)),
            ("--to", number(self.to)),
            ("--flight", self.flight.map(|flight| flight.to_string())),
            ("--model", model),
            ("--rig", rig),
        ];
        let controllers = self.controller.iter().map(|name| ("--controller", Some(name.clone())));
        for (option, value) in said.into_iter().chain(controllers) {
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
