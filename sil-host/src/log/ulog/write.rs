//! From a [`Log`] to a ULog file with PX4's topics at the log's own rate, so that PX4's tools open it.
//!
//! Topics and fields are those of PX4 1.14 (user guide, "uORB Message Reference"); the geometry is that of its generic
//! quad-X, whose motors are this project's. Numbers are 32 bit floats, as PX4's are, times whole microseconds.

use std::io::{self, Write};

use shared_control::airframe::MOTORS;

use super::super::{Log, Quantity};
use crate::axis::Axis;
use crate::vehicle::quaternion_world_from_body;

/// Magic, version 1, and the time at which the log began, us.
const HEADER: &[u8; 16] = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0";
/// Rows from one mark to the next, at which a reader of a damaged file begins again.
const ROWS_PER_SYNC: usize = 200;
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// `actuator_motors` has room for so many.
const MOTORS_MAX: usize = 12;

/// A topic: name, fields, whether the log has what it needs, and the content of a row after its time stamp.
struct Topic {
    name: &'static str,
    fields: &'static str,
    is_there: fn(&Log) -> bool,
    content: fn(&Log, usize, &mut Message),
}

/// In the order of their numbers.
const TOPICS: [Topic; 7] = [
    Topic {
        name: "sensor_combined",
        fields: "float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;\
                 float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;",
        is_there: |log| log.accel_body_m_s2.iter().all(Option::is_some),
        content: |log, row, message| {
            let step_us = (log.mean_regular_step_s() * 1e6).round() as u32;
            message.numbers(&triple(log, row, Quantity::Rate)).bytes(&step_us.to_le_bytes());
            message
                .bytes(&0_i32.to_le_bytes())
                .numbers(&triple(log, row, Quantity::Accel))
                .bytes(&step_us.to_le_bytes());
        },
    },
    Topic {
        name: "vehicle_angular_velocity",
        fields: "uint64_t timestamp_sample;float[3] xyz;",
        is_there: |_| true,
        content: |log, row, message| {
            message.time(log, row).numbers(&triple(log, row, Quantity::Rate));
        },
    },
    Topic {
        name: "vehicle_attitude",
        fields: "uint64_t timestamp_sample;float[4] q;",
        is_there: |log| log.angle_rad.iter().any(Option::is_some),
        content: |log, row, message| {
            let angle_rad = triple(log, row, Quantity::Angle).map(|angle| if angle.is_nan() { 0.0 } else { angle });
            message.time(log, row).numbers(&quaternion_world_from_body(angle_rad));
        },
    },
    Topic {
        name: "vehicle_attitude_setpoint",
        fields: "float roll_body;float pitch_body;float yaw_body;",
        is_there: |log| log.reference_rad.iter().any(Option::is_some),
        content: |log, row, message| {
            message.numbers(&triple(log, row, Quantity::Reference));
        },
    },
    Topic {
        name: "actuator_motors",
        fields: "uint64_t timestamp_sample;uint16_t reversible_flags;float[12] control;",
        is_there: |log| log.motors().is_some(),
        content: |log, row, message| {
            // no number is a motor that is not there
            let control = core::array::from_fn::<f64, MOTORS_MAX, _>(|motor| match log.motors() {
                Some(motors) if motor < motors.len() => motors[motor][row],
                _ => f64::NAN,
            });
            message.time(log, row).bytes(&0_u16.to_le_bytes()).numbers(&control);
        },
    },
    Topic {
        name: "battery_status",
        fields: "float voltage_v;",
        is_there: |log| log.battery_v.is_some(),
        content: |log, row, message| {
            message.numbers(&[value(log, row, Quantity::Battery)]);
        },
    },
    Topic {
        name: "vehicle_local_position",
        fields: "uint64_t timestamp_sample;float z;float vx;float vy;float vz;bool z_valid;bool v_xy_valid;\
                 bool v_z_valid;",
        is_there: |log| log.height_m.is_some() && log.velocity_ned_m_s.iter().all(Option::is_some),
        content: |log, row, message| {
            message.time(log, row).numbers(&[-value(log, row, Quantity::Height)]);
            message.numbers(&triple(log, row, Quantity::Velocity)).bytes(&[1, 1, 1]);
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
    out.write_all(HEADER)?;
    Message::of(b'B').bytes(&[0; 40]).write(out)?;
    let topics: Vec<(u16, &Topic)> = (0..).zip(&TOPICS).filter(|(_, topic)| (topic.is_there)(log)).collect();
    for (_, topic) in &topics {
        let format = format!("{}:uint64_t timestamp;{}", topic.name, topic.fields);
        Message::of(b'F').bytes(format.as_bytes()).write(out)?;
    }
    text(out, "sys_name", "sil")?;
    for comment in &log.comments {
        text(out, "comment", comment)?;
    }
    parameters(out)?;
    for (number, topic) in &topics {
        Message::of(b'A').bytes(&[0]).bytes(&number.to_le_bytes()).bytes(topic.name.as_bytes()).write(out)?;
    }
    for row in 0..log.rows() {
        if row % ROWS_PER_SYNC == 0 {
            Message::of(b'S').bytes(&SYNC).write(out)?;
        }
        for (number, topic) in &topics {
            let mut message = Message::of(b'D');
            message.bytes(&number.to_le_bytes()).time(log, row);
            (topic.content)(log, row, &mut message);
            message.write(out)?;
        }
    }
    Ok(())
}

fn is_in_no_topic(log: &Log, quantity: Quantity) -> bool {
    log.column(quantity).is_some() && matches!(quantity, Quantity::Command(_) | Quantity::Thrust | Quantity::Rpm(_))
}

/// A piece of information, short enough for its message.
fn text(out: &mut dyn Write, key: &str, value: &str) -> io::Result<()> {
    let value = value.get(..value.len().min(u16::MAX.into())).unwrap_or_default();
    let key = format!("char[{}] {key}", value.len());
    Message::of(b'I').key(&key).bytes(value.as_bytes()).write(out)
}

/// PX4's generic quad-X: MAV_TYPE_QUADROTOR, airframe 4001, four rotors where docs/rig.md has them.
fn parameters(out: &mut dyn Write) -> io::Result<()> {
    for (name, value) in [("MAV_TYPE", 2_i32), ("SYS_AUTOSTART", 4001), ("CA_ROTOR_COUNT", 4)] {
        Message::of(b'P').key(&format!("int32_t {name}")).bytes(&value.to_le_bytes()).write(out)?;
    }
    for (number, motor) in MOTORS.iter().enumerate() {
        let counter_clockwise = -f32::from(motor.spin);
        let place =
            [("PX", f32::from(motor.forward)), ("PY", f32::from(motor.right)), ("KM", 0.05 * counter_clockwise)];
        for (name, value) in place {
            let key = format!("float CA_ROTOR{number}_{name}");
            Message::of(b'P').key(&key).bytes(&value.to_le_bytes()).write(out)?;
        }
    }
    Ok(())
}

/// A quantity in a row; NaN where the log has none.
fn value(log: &Log, row: usize, quantity: Quantity) -> f64 {
    log.column(quantity).and_then(|column| column.get(row)).copied().unwrap_or(f64::NAN)
}

fn triple(log: &Log, row: usize, quantity: fn(Axis) -> Quantity) -> [f64; 3] {
    Axis::ALL.map(|axis| value(log, row, quantity(axis)))
}

/// One message on its way to the file.
struct Message {
    kind: u8,
    content: Vec<u8>,
}

impl Message {
    fn of(kind: u8) -> Message {
        Message { kind, content: Vec::new() }
    }

    fn bytes(&mut self, bytes: &[u8]) -> &mut Message {
        self.content.extend_from_slice(bytes);
        self
    }

    /// The length and the text of a key.
    fn key(&mut self, key: &str) -> &mut Message {
        self.bytes(&[key.len() as u8]).bytes(key.as_bytes())
    }

    fn numbers(&mut self, numbers: &[f64]) -> &mut Message {
        for number in numbers {
            self.bytes(&(*number as f32).to_le_bytes());
        }
        self
    }

    /// The time of a row, us.
    fn time(&mut self, log: &Log, row: usize) -> &mut Message {
        self.bytes(&((log.time_s[row] * 1e6).round() as u64).to_le_bytes())
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let length = u16::try_from(self.content.len());
        let length = length.map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "a message is too long"))?;
        out.write_all(&length.to_le_bytes())?;
        out.write_all(&[self.kind])?;
        out.write_all(&self.content)
    }
}
