//! Logs of flights and rigs as columns, read from CSV and from flight controllers' own formats, and written.
//!
//! The formats, their names and errors are docs/log-format.md's. [`read`] takes a file in any of them, or any other CSV
//! with a [`Map`] that says what its columns mean; [`write_file`] writes one. In memory everything is in SI units and
//! in the frames of docs/rig.md (body forward-right-down, Euler angles Z-Y-X), whatever the file had. How a flight
//! controller's streams of several rates become rows, `recording.rs` says.

mod airspeed;
mod blackbox;
mod contradiction;
mod csv;
mod dataflash;
pub mod draft;
mod error;
pub mod flown;
#[cfg(test)]
mod fuzz_seeds;
mod joined;
mod jumps;
mod long;
mod map;
mod mapped_column;
mod messages;
mod more_motors;
mod motor_order;
mod other_files;
mod outside;
mod part;
mod passage;
mod quantity;
mod quaternions;
mod rate_of_change;
mod recording;
mod rig_shown;
mod runs;
pub mod sanity;
mod source;
mod style;
mod supply;
mod time_base;
mod turned;
mod ulog;
mod usdlog;
mod wanted;
mod write;

use std::path::Path;

use crate::model::Rig;
use crate::statistics::median_step;
pub use contradiction::{Contradiction, MapLine};
pub use csv::parse;
pub use error::{LogError, LogErrorKind, ROWS_MIN};
pub use map::{BUILT_IN_MAPS, Map, Threshold};
pub use passage::ReadObserver;
use passage::{Passage, UNOBSERVED};
pub use quantity::{GRAVITY_M_S2, Quantity};
pub use recording::{Fact, FactValue, Recording, Stream, StreamColumn};
pub use rig_shown::RigShown;
pub(crate) use source::text_of;
pub(crate) use style::Style;
pub(crate) use time_base::SLOW_HZ;
pub use wanted::{NotWanted, Rows, Wanted};
pub use write::{write, write_file};

/// A format that a file may have.
struct Format {
    /// Whether a file of this path with these bytes (decompressed) has it.
    recognises: fn(&Path, &[u8]) -> bool,
    /// Reads them.
    read: Reader,
}

/// Reads the bytes of a file, whose name is for messages, and says on the way how far it is.
type Reader = fn(&str, Vec<u8>, Option<&Map>, &Passage<'_>) -> Result<Content, LogError>;

/// What a format holds.
enum Content {
    /// Rows.
    Log(Box<Log>),
    /// Streams of several rates.
    Recording(Recording),
}

/// All formats, in the order in which they are tried.
const FORMATS: [Format; 5] = [ulog::FORMAT, dataflash::FORMAT, blackbox::FORMAT, usdlog::FORMAT, csv::FORMAT];

/// Reads a log in any of the formats, compressed by gzip or not; a map says what the columns of a CSV mean whose names
/// are not those of docs/log-format.md, or which fields of a flight controller's log are taken.
///
/// # Errors
/// Whatever docs/log-format.md calls an error, with file, line and column.
pub fn read(path: &Path, map: Option<&Map>) -> Result<Log, LogError> {
    read_observed(path, map, UNOBSERVED)
}

/// The same, and says on the way how far it is.
///
/// # Errors
/// As [`read`].
pub fn read_observed(path: &Path, map: Option<&Map>, observer: ReadObserver<'_>) -> Result<Log, LogError> {
    let bytes = source::load_observed(path, observer)?;
    parse_observed(path, bytes, map, observer)
}

/// The same of a stream that is no file; the name is for messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(name: &Path, from: &mut impl std::io::Read, map: Option<&Map>) -> Result<Log, LogError> {
    parse_bytes(name, source::load_from(name, from)?, map)
}

/// The same of a file's bytes, decompressed; the path is for messages and for telling formats apart.
///
/// # Errors
/// As [`read`].
pub fn parse_bytes(path: &Path, bytes: Vec<u8>, map: Option<&Map>) -> Result<Log, LogError> {
    parse_observed(path, bytes, map, UNOBSERVED)
}

fn parse_observed(path: &Path, bytes: Vec<u8>, map: Option<&Map>, observer: ReadObserver<'_>) -> Result<Log, LogError> {
    let file = path.display().to_string();
    match content(path, &file, bytes, map, observer)? {
        Content::Log(log) => Ok(*log),
        Content::Recording(recording) => time_base::log_of(&file, recording, map),
    }
}

/// What a flight controller recorded, at its own rates, before it is brought to rows; `None` for a CSV, which is rows.
///
/// # Errors
/// As [`read`].
pub fn read_recording(path: &Path) -> Result<Option<Recording>, LogError> {
    let bytes = source::load(path)?;
    match content(path, &path.display().to_string(), bytes, None, UNOBSERVED)? {
        Content::Log(_) => Ok(None),
        Content::Recording(recording) => Ok(Some(recording)),
    }
}

