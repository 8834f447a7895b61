//! What PX4's topics mean (PX4 user guide, "uORB Message Reference" and "Parameter Reference"): body axes
//! forward-right-down, world north-east-down, quaternions world from body (w, x, y, z), SI units, time stamps in us
//! since start.

use shared_control::learning::adoption::LearntModel;

use super::super::messages::{Messages, Table};
use super::super::motor_order::{MotorOrder, Rotor, no_quadrotor, spin_reversed};
use super::super::quantity::Quantity;
use super::super::quaternions::euler_columns;
use super::super::recording::{Fact, FactValue, Recording, Stream, facts_of_parameters};
use super::super::turned::PLUS_DEG;
use super::{allocation, outputs};
use crate::axis::Axis;

/// The topics that are read.
pub(super) const TOPICS: [&str; 14] = [
    "manual_control_setpoint",
    "vehicle_angular_velocity",
    "sensor_combined",
    "vehicle_attitude",
    "vehicle_attitude_setpoint",
    "actuator_motors",
    "actuator_outputs",
    "actuator_controls_0",
    "vehicle_torque_setpoint",
    "vehicle_thrust_setpoint",
    "battery_status",
    "learnt_model",
    "vehicle_local_position",
    "esc_status",
];

/// Parameter, name of the fact, factor to its unit.
const PARAMETERS: [(&str, &str, f64); 26] = [
    ("IMU_GYRO_RATEMAX", "rate_loop_hz", 1.0),
    ("IMU_GYRO_CUTOFF", "gyro_low_pass_hz", 1.0),
    ("IMU_DGYRO_CUTOFF", "rate_d_low_pass_hz", 1.0),
    ("IMU_ACCEL_CUTOFF", "accelerometer_low_pass_hz", 1.0),
    ("IMU_GYRO_NF0_FRQ", "gyro_notch_hz", 1.0),
    ("IMU_GYRO_NF0_BW", "gyro_notch_width_hz", 1.0),
    ("MC_ROLL_P", "roll_p_1_s", 1.0),
    ("MC_PITCH_P", "pitch_p_1_s", 1.0),
    ("MC_YAW_P", "yaw_p_1_s", 1.0),
    ("MC_ROLLRATE_K", "roll_rate_k", 1.0),
    ("MC_ROLLRATE_P", "roll_rate_p", 1.0),
    ("MC_ROLLRATE_I", "roll_rate_i", 1.0),
    ("MC_ROLLRATE_D", "roll_rate_d", 1.0),
    ("MC_ROLLRATE_FF", "roll_rate_ff", 1.0),
    ("MC_PITCHRATE_K", "pitch_rate_k", 1.0),
    ("MC_PITCHRATE_P", "pitch_rate_p", 1.0),
    ("MC_PITCHRATE_I", "pitch_rate_i", 1.0),
    ("MC_PITCHRATE_D", "pitch_rate_d", 1.0),
    ("MC_PITCHRATE_FF", "pitch_rate_ff", 1.0),
    ("MC_YAWRATE_K", "yaw_rate_k", 1.0),
    ("MC_YAWRATE_P", "yaw_rate_p", 1.0),
    ("MC_YAWRATE_I", "yaw_rate_i", 1.0),
    ("MC_YAWRATE_D", "yaw_rate_d", 1.0),
    ("THR_MDL_FAC", "thrust_model_factor", 1.0),
    ("MPC_THR_HOVER", "hover_thrust", 1.0),
    ("MC_AIRMODE", "air_mode", 1.0),
];

/// MAVLink's `MAV_TYPE_QUADROTOR`.
const QUADROTOR: f64 = 2.0;
/// Others of that list, in words.
const KINDS: [(&[f64], &str); 5] = [
    (&[1.0], "an aeroplane"),
    (&[10.0, 11.0, 12.0], "a vehicle on the ground or in water"),
    (&[13.0], "a hexarotor"),
    (&[14.0], "an octorotor"),
    (&[19.0, 20.0, 21.0, 22.0, 23.0, 24.0, 25.0], "a VTOL"),
];

