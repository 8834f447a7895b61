//! Files written here, whole, damaged and of several ArduPilots, and what they are read as.

use std::path::Path;

use proptest::prelude::*;

use super::super::{FactValue, Log, Quantity, parse_bytes};

/// A DataFlash file message by message.
#[derive(Clone)]
struct File(Vec<u8>);

impl File {
    fn new() -> File {
        File(Vec::new()).definition(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    }

    fn definition(self, number: u8, length: u8, name: &str, format: &str, labels: &str) -> File {
        let padded = |text: &str, length: usize| [text.as_bytes(), &vec![0; length - text.len()]].concat();
        let content = [vec![number, length], padded(name, 4), padded(format, 16), padded(labels, 64)].concat();
        self.message(128, &content)
    }

    fn message(mut self, number: u8, content: &[u8]) -> File {
        self.0.extend([0xa3, 0x95, number]);
        self.0.extend(content);
        self
    }

    fn parameter(self, name: &str, value: f32) -> File {
        let mut content = name.as_bytes().to_vec();
        content.resize(16, 0);
        content.extend(value.to_le_bytes());
        self.message(129, &content)
    }

    fn read(self) -> Result<Log, String> {
        parse_bytes(Path::new("x.bin"), self.0, None).map_err(|error| error.to_string())
    }
}

const PULSE_US: [u16; 4] = [1200, 1400, 1600, 1800];
/// One round of messages: IMU, RCOU, heads included.
const ROUND_BYTES: usize = (3 + 8 + 1 + 24) + (3 + 8 + 8);

/// Head and 300 rounds of IMU and RCOU at 400 Hz, a second IMU beside the first.
fn flight(head: impl Fn(File) -> File) -> File {
    let file = File::new().definition(129, 23, "PARM", "Nf", "Name,Value");
    let file = file.definition(130, 36, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
    let file = head(file.definition(131, 19, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4"));
    (0..300_u64).fold(file, |file, row| {
        let stamp = (1_000_000 + 2500 * row).to_le_bytes();
        let number = |value: f32| value.to_le_bytes().to_vec();
        let imu = [0.01 * row as f32, -0.2, 0.3, 0.1, -0.1, -9.8].map(number).concat();
        let outputs = PULSE_US.map(|pulse_us| pulse_us.to_le_bytes().to_vec()).concat();
        file.message(130, &[&stamp[..], &[0], &imu].concat()).message(131, &[&stamp[..], &outputs].concat())
    })
}

fn motors(log: &Log) -> [f64; 4] {
    log.motors().unwrap().map(|motor| motor[9])
}

/// A whole flight, as bytes.
pub fn whole() -> Vec<u8> {
    flight(|file| file).0
}

#[test]
fn outputs_are_commands_of_our_motors_by_frame_and_channels() {
    let range = |file: File| file.parameter("MOT_PWM_MIN", 1000.0).parameter("MOT_PWM_MAX", 2000.0);
    let x = flight(|file| range(file).parameter("FRAME_CLASS", 1.0).parameter("FRAME_TYPE", 1.0));
    assert_eq!(motors(&x.read().unwrap()), [0.2, 0.4, 0.6, 0.8]);
    // Betaflight's order: rear right, front right, rear left, front left
    let betaflight = flight(|file| range(file).parameter("FRAME_CLASS", 1.0).parameter("FRAME_TYPE", 12.0));
    let log = betaflight.read().unwrap();
    assert_eq!(motors(&log), [0.4, 0.6, 0.8, 0.2]);
    let motor1 = log.facts.iter().find(|fact| fact.name == "motor1").unwrap();
    assert_eq!(motor1.value, FactValue::Text("ArduPilot's motor 2: front right, counter-clockwise".to_owned()));
    assert_eq!((motor1.source.as_str(), motor1.is_assumed), ("parameter FRAME_TYPE = 12", false));
    // motors on other channels
    let swapped = flight(|file| {
        let file =
            [(1, 36.0), (2, 35.0), (3, 34.0), (4, 33.0)].into_iter().fold(range(file), |file, (channel, function)| {
                file.parameter(&format!("SERVO{channel}_FUNCTION"), function)
            });
        file.parameter("FRAME_TYPE", 1.0)
    });
    assert_eq!(motors(&swapped.read().unwrap()), [0.8, 0.6, 0.4, 0.2]);
    // nothing said: the usual X and range, and that is listed
    let silent = flight(|file| file).read().unwrap();
    let assumed: Vec<&str> =
        silent.facts.iter().filter(|fact| fact.is_assumed).map(|fact| fact.name.as_str()).collect();
    for name in ["frame", "motor1", "motor1_channel", "output_min_us", "output_max_us"] {
        assert!(assumed.contains(&name), "{name}: {assumed:?}");
    }
    assert_eq!(silent.accel_body_m_s2[2].as_ref().unwrap()[0] as f32, -9.8);
}

#[test]
fn the_throttle_channels_range_holds_where_the_motors_have_none() {
    let file =
        flight(|file| file.parameter("MOT_PWM_MIN", 0.0).parameter("RC3_MIN", 1200.0).parameter("RC3_MAX", 1800.0));
    assert_eq!(motors(&file.read().unwrap()), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
}

#[test]
fn what_is_no_quad_x_is_refused_with_its_parameter() {
    for (name, value) in [("FRAME_CLASS", 2.0), ("FRAME_TYPE", 4.0), ("FRAME", 5.0)] {
        let message = flight(|file| file.parameter(name, value)).read().unwrap_err();
        assert!(message.contains(&format!("parameter {name} is {value}")), "{message}");
    }
}

/// ArduPilot's list of `FRAME_CLASS`, but for the quadrotor: a number alone says nothing to whoever flew it.
#[test]
fn another_airframe_is_refused_by_its_name() {
    for (class, name) in [(2.0, "a hexarotor"), (6.0, "a helicopter;"), (7.0, "a tricopter"), (10.0, "a bicopter")] {
        let message = flight(|file| file.parameter("FRAME_CLASS", class)).read().unwrap_err();
        assert!(message.contains(&format!("parameter FRAME_CLASS is {class}, {name}")), "{message}");
    }
    // a later ArduPilot's, whose name nobody here knows
    let message = flight(|file| file.parameter("FRAME_CLASS", 99.0)).read().unwrap_err();
    assert!(message.contains("parameter FRAME_CLASS is 99; only quadrotors"), "{message}");
}

/// Until 2016 a hexarotor's frame was an X as a quadrotor's; a gimbal's servos are no motors.
#[test]
fn six_outputs_that_follow_the_throttle_are_no_quadrotors() {
    let flown = |head: fn(File) -> File, servos: fn(u16) -> u16| {
        let file = head(File::new().definition(129, 23, "PARM", "Nf", "Name,Value"));
        let file = file.definition(130, 23, "IMU", "Qfff", "TimeUS,GyrX,GyrY,GyrZ");
        let file = file.definition(131, 23, "RCOU", "QHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6");
        let file = (0..300_u16).fold(file, |file, row| {
            let stamp = (1_000_000 + 2500 * u64::from(row)).to_le_bytes();
            let gyro = [0.01 * f32::from(row), -0.2, 0.3].map(|rate| rate.to_le_bytes().to_vec()).concat();
            let throttle = if row > 100 { 1500 + row % 50 } else { 1100 };
            let outputs = [throttle, throttle + 20, throttle - 20, throttle, servos(throttle), servos(throttle)];
            let outputs = outputs.map(|pulse_us| pulse_us.to_le_bytes().to_vec()).concat();
            file.message(130, &[&stamp[..], &gyro].concat()).message(131, &[&stamp[..], &outputs].concat())
        });
        file.read()
    };
    let old: fn(File) -> File = |file| file.parameter("FRAME", 1.0);
    let message = flown(old, |throttle| throttle + 10).unwrap_err();
    assert!(message.contains("RCOU.C5 and RCOU.C6 move as its first four motors do"), "{message}");
    assert!(flown(old, |_| 1500).is_ok());
    // what the vehicle is a newer one says itself
    assert!(flown(|file| file.parameter("FRAME_CLASS", 1.0), |throttle| throttle + 10).is_ok());
}

#[test]
fn the_first_log_of_px4_is_told_from_an_ardupilots() {
    let file = File::new().definition(129, 11, "TIME", "Q", "StartTime").message(129, &7_u64.to_le_bytes());
    assert!(file.read().unwrap_err().contains("it is PX4's log of before 2017"));
}

/// Right, left, front, rear: in axes between the arms front right, rear left, front left, rear right.
#[test]
fn a_plus_is_an_x_in_axes_between_its_arms() {
    let [plus, x] = [0.0, 1.0].map(|kind| flight(|file| file.parameter("FRAME_TYPE", kind)).read().unwrap());
    assert_eq!(motors(&plus), motors(&x));
    assert_eq!(plus.rate_rad_s, x.turned(45.0).unwrap().rate_rad_s);
}

#[test]
fn attitude_is_read_in_degrees_and_yaw_comes_round() {
    let file =
        flight(|file| file.definition(132, 23, "ATT", "Qcccccc", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"));
    let file = (0..300_u64).fold(file, |file, row| {
        let angles: [i16; 6] = [100, 200, -300, -400, 9000, -9000];
        let angles = angles.map(|angle| angle.to_le_bytes().to_vec()).concat();
        file.message(132, &[&(1_000_000 + 2500 * row).to_le_bytes()[..], &angles].concat())
    });
    let log = file.read().unwrap();
    let degrees = |quantity| log.column(quantity).unwrap()[3].to_degrees();
    use crate::axis::Axis::{Pitch, Roll, Yaw};
    let found = [Roll, Pitch, Yaw].map(|axis| [degrees(Quantity::Reference(axis)), degrees(Quantity::Angle(axis))]);
    for (found, expected) in found.into_iter().flatten().zip([1.0, 2.0, -3.0, -4.0, 90.0, -90.0]) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

/// Of two cores the first one's, which is said.
#[test]
fn without_att_the_estimator_has_the_attitude() {
    let file = flight(|file| file.definition(132, 18, "XKF1", "QBccC", "TimeUS,C,Roll,Pitch,Yaw"));
    let file = (0..600_u64).fold(file, |file, row| {
        let (core, roll) = ((row % 2) as u8, if row % 2 == 0 { 250_i16 } else { 900 });
        let angles = [roll.to_le_bytes(), (-400_i16).to_le_bytes(), 27_000_u16.to_le_bytes()].concat();
        let time_us = 1_000_000 + 2500 * (row / 2);
        file.message(132, &[&time_us.to_le_bytes()[..], &[core], &angles].concat())
    });
    let log = file.read().unwrap();
    let degrees = |axis| log.column(Quantity::Angle(axis)).unwrap()[3].to_degrees();
    use crate::axis::Axis::{Pitch, Roll, Yaw};
    for (axis, expected) in [(Roll, 2.5), (Pitch, -4.0), (Yaw, -90.0)] {
        assert!((degrees(axis) - expected).abs() < 1e-12, "{axis:?} {}", degrees(axis));
    }
    assert!(log.facts.iter().any(|fact| fact.name == "attitude" && fact.value == FactValue::Text("XKF1".to_owned())));
}

#[test]
fn damaged_bytes_cost_their_messages_and_are_counted() {
    let whole = flight(|file| file).0;
    let mut damaged = whole.clone();
    let at = whole.len() - 100 * ROUND_BYTES;
    damaged[at] = 0;
    let log = File(damaged).read().unwrap();
    assert_eq!(log.rows(), 299);
    assert!(log.notes.iter().any(|note| note.starts_with("36 of ")), "{:?}", log.notes);
    let cut = File(whole[..whole.len() - 5].to_vec()).read().unwrap();
    assert_eq!(cut.rows(), 300);
    assert!(cut.notes.iter().any(|note| note.starts_with("14 of ")), "{:?}", cut.notes);
}

/// Found by fuzzing: a definition of the definitions themselves, whose length is the first byte of another one that
/// says no length at all.
#[test]
fn definitions_that_overlap_are_none() {
    let mut first = vec![128, 0xa3, 0x95, 0x80, 84, 0];
    first.resize(86, b'B');
    let refused = File(Vec::new()).message(128, &first).definition(129, 19, "PARM", "Nf", "Name,Value").read();
    assert!(refused.is_err(), "{refused:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_file_with_any_bytes_damaged_or_cut_off_is_read_or_refused(
        damages in proptest::collection::vec((0_usize..600, any::<u8>()), 0..6),
        end in any::<prop::sample::Index>(),
    ) {
        let mut bytes = flight(|file| file.parameter("FRAME_TYPE", 1.0)).0;
        for (at, byte) in damages {
            bytes[at] = byte;
        }
        bytes.truncate(end.index(bytes.len() + 1));
        if let Ok(log) = parse_bytes(Path::new("x.bin"), bytes, None) {
            prop_assert!(log.rows() >= 100 && log.time_s.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
