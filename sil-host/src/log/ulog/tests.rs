//! Files written here, whole, damaged and of other PX4s, and what they are read as.

use std::path::Path;

use proptest::prelude::*;

use super::super::passage::Passage;
use super::super::{FactValue, Log, LogErrorKind, Map, Quantity, Recording, parse_bytes};
use super::write;
use crate::axis::Axis;

/// A ULog file message by message.
struct File(Vec<u8>);

impl File {
    fn new() -> File {
        let mut head = b"ULog\x01\x12\x35\x01".to_vec();
        head.extend([0; 8]);
        File(head).message(b'B', &[0; 40])
    }

    fn message(mut self, kind: u8, content: &[u8]) -> File {
        self.0.extend((content.len() as u16).to_le_bytes());
        self.0.push(kind);
        self.0.extend(content);
        self
    }

    /// Definitions, then subscriptions under the numbers from 0 on.
    fn topics(self, topics: &[(&str, &str)]) -> File {
        let file = topics.iter().fold(self, |file, (name, fields)| {
            file.message(b'F', format!("{name}:uint64_t timestamp;{fields}").as_bytes())
        });
        (0..)
            .zip(topics)
            .fold(file, |file, (number, (name, _))| file.message(b'A', &[&[0, number, 0], name.as_bytes()].concat()))
    }

    fn parameter(self, name: &str, value: f32) -> File {
        let key = format!("float {name}");
        self.message(b'P', &[&[key.len() as u8], key.as_bytes(), &value.to_le_bytes()].concat())
    }

    fn data(self, number: u8, stamp_us: u64, numbers: &[f32]) -> File {
        let numbers: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.message(b'D', &[&[number, 0][..], &stamp_us.to_le_bytes(), &numbers].concat())
    }

    fn read(self) -> Result<Log, String> {
        parse_bytes(Path::new("x.ulg"), self.0, None).map_err(|error| error.to_string())
    }

    fn recording(&self) -> Recording {
        let passage = Passage::through(self.0.len(), &|_, _| ());
        super::recording("x.ulg", &self.0, None, &passage).unwrap()
    }
}

/// The vehicle's own log says from when on it was flown by what the flight had taught.
#[test]
fn a_model_that_was_learnt_in_flight_is_told() {
    let topics = [
        ("vehicle_angular_velocity", "float[3] xyz;"),
        ("actuator_motors", "float[12] control;"),
        ("learnt_model", "float[2] gain;float lag_s;"),
    ];
    let file = (0..300).fold(File::new().topics(&topics), |file, row| {
        let stamp_us = 1_000_000 + 4000 * row;
        let file = file.data(0, stamp_us, &[0.01 * row as f32, -0.5, 0.25]).data(1, stamp_us, &[0.3; 12]);
        match row {
            100 | 150 => file.data(2, stamp_us, &[1.37, 1.0, 0.003]),
            200 => file.data(2, stamp_us, &[1.4, 0.92, 0.0042]),
            _ => file,
        }
    });
    let told: Vec<String> = file.read().unwrap().notes.into_iter().filter(|note| note.contains("learnt")).collect();
    let expected = [
        "from 1.40 s on flown by another model than the head's: learnt: roll +37 %, pitch +0 %, lag 3 ms",
        "from 1.80 s on flown by another model than the head's: learnt: roll +40 %, pitch -8 %, lag 4 ms",
    ];
    assert_eq!(told, expected);
}

/// One message of each topic of [`flight`], heads included.
const ROUND_BYTES: usize = (3 + 2 + 8 + 12) + (3 + 2 + 8 + 48);