/// What the messages of a PX4 log mean.
///
/// # Errors
/// In words: the vehicle is no quadrotor with motors as an X or a plus.
pub(super) fn recording(messages: &Messages) -> Result<Recording, String> {
    let mut recording = head(messages);
    let kind = messages.parameter("MAV_TYPE");
    if let Some(kind) = kind.filter(|kind| *kind != QUADROTOR) {
        let called = KINDS.iter().find(|(kinds, _)| kinds.contains(&kind)).map(|(_, called)| *called);
        return Err(no_quadrotor("MAV_TYPE", kind, called));
    }
    let order = motor_order(messages, &mut recording.facts, &mut recording.frame_turn_deg)?;
    recording.streams.extend(rates(messages));
    recording.streams.extend(attitude(messages));
    recording.streams.extend(reference(messages));
    recording.streams.extend(sticks(messages));
    let mut motors = motors(messages, &order);
    if let Some((mixed, told)) = motors.as_ref().and_then(|motors| allocation::motors(messages, motors)) {
        motors = Some(mixed);
        recording.notes.push(told);
    }
    recording.streams.extend(motors.or_else(|| outputs::motors(messages, &order, &mut recording.facts)));
    recording.streams.extend(axis_commands(messages));
    recording.streams.extend(position(messages, &mut recording.facts));
    recording.streams.extend(rotor_speeds(messages, &order));
    recording.streams.extend(
        stream(messages, "battery_status").map(|stream| stream.with(messages, "voltage_v", Quantity::Battery, 1.0)),
    );
    recording.notes.extend(learnt(messages));
    Ok(recording)
}

/// From when on the controllers of this project were made for what the flight had taught, and what that was.
fn learnt(messages: &Messages) -> Vec<String> {
    let columns = || {
        let table = messages.table("learnt_model")?;
        let [roll, pitch] = array(table, "gain")?;
        Some((seconds(table.column("timestamp")?), roll, pitch, table.column("lag_s")?))
    };
    let Some((time_s, roll, pitch, lag_s)) = columns() else { return Vec::new() };
    let model = |row: usize| LearntModel { gain: [roll[row] as f32, pitch[row] as f32], lag_s: lag_s[row] as f32 };
    let is_new = |row: &usize| *row == 0 || model(*row) != model(row - 1);
    let told =
        |row: usize| format!("from {:.2} s on flown by another model than the head's: {}", time_s[row], model(row));
    (0..time_s.len()).filter(is_new).map(told).collect()
}

/// What the file says of itself, without readings.
pub(super) fn head(messages: &Messages) -> Recording {
    let mut facts = Vec::new();
    for (key, name) in [("sys_name", "firmware"), ("ver_hw", "board"), ("ver_sw", "firmware_commit")] {
        if let Some(text) = messages.texts.get(key) {
            facts.push(Fact::said(name, FactValue::Text(text.clone()), &format!("information {key}")));
        }
    }
    facts.extend(facts_of_parameters(messages, &PARAMETERS));
    let notes = messages.notes.clone();
    Recording { flight_controller: "PX4".to_owned(), facts, notes, ..Recording::default() }
}

/// The stream of a topic at the times of its samples where it has them, else of its publication.
fn stream(messages: &Messages, topic: &str) -> Option<Stream> {
    let table = messages.table(topic)?;
    let sampled = table.column("timestamp_sample").filter(|stamps| stamps.iter().all(|stamp| *stamp > 0.0));
    let stamps = sampled.or_else(|| table.column("timestamp"))?;
    Some(Stream::at(topic, seconds(stamps)))
}

pub(super) fn seconds(stamps_us: &[f64]) -> Vec<f64> {
    stamps_us.iter().map(|stamp_us| stamp_us * 1e-6).collect()
}

