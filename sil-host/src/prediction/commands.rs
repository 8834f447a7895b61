//! The commands of a log: what the prediction is driven by.

use super::drive::DirectInput;
use super::error::NotPredictable;
use super::force_track::Commands;
use crate::axis::Axis;
use crate::log::sanity::has_reversed_spin;
use crate::log::{Log, Quantity};

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

/// What drives separate axes: the motors where a log has them, for they are what acts, else the axes' commands.
pub(crate) fn direct_input(log: &Log) -> DirectInput {
    match log.motors() {
        None => DirectInput::Axes,
        Some(_) if has_reversed_spin(log) => DirectInput::ReversedMotors,
        Some(_) => DirectInput::Motors,
    }
}

/// The commands that drive separate axes, each in force until the next row.
///
/// # Errors
/// The log has none for an axis that it is about.
pub(crate) fn commands_of_axes(log: &Log) -> Result<Commands, NotPredictable> {
    if direct_input(log) != DirectInput::Axes {
        return motor_commands(log);
    }
    for axis in Axis::ALL {
        if log.axes[axis.index()] && log.axis_command[axis.index()].is_none() {
            let column = Quantity::Command(axis).name();
            let why = "drives that axis (or motor1 to motor4)";
            return Err(NotPredictable::MissingColumn { column, why });
        }
    }
    Ok(Commands { time_s: log.time_s.clone(), value: axis_commands(log) })
}

/// Row by row (roll, pitch, yaw, 0): what the motors do about the axes, where the log has them; else the axis commands;
/// 0 where it has neither.
pub(crate) fn axis_commands(log: &Log) -> Vec<[f64; 4]> {
    let input = direct_input(log);
    let of_motors = |motors: [&[f64]; 4], row: usize| input.about_axes(motors.map(|motor| motor[row]));
    let of_axes = |row: usize| log.axis_command.each_ref().map(|column| column.as_ref().map_or(0.0, |own| own[row]));
    let motors = log.motors();
    let of_row = |row: usize| motors.map_or_else(|| of_axes(row), |motors| of_motors(motors, row));
    (0..log.rows()).map(of_row).map(|[roll, pitch, yaw]| [roll, pitch, yaw, 0.0]).collect()
}
