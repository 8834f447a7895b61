//! What the variables of a Crazyflie's log mean. They have the names of the firmware's log variables, body axes
//! forward-left-up: `gyro.x` in degrees per second, `acc.x` in g, `motor.m1` (of older firmware `pwm.m1_pwm`) a duty
//! cycle up to 65535; motors front right, rear right, rear left, front left, the first counter-clockwise.
//! `stateEstimate.pitch` is in degrees and nose up positive, although the rest is forward-left-up (bitcraze.io, "The
//! coordinate system of the Crazyflie"). `stateEstimateZ` is the same estimate in whole numbers, as the firmware's
//! `compressState` makes them: millimetres, milliradians per second with the pitch rate nose up, and the attitude's
//! quaternion in 32 bits.

use super::super::messages::{Messages, Table};
use super::super::quantity::{DEGREE_RAD, GRAVITY_M_S2, Quantity};
use super::super::quaternions::{ROUNDED, euler_columns};
use super::super::recording::{Fact, FactValue, Recording, Stream};
use super::TIMESTAMP;
use crate::axis::Axis;

/// Our motors 1 to 4 in the Crazyflie's names.
const MOTORS: [&str; 4] = ["m1", "m3", "m4", "m2"];
const DUTY: f64 = 1.0 / 65535.0;
const MILLI: f64 = 1e-3;

/// Every event with variables that have a meaning here, as a stream of its own.
pub(super) fn translated(messages: &Messages, mut recording: Recording) -> Recording {
    for (name, table) in &messages.tables {
        let Some(stamps_ms) = table.column(TIMESTAMP) else { continue };
        let stream = Stream::at(name, stamps_ms.iter().map(|stamp_ms| stamp_ms * MILLI).collect());
        let stream = compressed(messages, plain(messages, stream));
        // a quaternion's source has its parts' name without the last letter
        let is_of = |field: &str, source: &str| field.strip_prefix(source).is_some_and(|part| part.len() <= 1);
        let is_known = |field: &String| stream.columns.iter().any(|column| is_of(field, &column.source));
        let variables = table.fields().filter(|field| *field != TIMESTAMP).map(|field| format!("{name}.{field}"));
        recording.unknown_fields.extend(variables.filter(|field| !is_known(field)));
        if !stream.columns.is_empty() {
            recording.streams.push(stream);
        }
    }
    // the densest gyro first
    recording.streams.sort_by_key(|stream| core::cmp::Reverse(stream.time_s.len()));
    let assumed = [
        ("frame", "body forward-left-up, motors m1 front right, m2 rear right, m3 rear left, m4 front left"),
        ("motor_order", "ours are m1, m3, m4, m2; m1 and m3 turn counter-clockwise"),
        ("output", "the duty cycle over 65535"),
    ];
    recording.facts.extend(
        assumed.map(|(name, text)| Fact::assumed(name, FactValue::Text(text.to_owned()), "as every Crazyflie 2.1")),
    );
    recording
}

/// Forward-left-up to forward-right-down.
fn flu(axis: Axis, unit: f64) -> f64 {
    if axis == Axis::Roll { unit } else { -unit }
}

/// Where pitch is nose up already, and only yaw counts to the left.
fn nose_up(axis: Axis, unit: f64) -> f64 {
    if axis == Axis::Yaw { -unit } else { unit }
}

/// The variables that are numbers with a fraction, and the motors.
fn plain(messages: &Messages, mut stream: Stream) -> Stream {
    for axis in Axis::ALL {
        let letter = ["x", "y", "z"][axis.index()];
        stream = stream.with(messages, &format!("gyro.{letter}"), Quantity::Rate(axis), flu(axis, DEGREE_RAD));
        stream = stream.with(messages, &format!("acc.{letter}"), Quantity::Accel(axis), flu(axis, GRAVITY_M_S2));
        for (group, quantity) in [("stateEstimate", Quantity::Angle(axis)), ("controller", Quantity::Reference(axis))] {
            let field = format!("{group}.{}", axis.name());
            stream = stream.with(messages, &field, quantity, nose_up(axis, DEGREE_RAD));
        }
        // the world's x, y, z: forward, left and up at the start, taken for north, west and up
        let velocity = format!("stateEstimate.v{letter}");
        stream = stream.with(messages, &velocity, Quantity::Velocity(axis), flu(axis, 1.0));
    }
    for (motor, theirs) in MOTORS.into_iter().enumerate() {
        for field in [format!("motor.{theirs}"), format!("pwm.{theirs}_pwm")] {
            stream = stream.with(messages, &field, Quantity::Motor(motor), DUTY);
        }
    }
    stream = stream.with(messages, "pm.vbat", Quantity::Battery, 1.0);
    stream.with(messages, "stateEstimate.z", Quantity::Height, 1.0)
}