/// Topics 0 gyro, 1 motors, 300 messages each.
fn flight(head: impl Fn(File) -> File) -> File {
    let file = head(File::new());
    let file = file.topics(&[("vehicle_angular_velocity", "float[3] xyz;"), ("actuator_motors", "float[12] control;")]);
    (0..300).fold(file, |file, row| {
        let mut control = [f32::NAN; 12];
        control[..4].copy_from_slice(&[0.1, 0.2, 0.3, 0.4]);
        let file = file.data(0, 1_000_000 + 4000 * row, &[0.01 * row as f32, -0.5, 0.25]);
        file.data(1, 1_000_100 + 4000 * row, &control)
    })
}

fn geometry(file: File, corners: [(f32, f32, f32); 4]) -> File {
    corners.into_iter().enumerate().fold(file, |file, (rotor, (forward, right, moment))| {
        let file = file.parameter(&format!("CA_ROTOR{rotor}_PX"), forward);
        let file = file.parameter(&format!("CA_ROTOR{rotor}_PY"), right);
        file.parameter(&format!("CA_ROTOR{rotor}_KM"), moment)
    })
}

/// A whole flight, as bytes.
pub fn whole() -> Vec<u8> {
    flight(|file| file).0
}

#[test]
fn motors_are_ours_by_the_geometry_in_the_file() {
    // front left cw, rear left ccw, rear right cw, front right ccw: ours are 4th, 2nd, 1st, 3rd
    let corners = [(0.1, -0.1, -0.05), (-0.1, -0.1, 0.05), (-0.1, 0.1, -0.05), (0.1, 0.1, 0.05)];
    let file = flight(|file| geometry(file, corners));
    let fact = file.recording().facts.into_iter().find(|fact| fact.name == "motor1").unwrap();
    assert_eq!(fact.value, FactValue::Text("PX4's motor 4: front right, counter-clockwise".to_owned()));
    assert!(!fact.is_assumed);
    let log = file.read().unwrap();
    let first = log.motors().unwrap().map(|motor| motor[5] as f32);
    assert_eq!(first, [0.4, 0.2, 0.1, 0.3]);
    // without parameters the order is PX4's own, and that is said
    let plain = flight(|file| file);
    assert!(plain.recording().facts.iter().any(|fact| fact.name == "motor_order" && fact.is_assumed));
    assert_eq!(plain.read().unwrap().motors().unwrap().map(|motor| motor[5] as f32), [0.1, 0.2, 0.3, 0.4]);
    // all the other way round
    let turned = corners.map(|(forward, right, moment)| (forward, right, -moment));
    let facts = flight(|file| geometry(file, turned)).recording().facts;
    assert!(facts.iter().any(|fact| fact.name == "spin"));
}

