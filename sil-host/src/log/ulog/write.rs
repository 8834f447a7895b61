//! From a [`Log`] to a ULog file with PX4's topics at the log's own rate, so that PX4's tools open it.
//!
//! Messages, topics and head are those of the vehicle's own log ([`shared_control::onboard_log`]), filled from the
//! log's columns in place of a step's input and output: what a CSV of the same flight says, this says. The topics of
//! velocity and height and of the pilot's sticks are this file's own, as the flight core knows none of them. Numbers
//! are 32 bit floats, as PX4's are, times whole microseconds.

use std::io::{self, Write};

use shared_control::onboard_log::head;
use shared_control::onboard_log::topics;
use shared_control::onboard_log::ulog::{self, Content, Topic};

use super::super::{Log, Quantity};
use crate::axis::Axis;
use crate::vehicle::quaternion_world_from_body;

/// Rows from one mark to the next, at which a reader of a damaged file begins again.
const ROWS_PER_MARK: usize = 200;

/// Velocity and height.
const LOCAL_POSITION: Topic = Topic {
    name: "vehicle_local_position",
    fields: "uint64_t timestamp_sample;float z;float vx;float vy;float vz;bool z_valid;bool v_xy_valid;\
             bool v_z_valid;",
};

/// The pilot's sticks, pitch forward.
const STICKS: Topic =
    Topic { name: "manual_control_setpoint", fields: "uint64_t timestamp_sample;float roll;float pitch;float yaw;" };

/// A topic, whether the log has what it needs, and the content of a row.
struct Column {
    topic: Topic,
    is_there: fn(&Log) -> bool,
    content: fn(&Log, usize) -> Content,
}

/// In the order of their numbers.
const COLUMNS: [Column; 8] = [
    Column {
        topic: topics::SENSOR_COMBINED,
        is_there: |log| log.accel_body_m_s2.iter().all(Option::is_some),
        content: |log, row| {
            let step_us = (log.mean_regular_step_s() * 1e6).round() as u32;
            topics::sensor_combined(triple(log, row, Quantity::Rate), triple(log, row, Quantity::Accel), step_us)
        },
    },
    Column {
        topic: topics::ANGULAR_VELOCITY,
        is_there: |_| true,
        content: |log, row| topics::angular_velocity(time_us(log, row), triple(log, row, Quantity::Rate)),
    },
    Column {
        topic: topics::ATTITUDE,
        is_there: |log| log.angle_rad.iter().any(Option::is_some),
        content: |log, row| {
            let angle_rad = Axis::ALL.map(|axis| value(log, row, Quantity::Angle(axis)));
            let angle_rad = angle_rad.map(|angle| if angle.is_nan() { 0.0 } else { angle });
            topics::attitude(time_us(log, row), quaternion_world_from_body(angle_rad).map(|number| number as f32))
        },
    },
    Column {
        topic: topics::ATTITUDE_SETPOINT,
        is_there: |log| log.reference_rad.iter().any(Option::is_some),
        content: |log, row| {
            let heading_rad = value(log, row, Quantity::Angle(Axis::Yaw));
            let heading_rad = if heading_rad.is_nan() { 0.0 } else { heading_rad as f32 };
            topics::attitude_setpoint(triple(log, row, Quantity::Reference), f32::NAN, heading_rad)
        },
    },
    Column {
        topic: topics::MOTORS,
        is_there: |log| log.motors().is_some(),
        content: |log, row| {
            let commands = log.motors().map(|motors| motors.map(|motor| motor[row] as f32));
            topics::motors(time_us(log, row), commands.unwrap_or([f32::NAN; 4]))
        },
    },
    Column {
        topic: topics::BATTERY,
        is_there: |log| log.battery_v.is_some(),
        content: |log, row| topics::battery(value(log, row, Quantity::Battery) as f32),
    },
    Column {
        topic: LOCAL_POSITION,
        is_there: |log| log.height_m.is_some() && log.velocity_ned_m_s.iter().all(Option::is_some),
        content: |log, row| {
            let down_m = -value(log, row, Quantity::Height) as f32;
            let velocity_m_s = triple(log, row, Quantity::Velocity);
            Content::default().time(time_us(log, row)).numbers(&[down_m]).numbers(&velocity_m_s).bytes(&[1, 1, 1])
        },
    },
    Column {
        topic: STICKS,
        is_there: |log| log.stick.iter().any(Option::is_some),
        content: |log, row| {
            let [roll, pitch, yaw] = triple(log, row, Quantity::Stick);
            Content::default().time(time_us(log, row)).numbers(&[roll, -pitch, yaw])
        },
    },
];

/// Writes a log as ULog. Columns must be as long as `time_s`.
///
/// # Errors
/// Those of `out`; a time before 0; a quantity that is written to no topic: axis commands, rotor speeds.
pub(in super::super) fn write(log: &Log, out: &mut dyn Write) -> io::Result<()> {
    let refused = |why: String| io::Error::new(io::ErrorKind::InvalidInput, why);
    if let Some(quantity) = Quantity::ALL.into_iter().find(|quantity| is_in_no_topic(log, *quantity)) {
        return Err(refused(format!("a ULog file has no place here for `{}`", quantity.name())));
    }
    if log.time_s.iter().any(|time_s| time_s.is_nan() || *time_s < 0.0) {
        return Err(refused("a ULog file's times are not before 0".to_owned()));
    }
    let columns: Vec<&Column> = COLUMNS.iter().filter(|column| (column.is_there)(log)).collect();
    let written: Vec<Topic> = columns.iter().map(|column| column.topic).collect();
    let comments = log.comments.iter().map(|comment| ("comment", comment.as_str()));
    let information: Vec<(&str, &str)> = [("sys_name", "sil")].into_iter().chain(comments).collect();
    let mut bytes = Vec::new();
    head(0, &written, &information, None, &mut |more: &[u8]| bytes.extend_from_slice(more));
    for row in 0..log.rows() {
        let put = &mut |more: &[u8]| bytes.extend_from_slice(more);
        if row % ROWS_PER_MARK == 0 {
            ulog::mark(put);
        }
        for (number, column) in (0..).zip(&columns) {
            ulog::data(number, time_us(log, row), &(column.content)(log, row), put);
        }
        out.write_all(&bytes)?;
        bytes.clear();
    }
    out.write_all(&bytes)
}

fn is_in_no_topic(log: &Log, quantity: Quantity) -> bool {
    log.column(quantity).is_some() && matches!(quantity, Quantity::Command(_) | Quantity::Thrust | Quantity::Rpm(_))
}

/// The time of a row, us.
fn time_us(log: &Log, row: usize) -> u64 {
    (log.time_s[row] * 1e6).round() as u64
}

/// A quantity in a row; NaN where the log has none.
fn value(log: &Log, row: usize, quantity: Quantity) -> f64 {
    log.column(quantity).and_then(|column| column.get(row)).copied().unwrap_or(f64::NAN)
}

fn triple(log: &Log, row: usize, quantity: fn(Axis) -> Quantity) -> [f32; 3] {
    Axis::ALL.map(|axis| value(log, row, quantity(axis)) as f32)
}
