//! Flights of two Crazyflies with a weight, with a cut propeller and as they are (CrazyPAD): what the steady commands
//! show of a weight and of a weak motor.
//!
//! In steady flight the lifts balance all moments, and these commands are lifts: the firmware divides by the battery's
//! voltage after them. A weak motor is balanced by its own command, which rises by d: the axis commands change by d/2
//! about roll and pitch and by d/4 about yaw (motor 3, rear left: 2 : -2 : 1). A weight changes roll and pitch, as its
//! place is, and yaw not at all.

use std::fmt;
use std::path::Path;

use sil_host::log::Log;

use super::{TORQUE_SIGNS, files, load, name_of};

/// The vehicle flies at half a metre, 2 m forth and 2 m back along x, s after the log's begin.
const SPANS_S: [(&str, f64, f64); 2] = [("forth", 4.5, 9.5), ("back", 18.0, 23.0)];
/// What a flight's log holds: axis commands and gyro, or motors' commands and voltage.
const KINDS: [&str; 2] = ["controller", "motor"];
/// Half a Crazyflie's axis command of roll and pitch, a quarter of yaw: what four motor commands sum up to.
const SUM_TO_AXIS: [f64; 3] = [0.5, 0.5, 0.25];
/// Motor 3 of a Crazyflie, rear left, in docs/rig.md's order from 0.
pub const MOTOR_3: usize = 1;
/// Motor 4, front left.
pub const MOTOR_4: usize = 2;
/// The label of flights in which nothing was changed.
pub const NORMAL: &str = "normal_flight";

/// One way of a flight.
#[derive(Clone, Debug)]
pub struct Flight {
    /// One of `KINDS`.
    pub kind: String,
    /// What was done to the vehicle, by its authors.
    pub label: String,
    /// `E8` or `E9`.
    pub airframe: String,
    /// Number of the log.
    pub log: String,
    /// `forth` or `back`.
    pub way: &'static str,
    /// Mean of the four motors' commands, % of the full one.
    pub thrust_pct: f64,
    /// Mean voltage, V, where it was logged.
    pub battery_v: Option<f64>,
    /// Mean axis commands (right side down, nose up, nose right), % of the full one.
    pub trim_pct: [f64; 3],
}

/// Both ways of all flights; none where the logs are absent.
///
/// # Panics
/// The logs are there and not CrazyPAD's.
pub fn flights() -> Vec<Flight> {
    files("flight_crazypad", "").iter().flat_map(|path| both_ways(path)).collect()
}

fn both_ways(path: &Path) -> Vec<Flight> {
    let name = name_of(path);
    let parts = || {
        let (kind, rest) = name.split_once("_data_")?;
        let (label, vehicle) = rest.split_once("__")?;
        let (airframe, log) = vehicle.split_once('_')?;
        Some([kind, label, airframe, log].map(str::to_owned))
    };
    let [kind, label, airframe, log] = parts().expect("KIND_data_LABEL__AIRFRAME_LOG");
    let whole = load(path, if kind == "motor" { "crazypad_motor" } else { "crazypad_controller" });
    let fly = |(way, from_s, to_s): (&'static str, f64, f64)| {
        let part = whole.between(from_s, to_s).expect("a log of 25 s");
        let (thrust, trim) = thrust_and_trim(&part);
        Flight {
            kind: kind.clone(),
            label: label.clone(),
            airframe: airframe.clone(),
            log: log.clone(),
            way,
            thrust_pct: 100.0 * thrust,
            battery_v: part.battery_v.as_deref().map(mean),
            trim_pct: trim.map(|command| 100.0 * command),
        }
    };
    SPANS_S.map(fly).to_vec()
}