fn content(
    path: &Path,
    file: &str,
    bytes: Vec<u8>,
    map: Option<&Map>,
    observer: ReadObserver<'_>,
) -> Result<Content, LogError> {
    let format = FORMATS.iter().find(|format| (format.recognises)(path, &bytes)).unwrap_or(&csv::FORMAT);
    let passage = Passage::through(bytes.len(), observer);
    (format.read)(file, bytes, map, &passage)
}

/// True for a name that ends so, whatever its case, compressed or not.
fn has_extension(path: &Path, extension: &str) -> bool {
    let name = path.to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.ends_with(&format!(".{extension}"))
}

/// A note for all gaps that cut windows, because the reader of a report should know, and one for all shorter pauses.
fn note_gaps(log: &mut Log) {
    let (longest_regular_s, longest_uncut_s) = (log.longest_regular_step_s(), log.longest_uncut_step_s());
    let steps = log.time_s.windows(2).map(|t| t[1] - t[0]);
    let (gaps, pauses): (Vec<f64>, Vec<f64>) =
        steps.filter(|step| *step > longest_regular_s).partition(|step| *step > longest_uncut_s);
    for (of, what) in [(gaps, "gap(s) in time"), (pauses, "pause(s) in time that cut nothing")] {
        if let Some(longest) = of.iter().copied().reduce(f64::max) {
            log.notes.push(format!("{} {what}, the longest of {longest:.3} s", of.len()));
        }
    }
}

/// A fast logger's pause of this length, s, leaves as much unknown as a row of a log of 25 rows/s does.
const PAUSE_S: f64 = 0.04;

/// Single rows are dropped by many loggers and cost little; five in a row are an interruption.
const GAP_STEPS: f64 = 5.0;

/// One column, a value per row; `None` where the log has none.
pub type Column = Option<Vec<f64>>;

/// A log: columns of equal length, one value per row. Arrays of three are (roll, pitch, yaw) or (x, y, z) of the
/// body, arrays of four the motors in the order of docs/rig.md.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// The file it came from, as the caller named it; empty for a log made in memory.
    pub path: String,
    /// Comment lines at the head of the file, without the `#`: where it comes from, whether it is synthetic.
    pub comments: Vec<String>,
    /// Remarks of the reader: ignored columns, gaps.
    pub notes: Vec<String>,
    /// The flight controller in whose own format it was: its vehicle is not this project's. `None` for a CSV.
    pub flight_controller: Option<String>,
    /// What such a log's head and parameters say of vehicle and controller.
    pub facts: Vec<Fact>,
    /// Which of roll, pitch and yaw the log has: by angle or rate, or as its map declares.
    pub axes: [bool; 3],
    /// Rows in which the motors run; `None` means all of them.
    pub active_when: Option<Threshold>,

    /// Time, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// Euler angles Z-Y-X, rad.
    pub angle_rad: [Column; 3],
    /// Body rates p, q, r, rad/s.
    pub rate_rad_s: [Column; 3],
    /// Motor commands 0..1; each is in force from its row to the next.
    pub motor_command: [Column; 4],
    /// Axis commands -1..1, in force from their row to the next, for logs that hold no motors.
    pub axis_command: [Column; 3],
    /// By how much each motor's command changes per unit of an axis command, with the signs of docs/rig.md; `None`
    /// where nobody says.
    pub motor_per_axis_command: Option<[f64; 3]>,
    /// What held the vehicle, where a map says so.
    pub rig: Option<Rig>,
    /// Collective command 0..1, beside the axis commands.
    pub thrust_command: Column,
    /// Reference angles, rad.
    pub reference_rad: [Column; 3],
    /// The pilot's sticks -1..1, likewise.
    pub stick: [Column; 3],
    /// Battery voltage, V.
    pub battery_v: Column,
    /// Measured rotor speeds, 1/min.
    pub rotor_speed_rpm: [Column; 4],
    /// Specific force in the body frame, m/s^2.
    pub accel_body_m_s2: [Column; 3],

    /// The log of more rows whose commands act between the rows of this one ([`Log::thinned`]); `None` where its own
    /// do.
    pub commanded_by: Option<Box<Log>>,
    /// The commands at their own times, where these are not the rows': a log of nothing but commands, the first of them
    /// in force at the first row. The rows' own columns then hold what was in force at each.
    pub sent_commands: Option<Box<Log>>,
    /// Velocity north, east, down, m/s.
    pub velocity_ned_m_s: [Column; 3],
    /// Height of the rotors above ground, m.
    pub height_m: Column,
}

impl Log {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// Its file without the folder.
    pub fn file_name(&self) -> &str {
        self.path.rsplit(['/', '\\']).next().unwrap_or(&self.path)
    }