/// Columns `name[0]`, `name[1]`, ...; none unless all are there.
pub(super) fn array<'a, const N: usize>(table: &'a Table, name: &str) -> Option<[&'a [f64]; N]> {
    let columns: Vec<&[f64]> = (0..N).map_while(|i| table.column(&format!("{name}[{i}]"))).collect();
    columns.try_into().ok()
}

/// Body rates, the densest first: filtered as the controller has them, or as the sensor gave them; and the
/// accelerometer, which was read a little before or after the gyro.
fn rates(messages: &Messages) -> Vec<Stream> {
    let of = |topic: &str, fields: [&str; 3]| {
        let mut stream = stream(messages, topic)?;
        for (axis, field) in Axis::ALL.into_iter().zip(fields) {
            stream = stream.with(messages, field, Quantity::Rate(axis), 1.0);
        }
        (stream.columns.len() == 3).then_some(stream)
    };
    let mut streams: Vec<Stream> = [
        of("vehicle_angular_velocity", ["xyz[0]", "xyz[1]", "xyz[2]"]),
        of("sensor_combined", ["gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"]),
        of("vehicle_attitude", ["rollspeed", "pitchspeed", "yawspeed"]),
    ]
    .into_iter()
    .flatten()
    .collect();
    streams.sort_by_key(|stream| core::cmp::Reverse(stream.time_s.len()));
    streams.extend(accelerometer(messages));
    streams
}

fn accelerometer(messages: &Messages) -> Option<Stream> {
    let topic = "sensor_combined";
    let table = messages.table(topic)?;
    let gyro_us = table.column("timestamp")?;
    let later_us = table.column("accelerometer_timestamp_relative");
    let time_us: Vec<f64> = match later_us {
        Some(later_us) => gyro_us.iter().zip(later_us).map(|(gyro_us, later_us)| gyro_us + later_us).collect(),
        None => gyro_us.to_vec(),
    };
    // the largest number stands for no reading
    let is_there = |row: usize| later_us.is_none_or(|later_us| later_us[row].abs() < f64::from(i32::MAX));
    let rows: Vec<usize> = (0..table.rows()).filter(|row| is_there(*row)).collect();
    let mut stream = Stream::at(topic, rows.iter().map(|row| time_us[*row] * 1e-6).collect());
    for (axis, column) in Axis::ALL.into_iter().zip(array::<3>(table, "accelerometer_m_s2")?) {
        let field = format!("accelerometer_m_s2[{}]", axis.index());
        stream.add(Quantity::Accel(axis), &field, rows.iter().map(|row| column[*row]).collect());
    }
    Some(stream)
}

fn attitude(messages: &Messages) -> Option<Stream> {
    let mut stream = stream(messages, "vehicle_attitude")?;
    let angles = euler(messages.table("vehicle_attitude")?, "q")?;
    for (axis, value) in Axis::ALL.into_iter().zip(angles) {
        stream.add(Quantity::Angle(axis), "q", value);
    }
    Some(stream)
}

/// Roll, pitch and yaw of a quaternion's columns; one that is far from a unit is no reading.
fn euler(table: &Table, name: &str) -> Option<[Vec<f64>; 3]> {
    let [w, x, y, z] = array::<4>(table, name)?;
    Some(euler_columns((0..w.len()).map(|row| [w[row], x[row], y[row], z[row]]), 0.5..2.0))
}

/// Reference angles: as angles until version 1.14, as a quaternion since.
fn reference(messages: &Messages) -> Option<Stream> {
    let topic = "vehicle_attitude_setpoint";
    let mut stream = Stream::at(topic, seconds(messages.column(topic, "timestamp")?));
    for (axis, field) in Axis::ALL.into_iter().zip(["roll_body", "pitch_body", "yaw_body"]) {
        stream = stream.with(messages, field, Quantity::Reference(axis), 1.0);
    }
    if stream.columns.is_empty() {
        for (axis, value) in Axis::ALL.into_iter().zip(euler(messages.table(topic)?, "q_d")?) {
            stream.add(Quantity::Reference(axis), "q_d", value);
        }
    }
    Some(stream)
}