/// Means of thrust and axis commands as shares of the full one: of the motors' commands, or of those that the firmware
/// makes them from.
fn thrust_and_trim(log: &Log) -> (f64, [f64; 3]) {
    if let Some(motors) = log.motors() {
        let means = motors.map(mean);
        let axis = |axis: usize| {
            SUM_TO_AXIS[axis] * TORQUE_SIGNS[axis].iter().zip(means).map(|(sign, command)| sign * command).sum::<f64>()
        };
        return (0.25 * means.iter().sum::<f64>(), [axis(0), axis(1), axis(2)]);
    }
    let axes = log.axis_command.each_ref().map(|column| column.as_ref().expect("axis commands"));
    // the map takes axis commands as shares of 32767, thrust as one of 65535
    (mean(log.thrust_command.as_ref().expect("a thrust command")), axes.map(|command| 0.5 * mean(command)))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// What flights of a label have more than normal ones of the same airframe, kind and way.
#[derive(Clone, Debug)]
pub struct Change {
    /// For each kind and way: the change of the mean trim, %.
    pub each_pct: Vec<[f64; 3]>,
    /// For each kind and way: half the range of the normal flights' trims, %.
    pub normal_pct: Vec<[f64; 3]>,
    /// Mean over kinds and ways, %.
    pub mean_pct: [f64; 3],
}

impl Change {
    /// Of an airframe's flights with a label; of all kinds of log, or of one.
    ///
    /// # Panics
    /// There is no such flight, or no normal one to compare it with.
    pub fn of(flights: &[Flight], airframe: &str, label: &str, kind: Option<&str>) -> Change {
        let (mut each_pct, mut normal_pct): (Vec<[f64; 3]>, Vec<[f64; 3]>) = Default::default();
        let ways = KINDS.iter().flat_map(|kind| SPANS_S.iter().map(move |(way, ..)| (*kind, *way)));
        for (kind, way) in ways.filter(|(of, _)| kind.is_none_or(|kind| kind == *of)) {
            let trims = |label: &str, axis: usize| -> Vec<f64> {
                let alike = flights.iter().filter(|flight| {
                    (flight.airframe.as_str(), flight.label.as_str()) == (airframe, label)
                        && (flight.kind.as_str(), flight.way) == (kind, way)
                });
                alike.map(|flight| flight.trim_pct[axis]).collect()
            };
            let [changed, normal] = [label, NORMAL].map(|label| [0, 1, 2].map(|axis| trims(label, axis)));
            assert!(!changed[0].is_empty() && !normal[0].is_empty(), "no flights {way} of {airframe}, {kind}, {label}");
            each_pct.push([0, 1, 2].map(|axis| mean(&changed[axis]) - mean(&normal[axis])));
            normal_pct.push(normal.map(|trims| {
                let (least, most) =
                    trims.iter().fold((f64::MAX, f64::MIN), |(least, most), trim| (trim.min(least), trim.max(most)));
                0.5 * (most - least)
            }));
        }
        let of_axis = |axis: usize| mean(&each_pct.iter().map(|change| change[axis]).collect::<Vec<_>>());
        Change { mean_pct: [of_axis(0), of_axis(1), of_axis(2)], each_pct, normal_pct }
    }

    /// Mean change of the moment that pulls toward a motor (0 to 3, docs/rig.md's order), as the change of roll and
    /// pitch command, %.
    pub fn pull_pct(&self, motor: usize) -> f64 {
        pull(&self.mean_pct, motor)
    }

    /// For each kind and way, and last for their mean: the change about yaw over what that pull would bring if the
    /// motor were weak. 1 of a weak motor, 0 of a weight.
    pub fn weak_motor_shares(&self, motor: usize) -> Vec<f64> {
        let share = |change: &[f64; 3]| change[2] / (0.5 * TORQUE_SIGNS[2][motor] * pull(change, motor));
        self.each_pct.iter().chain([&self.mean_pct]).map(share).collect()
    }
}

fn pull(change: &[f64; 3], motor: usize) -> f64 {
    0.5 * (TORQUE_SIGNS[0][motor] * change[0] + TORQUE_SIGNS[1][motor] * change[1])
}

/// A row of the table of flights.
impl fmt::Display for Flight {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Flight { kind, label, airframe, log, way, thrust_pct, .. } = self;
        let volts = self.battery_v.map_or_else(|| "-".to_owned(), |volts| format!("{volts:.2}"));
        let [roll, pitch, yaw] = self.trim_pct;
        writeln!(
            out,
            "| {label}, {airframe}, {kind} {log}, {way} | {thrust_pct:.1} | {volts} \
             | {roll:+.1} | {pitch:+.1} | {yaw:+.1} |"
        )
    }
}

/// Cells of the table of changes: the mean change about each axis, and half the range of normal flights.
impl fmt::Display for Change {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for axis in 0..3 {
            let normal = mean(&self.normal_pct.iter().map(|normal| normal[axis]).collect::<Vec<_>>());
            write!(out, " {:+.1} ({normal:.1}) |", self.mean_pct[axis])?;
        }
        Ok(())
    }
}

/// Airframes and labels in which something was changed, in their order.
pub fn changed_labels(flights: &[Flight]) -> Vec<(&str, &str)> {
    let changed = flights.iter().filter(|flight| flight.label != NORMAL);
    let mut labels: Vec<_> = changed.map(|flight| (flight.airframe.as_str(), flight.label.as_str())).collect();
    labels.sort_unstable();
    labels.dedup();
    labels
}