    /// Time from the first row to the last, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Mean number of rows per second, gaps left out; 0 for a log of one row.
    pub fn rate_hz(&self) -> f64 {
        let step_s = self.mean_regular_step_s();
        if step_s > 0.0 { 1.0 / step_s } else { 0.0 }
    }

    /// Median time from row to row, s; 0 for a log of one row.
    pub fn median_step_s(&self) -> f64 {
        median_step(&self.time_s).unwrap_or(0.0)
    }

    /// Mean time from row to row, gaps left out, s: where rows come unevenly, as those of a 300 Hz log of a 400 Hz
    /// controller, the median would show the more frequent step only. 0 for a log of less than two rows.
    pub fn mean_regular_step_s(&self) -> f64 {
        let longest_s = self.longest_regular_step_s();
        let regular = self.time_s.windows(2).map(|t| t[1] - t[0]).filter(|step| *step <= longest_s);
        let (sum, count) = regular.fold((0.0, 0.0), |(sum, count), step| (sum + step, count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// A longer step than this from row to row is a gap: rows are missing.
    pub fn longest_regular_step_s(&self) -> f64 {
        GAP_STEPS * self.median_step_s()
    }

    /// For a longer step than this windows are cut, s.
    pub(crate) fn longest_uncut_step_s(&self) -> f64 {
        self.longest_regular_step_s().max(PAUSE_S)
    }

    /// The four motor commands, if the log has all of them.
    pub fn motors(&self) -> Option<[&[f64]; 4]> {
        let [Some(m1), Some(m2), Some(m3), Some(m4)] = &self.motor_command else {
            return None;
        };
        Some([m1, m2, m3, m4])
    }

    /// Per row the mean command of the motors, or the log's own throttle.
    pub(crate) fn collective(&self) -> Option<Vec<f64>> {
        let mean = |motors: [&[f64]; 4]| -> Vec<f64> {
            (0..self.rows()).map(|row| 0.25 * motors.iter().map(|motor| motor[row]).sum::<f64>()).collect()
        };
        self.motors().map(mean).or_else(|| self.thrust_command.clone())
    }

    /// True if the plant is to be driven by axis commands because there are no motor commands.
    pub fn driven_by_axis_commands(&self) -> bool {
        self.motors().is_none()
    }

    /// For each row, whether the motors run in it ([`Log::active_when`]).
    pub fn active_rows(&self) -> Vec<bool> {
        let threshold = self.active_when;
        match threshold.and_then(|active| Some((self.column(active.quantity)?, active.above))) {
            Some((column, above)) => column.iter().map(|value| *value > above).collect(),
            None => vec![true; self.rows()],
        }
    }

    /// One column by its quantity; `None` where the log has none.
    pub fn column(&self, quantity: Quantity) -> Option<&[f64]> {
        let column = match quantity {
            Quantity::Time => return Some(&self.time_s),
            Quantity::Angle(axis) => &self.angle_rad[axis.index()],
            Quantity::Rate(axis) => &self.rate_rad_s[axis.index()],
            Quantity::Motor(motor) => &self.motor_command[motor],
            Quantity::Reference(axis) => &self.reference_rad[axis.index()],
            Quantity::Stick(axis) => &self.stick[axis.index()],
            Quantity::Command(axis) => &self.axis_command[axis.index()],
            Quantity::Thrust => &self.thrust_command,
            Quantity::Battery => &self.battery_v,
            Quantity::Rpm(rotor) => &self.rotor_speed_rpm[rotor],
            Quantity::Accel(axis) => &self.accel_body_m_s2[axis.index()],
            Quantity::Velocity(axis) => &self.velocity_ned_m_s[axis.index()],
            Quantity::Height => &self.height_m,
        };
        column.as_deref()
    }

    /// Puts a column in its place.
    fn set_column(&mut self, quantity: Quantity, values: Vec<f64>) {
        let column = match quantity {
            Quantity::Time => {
                self.time_s = values;
                return;
            }
            Quantity::Angle(axis) => &mut self.angle_rad[axis.index()],
            Quantity::Rate(axis) => &mut self.rate_rad_s[axis.index()],
            Quantity::Motor(motor) => &mut self.motor_command[motor],
            Quantity::Reference(axis) => &mut self.reference_rad[axis.index()],
            Quantity::Stick(axis) => &mut self.stick[axis.index()],
            Quantity::Command(axis) => &mut self.axis_command[axis.index()],
            Quantity::Thrust => &mut self.thrust_command,
            Quantity::Battery => &mut self.battery_v,
            Quantity::Rpm(rotor) => &mut self.rotor_speed_rpm[rotor],
            Quantity::Accel(axis) => &mut self.accel_body_m_s2[axis.index()],
            Quantity::Velocity(axis) => &mut self.velocity_ned_m_s[axis.index()],
            Quantity::Height => &mut self.height_m,
        };
        *column = Some(values);
    }
}
