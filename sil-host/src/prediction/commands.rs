//! The commands of a log: what the prediction is driven by.

use super::error::NotPredictable;
use super::force_track::Commands;
use crate::axis::Axis;
use crate::log::{Log, Quantity};
use crate::vehicle::signed_sums;

/// The commands of the four motors, each in force until the next row.
///
/// # Errors
/// The log has none.
pub(crate) fn motor_commands(log: &Log) -> Result<Commands, NotPredictable> {
    let motors = log.motors().ok_or_else(|| NotPredictable::MissingColumn {
        column: Quantity::Motor(0).name(),
        why: "drives the vehicle (a log of axis commands is held against the rig `axis`)",
    })?;
    let value = (0..log.rows()).map(|row| motors.map(|motor| motor[row])).collect();
    Ok(Commands { time_s: log.time_s.clone(), value })
}

/// The commands of separate axes, each in force until the next row.
///
/// # Errors
/// The log has none for an axis that it is about.
pub(crate) fn commands_of_axes(log: &Log) -> Result<Commands, NotPredictable> {
    for axis in Axis::ALL {
        if log.axes[axis.index()] && log.axis_command[axis.index()].is_none() && log.motors().is_none() {
            let column = Quantity::Command(axis).name();
            let why = "drives that axis (or motor1 to motor4)";
            return Err(NotPredictable::MissingColumn { column, why });
        }
    }
    Ok(Commands { time_s: log.time_s.clone(), value: axis_commands(log) })
}

/// Row by row (roll, pitch, yaw, 0): the axis commands, where the log has them; else made of the motors, half the
/// signed sum, so that they lie in -1..1; 0 where it has neither.
pub(crate) fn axis_commands(log: &Log) -> Vec<[f64; 4]> {
    let of_axis = |axis: Axis, row: usize| match (&log.axis_command[axis.index()], log.motors()) {
        (Some(column), _) => column[row],
        (None, Some(motors)) => 0.5 * signed_sums(motors.map(|motor| motor[row]))[axis.index()],
        (None, None) => 0.0,
    };
    let of_row = |row: usize| [of_axis(Axis::Roll, row), of_axis(Axis::Pitch, row), of_axis(Axis::Yaw, row), 0.0];
    (0..log.rows()).map(of_row).collect()
}
