//! What is replayed: single axes with an input gain each, or the plant; both driven row by row by a log's commands.

use std::borrow::Cow;

use super::observe::{Kinematics, Motion};
use crate::axis::Axis;
use crate::log::Log;
use crate::model::{Rig, VehicleModel};
use crate::plant::Plant;
use crate::vehicle::signed_sums;

/// The commands of a row: motors 1 to 4, or (roll, pitch, yaw, unused).
pub(super) type Commands = [f64; 4];

/// Something that turns under commands.
#[derive(Clone, Debug)]
pub(super) enum Vehicle {
    /// Rigid axes of unit inertia: angle'' = gain * command, rad/s^2 per command.
    Axes { gain_rad_s2: [f64; 3], motion: Motion },
    /// The plant with motors, and the rig that it hangs in.
    Plant(Box<Plant>, Kinematics),
}

impl Vehicle {
    pub(super) fn axes(gain_rad_s2: [f64; 3]) -> Vehicle {
        Vehicle::Axes { gain_rad_s2, motion: Motion::default() }
    }

    pub(super) fn plant(plant: Plant, rig: Rig) -> Vehicle {
        let kinematics = match rig {
            Rig::Gimbal => Kinematics::Gimbal,
            Rig::Free => Kinematics::Euler,
        };
        Vehicle::Plant(Box::new(plant), kinematics)
    }

    pub(super) fn kinematics(&self) -> Kinematics {
        match self {
            Vehicle::Axes { .. } => Kinematics::Separate,
            Vehicle::Plant(_, kinematics) => *kinematics,
        }
    }

    /// Lets the motors settle at the commands of a row, at the row's time.
    pub(super) fn settle(&mut self, drive: &Drive<'_>, row: usize) {
        if let Vehicle::Plant(plant, _) = self {
            plant.set_time_s(drive.time_s[row] - drive.time_s[0]);
            plant.set_motor_equilibrium(drive.at(row));
        }
    }

    /// Puts it into a motion; motors go on as they are.
    pub(super) fn place(&mut self, placed: Motion) {
        match self {
            Vehicle::Axes { motion, .. } => *motion = placed,
            Vehicle::Plant(plant, kinematics) => {
                plant.set_attitude(placed.angle_rad, kinematics.body_rate_rad_s(&placed));
            }
        }
    }

    pub(super) fn motion(&self) -> Motion {
        match self {
            Vehicle::Axes { motion, .. } => *motion,
            Vehicle::Plant(plant, _) => {
                let truth = plant.truth();
                Motion {
                    angle_rad: [truth.roll_rad, truth.pitch_rad, truth.yaw_rad],
                    angle_rate_rad_s: truth.euler_rate_rad_s,
                }
            }
        }
    }

    /// Lets time pass under these commands.
    pub(super) fn hold(&mut self, commands: Commands, duration_s: f64) {
        match self {
            Vehicle::Axes { gain_rad_s2, motion } => {
                for axis in 0..3 {
                    let acceleration = gain_rad_s2[axis] * commands[axis];
                    let rate = motion.angle_rate_rad_s[axis];
                    motion.angle_rad[axis] += duration_s * (rate + 0.5 * duration_s * acceleration);
                    motion.angle_rate_rad_s[axis] += duration_s * acceleration;
                }
            }
            Vehicle::Plant(plant, _) => {
                plant.set_commands(commands);
                plant.advance(duration_s);
            }
        }
    }

    /// Flies through rows of a log; the motion at each, starting with the one it is in. It ends in the motion at the row
    /// `end`, which is not among them.
    pub(super) fn fly(&mut self, drive: &Drive<'_>, first: usize, end: usize) -> Vec<Motion> {
        let mut motions = Vec::with_capacity(end.saturating_sub(first));
        for row in first..end {
            motions.push(self.motion());
            if let (Vehicle::Plant(plant, _), Some(drop_v)) = (&mut *self, &drive.battery_drop_v) {
                plant.set_battery_drop_v(drop_v[row]);
            }
            if let (Vehicle::Plant(plant, _), Some(height_m)) = (&mut *self, drive.height_m) {
                plant.set_height_m(height_m[row]);
            }
            if let Some(next_s) = drive.time_s.get(row + 1) {
                self.hold(drive.at(row), next_s - drive.time_s[row]);
            }
        }
        motions
    }
}

/// The commands of a log, held from row to row.
pub(super) struct Drive<'a> {
    pub(super) time_s: &'a [f64],
    columns: [Option<Cow<'a, [f64]>>; 4],
    /// How far the battery is below its mean of the first second, V.
    battery_drop_v: Option<Cow<'a, [f64]>>,
    /// Height above ground, m: what the ground lifts hangs on it.
    height_m: Option<&'a [f64]>,
}