/// The pilot's sticks, forward being nose down: `x`, `y`, `r` until version 1.13.
fn sticks(messages: &Messages) -> Option<Stream> {
    let mut stream = stream(messages, "manual_control_setpoint")?;
    for (axis, names, sign) in
        [(Axis::Roll, ["roll", "y"], 1.0), (Axis::Pitch, ["pitch", "x"], -1.0), (Axis::Yaw, ["yaw", "r"], 1.0)]
    {
        let name = names.into_iter().find(|name| messages.column(&stream.name, name).is_some())?;
        stream = stream.with(messages, name, Quantity::Stick(axis), sign);
    }
    Some(stream)
}

/// Which of PX4's motors is which of ours: by the control allocation's geometry, else by the usual quad-X. Of a plus
/// the body axes are to be turned.
fn motor_order(messages: &Messages, facts: &mut Vec<Fact>, frame_turn_deg: &mut f64) -> Result<[usize; 4], String> {
    if let Some(count) = messages.parameter("CA_ROTOR_COUNT").filter(|count| *count != 4.0) {
        return Err(format!("the vehicle has {count} rotors by its parameter CA_ROTOR_COUNT, not 4"));
    }
    let place = |rotor: usize| {
        let of = |what: &str| messages.parameter(&format!("CA_ROTOR{rotor}_{what}"));
        Some((of("PX")?, of("PY")?, of("KM")?))
    };
    let [Some(a), Some(b), Some(c), Some(d)] = [0, 1, 2, 3].map(place) else {
        let kind = messages.parameter("SYS_AUTOSTART");
        let source = match kind {
            Some(kind) => format!("no CA_ROTOR parameters; PX4's quad-X, since SYS_AUTOSTART is {kind}"),
            None => "no parameters of the geometry; PX4's quad-X".to_owned(),
        };
        // PX4's generic quad-plus (airframe reference): right, left, front, rear, which turned are our 1 to 4
        if kind == Some(5001.0) {
            *frame_turn_deg = PLUS_DEG;
            facts.push(plus("SYS_AUTOSTART is 5001"));
            return Ok([0, 1, 2, 3]);
        }
        facts.push(Fact::assumed("motor_order", FactValue::Text("1, 2, 3, 4 as in docs/rig.md".to_owned()), &source));
        return Ok([0, 1, 2, 3]);
    };
    // a plus has rotors on the axes
    let is_on_an_axis =
        |(forward, right, _): &(f64, f64, f64)| forward.abs().min(right.abs()) < 0.1 * forward.abs().max(right.abs());
    if [a, b, c, d].iter().all(is_on_an_axis) {
        *frame_turn_deg = PLUS_DEG;
        facts.push(plus("CA_ROTOR0_PX to CA_ROTOR3_PY"));
    }
    let (sin, cos) = libm::sincos(frame_turn_deg.to_radians());
    let rotors = [a, b, c, d].map(|(forward, right, moment)| Rotor {
        is_front: cos * forward + sin * right > 0.0,
        is_right: cos * right - sin * forward > 0.0,
        is_counter_clockwise: moment > 0.0,
    });
    let order = MotorOrder::of(&rotors).map_err(|why| format!("CA_ROTOR0_PX to CA_ROTOR3_KM: {why}"))?;
    for (motor, given) in order.given.into_iter().enumerate() {
        let text = format!("PX4's motor {}: {}", given + 1, rotors[given].in_words());
        let source = format!("parameters CA_ROTOR{given}_PX, _PY, _KM");
        facts.push(Fact::said(&format!("motor{}", motor + 1), FactValue::Text(text), &source));
    }
    if order.is_spin_reversed {
        facts.push(Fact::said("spin", spin_reversed(), "parameters CA_ROTOR0_KM to CA_ROTOR3_KM"));
    }
    Ok(order.given)
}

fn plus(source: &str) -> Fact {
    let text = format!("a plus: an X in axes that are turned by {PLUS_DEG} degrees");
    Fact::said("frame", FactValue::Text(text), source)
}

