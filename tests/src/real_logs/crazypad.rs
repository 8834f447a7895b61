//! Flights of a Crazyflie with and without a weight near its motor 3 (CrazyPAD): what the steady commands say of weight and weak motor.
//!
//! In steady flight the lifts balance all moments, so that the commands tell what else acts: a weight of the share w of the vehicle's at the
//! place (x, y) asks for a moment about roll and pitch and none about yaw; a motor that has lost the share d of all lift asks for its
//! own command to rise, whose part about yaw is as large as those about roll and pitch.

use std::fmt;
use std::path::Path;

use sil_host::log::Log;
use sil_host::model::VehicleModel;

use super::{TORQUE_SIGNS, load, name_of};

/// The vehicle flies at half a metre, 2 m forth and 2 m back along x, s after the log's begin.
const SPANS_S: [(&str, f64, f64); 2] = [("forth", 4.5, 9.5), ("back", 18.0, 23.0)];
/// Motor 3 of a Crazyflie, rear left, in docs/rig.md's order from 0.
const MOTOR_3: usize = 1;

/// One steady flight.
#[derive(Clone, Debug)]
pub struct Steady {
    /// Log and way.
    pub name: String,
    /// True for the vehicle with the weight.
    pub is_weighted: bool,
    /// Mean command of the four motors.
    pub collective: f64,
    /// Mean voltage, V, where it was logged.
    pub battery_v: Option<f64>,
    /// What the lifts do about roll, pitch and yaw, as shares of the whole lift (over the lever, for roll and pitch): a nominal
    /// vehicle's lifts at these commands.
    pub share: [f64; 3],
}

/// Both ways of a flight.
///
/// # Panics
/// The log is not one of CrazyPAD's.
pub fn steady(path: &Path, vehicle: &VehicleModel) -> Vec<Steady> {
    let name = name_of(path);
    let map = if name.starts_with("motor_data") { "crazypad_motor" } else { "crazypad_controller" };
    let log = load(path, map);
    SPANS_S
        .iter()
        .map(|(way, from_s, to_s)| {
            let part = log.between(*from_s, *to_s).expect("a log of 25 s");
            let motors = motor_commands(&part);
            let rows = motors.len() as f64;
            let mean = |of: &dyn Fn(&[f64; 4]) -> f64| motors.iter().map(of).sum::<f64>() / rows;
            let lifts: [f64; 4] = core::array::from_fn(|i| mean(&|row| vehicle.propulsion.lift_n(row[i])));
            let whole: f64 = lifts.iter().sum();
            Steady {
                name: format!("{name}, {way}"),
                is_weighted: name.contains("weight"),
                collective: mean(&|row| 0.25 * row.iter().sum::<f64>()),
                battery_v: part.battery_v.as_ref().map(|volts| volts.iter().sum::<f64>() / rows),
                share: TORQUE_SIGNS.map(|signs| signs.iter().zip(lifts).map(|(sign, lift)| sign * lift / whole).sum()),
            }
        })
        .collect()
}

/// The logged motors, or those that the Crazyflie's firmware makes of its axis commands: thrust, half of roll and pitch, all of yaw, in one unit.
fn motor_commands(log: &Log) -> Vec<[f64; 4]> {
    if let Some(motors) = log.motors() {
        return (0..log.rows()).map(|row| motors.map(|motor| motor[row])).collect();
    }
    let [roll, pitch, yaw] = log.axis_command.each_ref().map(|column| column.as_ref().expect("axis commands"));
    let thrust = log.thrust_command.as_ref().expect("a thrust command");
    // the map takes axis commands as shares of 32767, thrust as one of 65535
    let motor = |row: usize, i: usize| {
        let [on_roll, on_pitch, on_yaw] = TORQUE_SIGNS.map(|signs| signs[i]);
        thrust[row] + 0.5 * (0.5 * on_roll * roll[row] + 0.5 * on_pitch * pitch[row] + on_yaw * yaw[row])
    };
    (0..log.rows()).map(|row| core::array::from_fn(|i| motor(row, i))).collect()
}

/// What the weighted flights have more than the normal ones of the same kind and way, and how well each cause explains it.
#[derive(Clone, Debug)]
pub struct Change {
    /// Mean change of the shares about roll, pitch and yaw.
    pub share: [f64; 3],
    /// Half the range of the changes, over kinds of log and ways.
    pub spread: [f64; 3],
    /// Root mean square over the three axes of what a weak motor 3 leaves of it, best fitted.
    pub left_by_weak_motor: f64,
    /// The same of a weight anywhere: its yaw part alone.
    pub left_by_weight: f64,
}

impl Change {
    /// Compares flights that [`steady`] made, the normal ones with the weighted ones of the same way and kind.
    pub fn of(flights: &[Steady]) -> Change {
        let kind = |flight: &Steady| (flight.battery_v.is_some(), flight.name.ends_with("forth"));
        let mut changes: Vec<[f64; 3]> = Vec::new();
        for weighted in flights.iter().filter(|flight| flight.is_weighted) {
            for normal in flights.iter().filter(|flight| !flight.is_weighted && kind(flight) == kind(weighted)) {
                changes.push(core::array::from_fn(|axis| weighted.share[axis] - normal.share[axis]));
            }
        }
        let count = changes.len().max(1) as f64;
        let share: [f64; 3] =
            core::array::from_fn(|axis| changes.iter().map(|change| change[axis]).sum::<f64>() / count);
        let spread = core::array::from_fn(|axis| {
            let values = changes.iter().map(|change| change[axis]);
            0.5 * (values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min))
        });
        let signs = TORQUE_SIGNS.map(|signs| signs[MOTOR_3]);
        let lost: f64 = (0..3).map(|axis| signs[axis] * share[axis]).sum::<f64>() / 3.0;
        let squares: f64 =
            (0..3).map(|axis| (share[axis] - lost * signs[axis]) * (share[axis] - lost * signs[axis])).sum();
        Change {
            share,
            spread,
            left_by_weak_motor: (squares / 3.0).sqrt(),
            left_by_weight: share[2].abs() / 3f64.sqrt(),
        }
    }
}

impl fmt::Display for Steady {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let volts = self.battery_v.map_or_else(|| "-".to_owned(), |volts| format!("{volts:.2}"));
        let [roll, pitch, yaw] = self.share.map(|share| 100.0 * share);
        writeln!(out, "| {} | {:.3} | {volts} | {roll:+.1} | {pitch:+.1} | {yaw:+.1} |", self.name, self.collective)
    }
}

impl fmt::Display for Change {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = |axis: usize| format!("{:+.1} +- {:.1}", 100.0 * self.share[axis], 100.0 * self.spread[axis]);
        writeln!(out, "| **weighted less normal** | | | {} | {} | {} |", told(0), told(1), told(2))?;
        writeln!(
            out,
            "\nOf this a weak motor 3 leaves {:.1} %, a weight somewhere {:.1} % (root mean square over the axes).",
            100.0 * self.left_by_weak_motor,
            100.0 * self.left_by_weight
        )
    }
}