#[test]
fn what_is_no_quad_x_is_refused_with_its_parameter() {
    let cases: [(&str, File); 2] = [
        ("MAV_TYPE is 22", flight(|file| file.parameter("MAV_TYPE", 22.0))),
        ("6 rotors by its parameter CA_ROTOR_COUNT", flight(|file| file.parameter("CA_ROTOR_COUNT", 6.0))),
    ];
    for (expected, file) in cases {
        let message = file.read().unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

/// Front, rear, right, left of a plus: in axes between its arms front left, rear right, front right, rear left.
#[test]
fn a_plus_is_an_x_in_axes_between_its_arms() {
    let plus = [(0.1, 0.0, -0.05), (-0.1, 0.0, -0.05), (0.0, 0.1, 0.05), (0.0, -0.1, 0.05)];
    let x = [(0.1, -0.1, -0.05), (-0.1, 0.1, -0.05), (0.1, 0.1, 0.05), (-0.1, -0.1, 0.05)];
    let [log, of_x] = [plus, x].map(|corners| flight(|file| geometry(file, corners)).read().unwrap());
    assert_eq!(log.motor_command, of_x.motor_command);
    assert!(log.facts.iter().any(|fact| fact.name == "frame" && fact.value.to_string().contains("plus")));
    assert_eq!(log, { Log { facts: log.facts.clone(), notes: log.notes.clone(), ..of_x.turned(45.0).unwrap() } });
    // whose parameters say no more than that it is one: right, left, front, rear
    let generic = flight(|file| file.parameter("SYS_AUTOSTART", 5001.0)).read().unwrap();
    let right_left_front_rear = [(0.0, 0.1, 0.05), (0.0, -0.1, 0.05), (0.1, 0.0, -0.05), (-0.1, 0.0, -0.05)];
    let said = flight(|file| geometry(file, right_left_front_rear)).read().unwrap();
    assert_eq!((&generic.motor_command, &generic.rate_rad_s), (&said.motor_command, &said.rate_rad_s));
}

#[test]
fn a_stopped_motor_and_pulse_widths_become_commands_from_0_to_1() {
    let file = File::new().parameter("PWM_MIN", 1100.0).parameter("PWM_MAX", 1900.0).parameter("PWM_MAIN_MIN1", 900.0);
    let file = file.parameter("PWM_MAIN_MAX1", -1.0);
    let file = file.topics(&[("sensor_combined", "float[3] gyro_rad;"), ("actuator_outputs", "float[4] output;")]);
    let file = (0..300).fold(file, |file, row| {
        let pulse_us = [1400.0, 1500.0, 900.0, 2100.0];
        file.data(0, 4000 * row, &[0.0, 0.1, 0.2]).data(1, 4000 * row, &pulse_us)
    });
    let log = file.read().unwrap();
    assert_eq!(log.motors().unwrap().map(|motor| motor[7]), [0.5, 0.5, 0.0, 1.0]);
    // the names up to 1.12, as in a log whose outputs are all -1 for these two
    let old = File::new().parameter("PWM_MAIN_MIN", 1000.0).parameter("PWM_MAIN_MAX", 1800.0);
    let old = old.topics(&[("sensor_combined", "float[3] gyro_rad;"), ("actuator_outputs", "float[4] output;")]);
    let old = (0..300).fold(old, |file, row| {
        file.data(0, 4000 * row, &[0.0, 0.1, 0.2]).data(1, 4000 * row, &[1400.0, 1600.0, 900.0, 2100.0])
    });
    assert_eq!(old.read().unwrap().motors().unwrap().map(|motor| motor[7]), [0.5, 0.75, 0.0, 1.0]);
    let mut stopped = flight(|file| file).0;
    let nan = f32::NAN.to_le_bytes();
    // motor 2 in the last command but one, which is in force at the last row
    let at = stopped.len() - ROUND_BYTES - 4 * 11;
    stopped[at..at + 4].copy_from_slice(&nan);
    let log = File(stopped).read().unwrap();
    assert_eq!(log.motors().unwrap()[1][297..], [f64::from(0.2_f32), 0.0]);
}

/// Outputs of the driver whose motors move, here on a CAN bus, in place of those of one that drives nothing.
#[test]
fn motors_on_a_can_bus_are_those_that_move() {
    let file =
        File::new().topics(&[("sensor_combined", "float[3] gyro_rad;"), ("actuator_outputs", "float[4] output;")]);
    let file = file.message(b'A', &[&[1, 2, 0], &b"actuator_outputs"[..]].concat());
    let file = (0..300).fold(file, |file, row| {
        let raw = [819.1, 2047.75, 4095.5, 8191.0];
        file.data(0, 4000 * row, &[0.0, 0.1, 0.2]).data(1, 4000 * row, &[0.0; 4]).data(2, 4000 * row, &raw)
    });
    let commands = file.read().unwrap().motors().unwrap().map(|motor| motor[7]);
    for (command, expected) in commands.into_iter().zip([0.1, 0.25, 0.5, 1.0]) {
        assert!((command - expected).abs() < 1e-6, "{commands:?}");
    }
}

/// Rows of a flight by PX4's default profile: motors 10 times a second, the set-points they are mixed of 50 times. One
/// motor is told otherwise by so much; motor 4 is cut off at full command now and then.
fn seldom(otherwise: f64) -> File {
    let stamped = "uint64_t timestamp_sample;float[3] xyz;";
    let file = File::new().topics(&[
        ("vehicle_angular_velocity", "float[3] xyz;"),
        ("actuator_motors", "uint64_t timestamp_sample;float[12] control;"),
        ("vehicle_torque_setpoint", stamped),
        ("vehicle_thrust_setpoint", stamped),
    ]);
    let sampled = |file: File, number: u8, stamp_us: u64, values: &[f32]| {
        let values: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let stamps = [(stamp_us + 300).to_le_bytes(), stamp_us.to_le_bytes()].concat();
        file.message(b'D', &[&[number, 0], &stamps[..], &values].concat())
    };
    (0..4000_u64).fold(file, |file, row| {
        let stamp_us = 1_000_000 + 5000 * row;
        let (torque, motors) = mixed(row, otherwise);
        let file = file.data(0, stamp_us, &[0.0, 0.1, 0.2]);
        let file = match row % 4 {
            0 => sampled(sampled(file, 3, stamp_us, &[0.0, 0.0, -0.5]), 2, stamp_us, &torque),
            _ => file,
        };
        let mut control = [f32::NAN; 12];
        control[..4].copy_from_slice(&motors);
        if row % 20 == 0 { sampled(file, 1, stamp_us, &control) } else { file }
    })
}

/// Torques and motors of a row.
fn mixed(row: u64, otherwise: f64) -> ([f32; 3], [f32; 4]) {
    let t = row as f64;
    let torque = [0.3 * libm::sin(0.07 * t), 0.2 * libm::cos(0.05 * t), 0.1 * libm::sin(0.013 * t)];
    let mix = [[-0.7, 0.7, 0.5], [0.7, -0.7, 0.5], [0.7, 0.7, -0.5], [-0.9, -0.9, -0.6]];
    let base = [0.5, 0.5, 0.5, 0.7];
    let command = |motor: usize| {
        let turns: f64 = mix[motor].iter().zip(torque).map(|(share, torque)| share * torque).sum();
        let other = if motor == 0 { otherwise * libm::sin(0.3 * t) } else { 0.0 };
        (base[motor] + turns + other).clamp(0.0, 1.0) as f32
    };
    (torque.map(|torque| torque as f32), [0, 1, 2, 3].map(command))
}

#[test]
fn motors_between_their_rows_are_what_the_set_points_mix() {
    let log = seldom(0.0).read().unwrap();
    assert!(log.notes.iter().any(|note| note.contains("50 times a second: actuator_motors has 10")), "{:?}", log.notes);
    let motors = log.motors().unwrap();
    for (row, time_s) in log.time_s.iter().enumerate().skip(100).take(3000) {
        // what was sent last before this row
        let sent = ((time_s - 1.0003) / 0.02).floor() as u64 * 4;
        for (motor, command) in mixed(sent, 0.0).1.into_iter().enumerate() {
            assert!((motors[motor][row] - f64::from(command)).abs() < 2e-3, "{time_s} s, motor {}", motor + 1);
        }
    }
    // set-points that say other motors than were told are left alone
    let log = seldom(0.1).read().unwrap();
    assert!(!log.notes.iter().any(|note| note.contains("set-points")), "{:?}", log.notes);
}

/// A log as `sil fly` makes it: times in whole us, all quantities that a ULog has a place for.
fn any_log() -> impl Strategy<Value = Log> {
    (100usize..130, any::<bool>()).prop_flat_map(|(rows, optional)| {
        let values = proptest::collection::vec(0.0..1.0_f64, rows * Quantity::ALL.len());
        let steps = proptest::collection::vec(3900_u32..4100, rows);
        (values, steps).prop_map(move |(values, steps)| {
            let mut log = Log { axes: [true, true, true], ..Log::default() };
            for (place, quantity) in Quantity::ALL.into_iter().enumerate() {
                let values: Vec<f64> = values[place * rows..(place + 1) * rows].to_vec();
                let column = match quantity {
                    Quantity::Time => {
                        let us = steps.iter().scan(0_u32, |us, step| {
                            *us += step;
                            Some(f64::from(*us) * 1e-6)
                        });
                        us.collect()
                    }
                    Quantity::Command(_) | Quantity::Thrust | Quantity::Rpm(_) => continue,
                    Quantity::Reference(Axis::Yaw) | Quantity::Battery if !optional => continue,
                    Quantity::Motor(_) | Quantity::Stick(_) => values,
                    Quantity::Angle(Axis::Pitch) => values.iter().map(|value| 2.8 * (value - 0.5)).collect(),
                    _ => values.iter().map(|value| 6.0 * (value - 0.5)).collect(),
                };
                log.set_column(quantity, column);
            }
            log
        })
    })
}

fn written(log: &Log) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(log, &mut bytes).unwrap();
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn reading_what_was_written_gives_every_value_back(log in any_log()) {
        let back = parse_bytes(Path::new("x"), written(&log), None).unwrap();
        prop_assert_eq!(back.rows(), log.rows());
        for quantity in Quantity::ALL {
            prop_assert_eq!(back.column(quantity).is_some(), log.column(quantity).is_some(), "{}", quantity.name());
            let pairs = back.column(quantity).into_iter().flatten().zip(log.column(quantity).into_iter().flatten());
            for (back, value) in pairs {
                // 32 bit floats of numbers up to 3: 1.2e-7 each; angles go through four of them, and pitch up to 1.4
                // rad makes the quaternion's angles 1 / cos(1.4) = 6 times less certain, squared for roll and yaw
                let tolerance = match quantity {
                    Quantity::Time => 1e-9,
                    Quantity::Angle(_) => 1e-5,
                    _ => 2.4e-7,
                };
                prop_assert!((back - value).abs() <= tolerance, "{}: {} {}", quantity.name(), back, value);
            }
        }
        prop_assert_eq!(back.sent_commands, None);
    }

    #[test]
    fn a_file_with_any_bytes_damaged_or_cut_off_is_read_or_refused(
        damages in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        end in any::<prop::sample::Index>(),
    ) {
        let mut bytes = flight(|file| file.parameter("MAV_TYPE", 2.0)).0;
        for (at, byte) in damages {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate(end.index(bytes.len() + 1));
        if let Ok(log) = parse_bytes(Path::new("x.ulg"), bytes, None) {
            prop_assert!(log.rows() >= 100 && log.time_s.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}

#[test]
fn one_damaged_message_costs_itself_and_a_cut_file_keeps_what_it_has() {
    let whole = flight(|file| file);
    let length = whole.0.len();
    let rows = File(whole.0.clone()).read().unwrap().rows();
    let cut = File(whole.0[..length - 30].to_vec()).read().unwrap();
    assert_eq!(cut.rows(), rows);
    assert!(
        cut.notes.iter().any(|note| note.starts_with("the file is cut off or damaged from byte")),
        "{:?}",
        cut.notes
    );
    // an unknown topic number in a message in the middle
    let mut wrong = whole.0.clone();
    let at = length - 100 * ROUND_BYTES;
    assert_eq!(wrong[at + 2], b'D');
    wrong[at + 3] = 77;
    assert_eq!(File(wrong).read().unwrap().rows(), rows - 1);
    // a length that leads nowhere: reading goes on at the next mark
    let mut lost = whole.0[..at].to_vec();
    lost.extend([0xff, 0xff, 0x00]);
    let lost = File(lost).message(b'S', &[0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]);
    let lost = File([lost.0, whole.0[at..].to_vec()].concat()).read().unwrap();
    assert_eq!(lost.rows(), rows);
    assert!(lost.notes.iter().any(|note| note.starts_with("3 damaged bytes left out")), "{:?}", lost.notes);
}

/// PX4 counts topics from 0, others may not.
#[test]
fn topics_may_have_any_numbers() {
    let file = [("vehicle_angular_velocity", "float[3] xyz;"), ("actuator_motors", "float[4] control;")]
        .iter()
        .fold(File::new(), |file, (name, fields)| {
            file.message(b'F', format!("{name}:uint64_t timestamp;{fields}").as_bytes())
        });
    let file = file.message(b'A', &[&[0, 0xff, 0xff], &b"vehicle_angular_velocity"[..]].concat());
    let file = file.message(b'A', &[&[0, 0x00, 0x80], &b"actuator_motors"[..]].concat());
    let stamp = |row: u64| (1_000_000 + 4000 * row).to_le_bytes();
    let numbers = |of: &[f32]| of.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let file = (0..200).fold(file, |file, row| {
        let file =
            file.message(b'D', &[&[0xff, 0xff], &stamp(row)[..], &numbers(&[0.01 * row as f32, -0.5, 0.25])].concat());
        file.message(b'D', &[&[0x00, 0x80], &stamp(row)[..], &numbers(&[0.1, 0.2, 0.3, 0.4])].concat())
    });
    let log = file.read().unwrap();
    assert_eq!(log.motors().unwrap().map(|motor| motor[5] as f32), [0.1, 0.2, 0.3, 0.4]);
    assert_eq!(log.rate_rad_s[1].as_ref().unwrap()[5] as f32, -0.5);
}

#[test]
fn what_is_no_ulog_or_of_an_unknown_kind_is_refused() {
    let damaged = |bytes: Vec<u8>| match parse_bytes(Path::new("x.ulg"), bytes, None).unwrap_err().kind {
        LogErrorKind::Damaged { reason, .. } => reason,
        other => other.to_string(),
    };
    assert_eq!(damaged(b"anything".to_vec()), "its head is not that of a ULog file");
    let mut flags = [0; 40];
    flags[9] = 1;
    let unknown = File(File::new().0[..16].to_vec()).message(b'B', &flags);
    assert!(damaged(unknown.0).contains("incompatible flag bits"));
}

#[test]
fn a_map_takes_the_fields_it_names() {
    let map = "description = \"\"\nframe = \"FLU\"\naxes = [\"roll\", \"pitch\", \"yaw\"]\n[quantities]\n\
               time_us = { column = \"timestamp\" }\np_rad_s = { column = \"vehicle_angular_velocity.xyz[0]\" }\n\
               q_rad_s = { column = \"vehicle_angular_velocity.xyz[1]\" }\n\
               r_rad_s = { column = \"vehicle_angular_velocity.xyz[2]\" }\n\
               motor1 = { column = \"actuator_motors.control[3]\" }\n\
               motor2 = { column = \"actuator_motors.control[2]\" }\n\
               motor3 = { column = \"actuator_motors.control[1]\" }\n\
               motor4 = { column = \"actuator_motors.control[0]\" }\n";
    // a vehicle that is no quadrotor by its parameter
    let bytes = flight(|file| file.parameter("MAV_TYPE", 22.0)).0;
    let read = |text: &str| {
        parse_bytes(Path::new("x.ulg"), bytes.clone(), Some(&Map::parse("m", text).unwrap())).map_err(|e| e.to_string())
    };
    let log = read(map).unwrap();
    assert_eq!(log.motors().unwrap().map(|motor| motor[5] as f32), [0.4, 0.3, 0.2, 0.1]);
    assert_eq!(log.rate_rad_s[1].as_ref().unwrap()[5], 0.5);
    let message = read(&map.replace("xyz[2]", "xyz[7]")).unwrap_err();
    assert!(
        message.contains("`vehicle_angular_velocity.xyz[7]`: no such field, which the map m takes for r_rad_s"),
        "{message}"
    );
}