/// Commands of the control allocation, 0 to 1; no number stands for a stopped motor.
fn motors(messages: &Messages, order: &[usize; 4]) -> Option<Stream> {
    let topic = "actuator_motors";
    let mut stream = Stream::at(topic, seconds(messages.column(topic, "timestamp")?));
    let columns = array::<4>(messages.table(topic)?, "control")?;
    for (motor, given) in order.iter().enumerate() {
        let command = |value: &f64| if value.is_nan() { 0.0 } else { value.max(0.0) };
        stream.add(Quantity::Motor(motor), &format!("control[{given}]"), columns[*given].iter().map(command).collect());
    }
    Some(stream)
}

/// What the rate controller commands about each axis, for a log without motors.
fn axis_commands(messages: &Messages) -> Vec<Stream> {
    let of = |topic: &str, name: &str, thrust: Option<&str>| {
        let mut stream = Stream::at(topic, seconds(messages.column(topic, "timestamp")?));
        for axis in Axis::ALL {
            let field = format!("{name}[{}]", axis.index());
            stream = stream.with(messages, &field, Quantity::Command(axis), 1.0);
        }
        Some(match thrust {
            Some(field) => stream.with(messages, field, Quantity::Thrust, 1.0),
            None => stream,
        })
    };
    let new = of("vehicle_torque_setpoint", "xyz", None);
    let old = of("actuator_controls_0", "control", Some("control[3]"));
    new.into_iter().chain(old).collect()
}

/// Velocity and height of the position estimate, where it says that they are valid.
fn position(messages: &Messages, facts: &mut Vec<Fact>) -> Option<Stream> {
    let topic = "vehicle_local_position";
    let mut stream = stream(messages, topic)?;
    let table = messages.table(topic)?;
    let valid = |field: &str, flag: &str, sign: f64| -> Option<Vec<f64>> {
        let (column, flags) = (table.column(field)?, table.column(flag));
        let is_valid = |row: usize| flags.is_none_or(|flags| flags[row] != 0.0);
        let value = |(row, value): (usize, &f64)| if is_valid(row) { sign * value } else { f64::NAN };
        Some(column.iter().enumerate().map(value).collect())
    };
    for (axis, field, flag) in
        [(Axis::Roll, "vx", "v_xy_valid"), (Axis::Pitch, "vy", "v_xy_valid"), (Axis::Yaw, "vz", "v_z_valid")]
    {
        if let Some(value) = valid(field, flag, 1.0) {
            stream.add(Quantity::Velocity(axis), field, value);
        }
    }
    if let Some(value) = valid("z", "z_valid", -1.0) {
        stream.add(Quantity::Height, "z", value);
        let text = FactValue::Text("above where the position estimate began".to_owned());
        facts.push(Fact::assumed("height_m", text, "vehicle_local_position.z; the ground's own height is not known"));
    }
    Some(stream)
}

/// Rotor speeds that the motors' controllers report, by the motor that each says it drives, else in their order.
fn rotor_speeds(messages: &Messages, order: &[usize; 4]) -> Option<Stream> {
    /// `ACTUATOR_FUNCTION_MOTOR1`.
    const FIRST_MOTOR: f64 = 101.0;
    let topic = "esc_status";
    let table = messages.table(topic)?;
    let mut stream = Stream::at(topic, seconds(table.column("timestamp")?));
    let drives = |place: usize| table.column(&format!("esc[{place}].actuator_function"))?.first().copied();
    for (motor, given) in order.iter().enumerate() {
        let named = (0..8).find(|place| drives(*place) == Some(FIRST_MOTOR + *given as f64));
        let field = format!("esc[{}].esc_rpm", named.unwrap_or(*given));
        if let Some(column) = table.column(&field) {
            stream.add(Quantity::Rpm(motor), &field, column.iter().map(|rpm| rpm.abs()).collect());
        }
    }
    Some(stream)
}