/// Quaternions and the estimate in whole numbers, behind the same in plain numbers: the first of a quantity is taken.
fn compressed(messages: &Messages, mut stream: Stream) -> Stream {
    let attitude = messages.table(&stream.name).and_then(attitude);
    if let Some((field, angles)) = attitude {
        for (axis, value) in Axis::ALL.into_iter().zip(angles) {
            stream.add(Quantity::Angle(axis), field, value);
        }
    }
    for (axis, rate) in Axis::ALL.into_iter().zip(["rateRoll", "ratePitch", "rateYaw"]) {
        let letter = ["x", "y", "z"][axis.index()];
        let (rate, velocity) = (format!("stateEstimateZ.{rate}"), format!("stateEstimateZ.v{letter}"));
        stream = stream.with(messages, &rate, Quantity::Rate(axis), nose_up(axis, MILLI));
        stream = stream.with(messages, &velocity, Quantity::Velocity(axis), flu(axis, MILLI));
    }
    stream.with(messages, "stateEstimateZ.z", Quantity::Height, MILLI)
}

/// Roll, pitch and yaw of an event's quaternion, and the field that they are from.
fn attitude(table: &Table) -> Option<(&'static str, [Vec<f64>; 3])> {
    let parts = ["w", "x", "y", "z"].map(|part| table.column(&format!("stateEstimate.q{part}")));
    if let [Some(w), Some(x), Some(y), Some(z)] = parts {
        let rows = (0..w.len()).map(|row| [w[row], x[row], y[row], z[row]]);
        return Some(("stateEstimate.q", angles(rows)));
    }
    let packed = table.column("stateEstimateZ.quat")?;
    Some(("stateEstimateZ.quat", angles(packed.iter().map(|packed| unpacked(*packed as u32)))))
}

/// Euler angles of quaternions w, x, y, z.
fn angles(quaternions: impl Iterator<Item = [f64; 4]>) -> [Vec<f64>; 3] {
    let mut columns = euler_columns(quaternions, ROUNDED);
    for (axis, column) in Axis::ALL.into_iter().zip(&mut columns) {
        column.iter_mut().for_each(|angle| *angle = flu(axis, *angle));
    }
    columns
}