impl<'a> Drive<'a> {
    /// The motors; `None` if the log has none.
    pub(super) fn motors(log: &'a Log) -> Option<Drive<'a>> {
        let columns = log.motors()?.map(|column| Some(column.into()));
        Some(Drive {
            time_s: &log.time_s,
            columns,
            battery_drop_v: battery_drop_v(log),
            height_m: log.height_m.as_deref(),
        })
    }

    /// The axis commands, where the log has them; else made of the motors, half the signed sum, so that they lie in -1..1.
    pub(super) fn axes(log: &'a Log) -> Drive<'a> {
        let mut columns = [None, None, None, None];
        for axis in Axis::ALL {
            let i = axis.index();
            columns[i] = match (&log.axis_command[i], log.motors()) {
                (Some(column), _) => Some(column.as_slice().into()),
                (None, Some(motors)) => {
                    let signed_sum = |row: usize| signed_sums(motors.map(|motor| motor[row]))[i];
                    Some((0..log.rows()).map(|row| 0.5 * signed_sum(row)).collect::<Vec<f64>>().into())
                }
                (None, None) => None,
            };
        }
        Drive { time_s: &log.time_s, columns, battery_drop_v: None, height_m: None }
    }

    /// What a controller that makes so many steps per row commands on the mean from each row to the next, if its command
    /// goes straight from one logged value to the other.
    pub(super) fn between_rows(&self, steps_per_row: f64) -> Drive<'a> {
        let share_of_next = 0.5 * (steps_per_row - 1.0) / steps_per_row;
        let mean = |column: &Cow<'a, [f64]>| -> Cow<'a, [f64]> {
            let nexts = column.iter().skip(1).chain(column.last());
            column.iter().zip(nexts).map(|(now, next)| now + share_of_next * (next - now)).collect()
        };
        let columns = self.columns.each_ref().map(|column| column.as_ref().map(mean));
        Drive { time_s: self.time_s, columns, battery_drop_v: self.battery_drop_v.clone(), height_m: self.height_m }
    }

    /// One command's column, by its place in [`Commands`].
    pub(super) fn column(&self, place: usize) -> Option<&[f64]> {
        self.columns[place].as_deref()
    }

    /// The commands in force from a row on; 0 where there are none.
    pub(super) fn at(&self, row: usize) -> Commands {
        [0, 1, 2, 3].map(|place| self.column(place).map_or(0.0, |column| column[row]))
    }
}

/// The axis commands of a log, row by row: (roll, pitch, yaw, 0).
pub(crate) fn axis_commands(log: &Log) -> Vec<[f64; 4]> {
    let drive = Drive::axes(log);
    (0..log.rows()).map(|row| drive.at(row)).collect()
}

/// The battery's voltage below its mean over the first second, row by row, V.
fn battery_drop_v(log: &Log) -> Option<Cow<'_, [f64]>> {
    let voltage_v = log.battery_v.as_ref()?;
    let end_s = log.time_s.first()? + 1.0;
    let first_rows = log.time_s.partition_point(|time_s| *time_s < end_s);
    let mean_v = voltage_v[..first_rows].iter().sum::<f64>() / first_rows as f64;
    Some(voltage_v.iter().map(|voltage_v| mean_v - voltage_v).collect())
}

/// What one unit of each motor's command adds to the angular acceleration (roll, pitch, yaw), rad/s^2: the difference
/// quotient of the level vehicle at its base command, once the motors have settled.
pub(super) fn acceleration_per_command(model: &VehicleModel) -> [[f64; 4]; 3] {
    const COMMAND_STEP: f64 = 0.02;
    // ten times the slowest motors, and short enough to stay near level
    const SETTLING_S: f64 = 0.2;
    const INTERVAL_S: f64 = 0.05;
    let rate_gained_rad_s = |commands: Commands| {
        let mut plant = Plant::new(model);
        plant.set_commands(commands);
        plant.advance(SETTLING_S);
        let before = plant.truth().euler_rate_rad_s;
        plant.advance(INTERVAL_S);
        let after = plant.truth().euler_rate_rad_s;
        [0, 1, 2].map(|axis| after[axis] - before[axis])
    };
    // an effect may turn the vehicle without any command
    let base = [model.base_command; 4];
    let unmoved = rate_gained_rad_s(base);
    let mut per_command = [[0.0; 4]; 3];
    for motor in 0..4 {
        let mut commands = base;
        commands[motor] += COMMAND_STEP;
        let moved = rate_gained_rad_s(commands);
        for axis in 0..3 {
            per_command[axis][motor] = (moved[axis] - unmoved[axis]) / (INTERVAL_S * COMMAND_STEP);
        }
    }
    per_command
}