/// w, x, y, z of a quaternion in 32 bits (quatcompress.h of the firmware): which of x, y, z, w is the largest, in two
/// bits, then the other three in that order, ten bits each: a sign, and the magnitude in parts of 511 of the largest
/// that a second one can be. Not a number where the three are too large for a unit.
fn unpacked(packed: u32) -> [f64; 4] {
    const MAGNITUDE: u32 = (1 << 9) - 1;
    let largest = (packed >> 30) as usize;
    let others = (0..4).filter(|place| *place != largest);
    let mut xyzw = [0.0; 4];
    for (place, shift) in others.zip([20, 10, 0]) {
        let magnitude =
            f64::from(packed >> shift & MAGNITUDE) / f64::from(MAGNITUDE) * core::f64::consts::FRAC_1_SQRT_2;
        xyzw[place] = if packed >> shift & (MAGNITUDE + 1) == 0 { magnitude } else { -magnitude };
    }
    xyzw[largest] = (1.0 - xyzw.iter().map(|part| part * part).sum::<f64>()).sqrt();
    let [x, y, z, w] = xyzw;
    [w, x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorded(variables: &[(&str, f64)]) -> Recording {
        let names = ["timestamp"].into_iter().chain(variables.iter().map(|(name, _)| *name));
        let mut table = Table::with_fields(names.map(str::to_owned));
        table.push([1000.0].into_iter().chain(variables.iter().map(|(_, value)| *value)));
        let messages = Messages { tables: [("fixedFrequency".to_owned(), table)].into(), ..Messages::default() };
        translated(&messages, Recording::default())
    }

    fn value(recording: &Recording, quantity: Quantity) -> f64 {
        recording.find(quantity).unwrap().1.value[0]
    }

    /// Of a turn by 0.3 rad about the body's left, which is nose down: sin 0.15 = 0.14944 is 108 of 511 parts of the
    /// root of a half, w is the largest (3).
    #[test]
    fn an_attitude_in_32_bits_is_the_quaternion_within_its_steps() {
        let packed = 3_u32 << 30 | 108 << 10;
        let of_packed = recorded(&[("stateEstimateZ.quat", f64::from(packed))]);
        let (w, y) = (libm::cos(0.15), libm::sin(0.15));
        let plain =
            [("stateEstimate.qw", w), ("stateEstimate.qx", 0.0), ("stateEstimate.qy", y), ("stateEstimate.qz", 0.0)];
        let of_plain = recorded(&plain);
        // half a step of 1.4e-3 is twice that as an angle
        assert!((value(&of_packed, Quantity::Angle(Axis::Pitch)) + 0.3).abs() < 1.4e-3);
        assert!((value(&of_plain, Quantity::Angle(Axis::Pitch)) + 0.3).abs() < 1e-12);
        assert_eq!(value(&of_packed, Quantity::Angle(Axis::Roll)), 0.0);
        // the sign's bit, and x the largest: half a turn about x but for 0.3 about the left
        let other = unpacked((512 + 108) << 20);
        assert!((other[2] + y).abs() < 1e-3 && (other[1] - w).abs() < 1e-3 && other[0] == 0.0, "{other:?}");
        // three that are too large together are no attitude
        assert!(unpacked(0x3fff_ffff).iter().any(|part| part.is_nan()));
    }

    #[test]
    fn variables_that_mean_nothing_here_are_kept_by_name() {
        let q = ["w", "x", "y", "z"].map(|part| format!("stateEstimate.q{part}"));
        let names = q.iter().map(String::as_str).chain(["gyro.x", "gyro.xRaw", "ctrlLee.torquex"]);
        let recording = recorded(&names.map(|name| (name, 0.5)).collect::<Vec<_>>());
        assert_eq!(recording.unknown_fields, ["fixedFrequency.gyro.xRaw", "fixedFrequency.ctrlLee.torquex"]);
    }

    #[test]
    fn whole_numbers_stand_behind_plain_ones() {
        let z = [
            ("stateEstimateZ.rateRoll", 100.0),
            ("stateEstimateZ.ratePitch", 200.0),
            ("stateEstimateZ.rateYaw", 300.0),
        ];
        let alone = recorded(&z);
        for (axis, rate_rad_s) in Axis::ALL.into_iter().zip([0.1, 0.2, -0.3]) {
            assert!((value(&alone, Quantity::Rate(axis)) - rate_rad_s).abs() < 1e-12);
        }
        let beside = recorded(
            &[&z[..], &[("gyro.x", 1.0), ("stateEstimateZ.vz", 500.0), ("stateEstimateZ.z", 1500.0)]].concat(),
        );
        assert!((value(&beside, Quantity::Rate(Axis::Roll)) - 1_f64.to_radians()).abs() < 1e-12);
        assert_eq!((value(&beside, Quantity::Velocity(Axis::Yaw)), value(&beside, Quantity::Height)), (-0.5, 1.5));
        let motors = ["m1", "m2", "m3", "m4"].map(|motor| format!("pwm.{motor}_pwm"));
        let duties: Vec<(&str, f64)> =
            motors.iter().map(String::as_str).zip([13107.0, 26214.0, 39321.0, 52428.0]).collect();
        let flown = recorded(&duties);
        assert_eq!([0, 1, 2, 3].map(|motor| value(&flown, Quantity::Motor(motor))), [0.2, 0.6, 0.8, 0.4]);
    }
}
