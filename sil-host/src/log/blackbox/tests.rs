//! Files written here, whole and damaged, of several firmwares, and what they are read as.

use std::path::Path;

use proptest::prelude::*;

use super::super::{Log, Quantity, parse_bytes};
use crate::axis::Axis;

/// Numbers as Blackbox writes them: seven bits a byte.
fn unsigned(mut value: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value > 127 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

/// Zigzag: the sign in the lowest bit.
fn signed(value: i32) -> Vec<u8> {
    unsigned(((value << 1) ^ (value >> 31)).cast_unsigned())
}

const GYRO: [i32; 3] = [100, -50, 25];
const ACCELEROMETER: [i32; 3] = [0, 205, 2048];
const OUTPUTS: [i32; 4] = [648, 848, 1048, 1248];
const ATTITUDE: [i32; 3] = [100, 200, 2700];

/// The head: gyro, accelerometer, attitude, motors; each P frame holds differences to the frame before.
fn head(revision: &str, lines: &str) -> Vec<u8> {
    let names = "loopIteration,time,gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2],\
                 attitude[0],attitude[1],attitude[2],motor[0],motor[1],motor[2],motor[3],vbatLatest";
    let repeated = |first: &str, rest: &str| format!("{first}{}", format!(",{rest}").repeat(14));
    format!(
        "H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\nH Field I name:{names}\n\
         H Field I signed:0,{}\nH Field I predictor:0,{}\nH Field I encoding:1,1{}\nH Field P predictor:6,{}\n\
         H Field P encoding:9,{}\nH Field S name:flightModeFlags\nH Field S signed:0\nH Field S predictor:0\n\
         H Field S encoding:1\nH Firmware type:Cleanflight\nH Firmware revision:{revision}\nH I interval:32\n\
         H P interval:1/2\nH gyro_scale:0x3f800000\nH acc_1G:2048\nH motorOutput:158,2047\n{lines}",
        repeated("0", "1"),
        repeated("0", "0"),
        ",0".repeat(14),
        repeated("2", "1"),
        repeated("0", "0"),
    )
    .into_bytes()
}

/// Its frames, 8 P frames after each I frame, a millisecond from each to the next.
fn frames(count: u32) -> Vec<Vec<u8>> {
    frames_at(count, |number| 1_000_000 + 1000 * number)
}

/// The same where the clock shows this in an I frame, us; P frames hold differences to it.
fn frames_at(count: u32, time_us: impl Fn(u32) -> u32) -> Vec<Vec<u8>> {
    let values = |vary: i32| {
        GYRO.iter().chain(&ACCELEROMETER).chain(&ATTITUDE).chain(&OUTPUTS).chain(&[1620]).map(move |value| value + vary)
    };
    let frame = |number: u32| {
        if number.is_multiple_of(9) {
            let mut bytes = vec![b'I'];
            bytes.extend([unsigned(32 * (number / 9)), unsigned(time_us(number))].concat());
            bytes.extend(values(0).flat_map(signed));
            bytes
        } else {
            // the time on the straight line but for the first after an I frame
            let late = if number % 9 == 1 { 1000 } else { 0 };
            let mut bytes = [vec![b'P'], signed(late)].concat();
            bytes.extend(values(0).flat_map(|_| signed(0)));
            bytes
        }
    };
    (0..count).map(frame).collect()
}

pub fn file(revision: &str, lines: &str) -> Vec<u8> {
    [head(revision, lines), frames(450).concat()].concat()
}

fn read(bytes: Vec<u8>) -> Result<Log, String> {
    parse_bytes(Path::new("x.bbl"), bytes, None).map_err(|error| error.to_string())
}

#[test]
fn frames_are_read_in_our_signs_motors_and_units_whatever_the_firmware() {
    for revision in [
        "Betaflight 4.4.2 (abc) STM32F405",
        "Betaflight 2025.12.1 (abc)",
        "INAV 7.1.0 (abc)",
        "Cleanflight 2.3.2 (abc)",
    ] {
        let log = read(file(revision, "")).unwrap();
        assert_eq!(log.rows(), 450, "{revision}");
        let at = |quantity| log.column(quantity).map(|column| column[11]);
        let near = |found: Option<f64>, expected: f64| {
            assert!((found.unwrap() - expected).abs() < 1e-9, "{revision}: {found:?} {expected}");
        };
        // nose down and nose left count positive in the file
        for (axis, degrees) in Axis::ALL.into_iter().zip([100.0, 50.0, -25.0]) {
            near(at(Quantity::Rate(axis)).map(f64::to_degrees), degrees);
        }
        for (axis, degrees) in Axis::ALL.into_iter().zip([10.0, -20.0, -90.0]) {
            near(at(Quantity::Angle(axis)).map(f64::to_degrees), degrees);
        }
        near(at(Quantity::Accel(Axis::Yaw)), -9.80665);
        near(at(Quantity::Accel(Axis::Pitch)), -9.80665 * 205.0 / 2048.0);
        // rear right, front right, rear left, front left: ours are 2, 3, 4, 1; DShot from 48 to 2047
        for (motor, output) in [848.0, 1048.0, 1248.0, 648.0].into_iter().enumerate() {
            near(at(Quantity::Motor(motor)), (output - 48.0) / 1999.0);
        }
        // older firmware's voltage is its board's affair
        assert_eq!(at(Quantity::Battery).is_some(), !revision.starts_with("Cleanflight"), "{revision}");
        assert!((log.time_s[11] - 1.011).abs() < 1e-9);
        let name = log.flight_controller.as_deref().unwrap();
        assert!(revision.starts_with(name), "{name}");
    }
}

/// INAV predicts fields of its slow frames by the frame before, which nothing here is read of.
#[test]
fn slow_frames_may_be_predicted_by_the_one_before() {
    let text = String::from_utf8_lossy(&file("INAV 8.0.0 (abc)", "")).into_owned();
    assert!(text.contains("H Field S predictor:0\n"));
    let replaced = |by: &str| {
        let whole = file("INAV 8.0.0 (abc)", "");
        let (from, to) = (&b"H Field S predictor:0"[..], format!("H Field S predictor:{by}").into_bytes());
        let at = whole.windows(from.len()).position(|window| window == from).unwrap();
        read([&whole[..at], &to, &whole[at + from.len()..]].concat())
    };
    assert_eq!(replaced("1").unwrap().rows(), 450);
    assert!(replaced("3").unwrap_err().contains("Field S predictor"));
}

#[test]
fn frames_behind_a_damaged_one_are_left_out_up_to_the_next_whole_one() {
    let mut frames = frames(450);
    // a frame in the middle of a group is lost: what follows it can't be known
    frames[94].clear();
    let log = read([head("Betaflight 4.4.2 (abc)", ""), frames.concat()].concat()).unwrap();
    assert_eq!(log.rows(), 450 - 8);
    assert!(log.notes.iter().any(|note| note.starts_with("7 frames left out")), "{:?}", log.notes);
    let gap = (1.0 + 0.091)..(1.0 + 0.0989);
    assert!(log.time_s.iter().all(|time_s| !gap.contains(time_s)));
}

/// A simulated controller's clock may be set back, as that of INAV's simulation is: the frames before and after are as
/// good as ever, but nobody knows how long it took in between.
#[test]
fn a_clock_that_is_set_back_begins_a_new_stretch_after_a_gap() {
    let set_back = frames_at(450, |number| 1_000_000 + 1000 * number - if number < 225 { 0 } else { 150_000 });
    let log = read([head("INAV 8.0.0 (abc)", ""), set_back.concat()].concat()).unwrap();
    assert_eq!(log.rows(), 450);
    let steps: Vec<f64> = log.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    for (row, step_s) in steps.iter().enumerate() {
        if row == 224 {
            assert!(*step_s > log.longest_uncut_step_s(), "{step_s}");
        } else {
            assert!((step_s - 1e-3).abs() < 1e-9, "{row}: {step_s}");
        }
    }
    let said = |note: &&String| note.contains("clock was set back") && note.contains("0.149 s");
    assert!(log.notes.iter().any(|note| said(&note)), "{:?}", log.notes);
}

/// The counter of microseconds has 32 bits and begins again after 71 minutes.
#[test]
fn a_clock_that_begins_again_goes_on() {
    let late = frames_at(450, |number| (u32::MAX - 200_000).wrapping_add(1000 * number));
    let log = read([head("Betaflight 4.4.2 (abc)", ""), late.concat()].concat()).unwrap();
    assert_eq!(log.rows(), 450);
    assert!(log.time_s.windows(2).all(|pair| (pair[1] - pair[0] - 1e-3).abs() < 1e-6));
    assert!(!log.notes.iter().any(|note| note.contains("set back")), "{:?}", log.notes);
}

#[test]
fn the_longest_log_of_a_file_is_taken_and_that_is_said() {
    let [short, long] =
        [[head("Betaflight 4.4.2 (abc)", ""), frames(90).concat()].concat(), file("Betaflight 4.4.2 (abc)", "")];
    let log = read([short, long].concat()).unwrap();
    assert_eq!(log.rows(), 450);
    assert!(
        log.notes.iter().any(|note| note == "the file holds 2 logs; this is number 2, the longest"),
        "{:?}",
        log.notes
    );
}

#[test]
fn what_is_no_quadrotors_or_no_log_is_refused() {
    let hexacopter = String::from_utf8_lossy(&head("Betaflight 4.4.2 (abc)", "")).replace("vbatLatest", "motor[4]");
    let message = read([hexacopter.into_bytes(), frames(450).concat()].concat()).unwrap_err();
    assert!(message.contains("no quadrotor: its log has a motor[4]"), "{message}");
    let message = read(b"anything".to_vec()).unwrap_err();
    assert!(message.contains("it holds no first line of a log"), "{message}");
    let mixed =
        String::from_utf8_lossy(&file("Betaflight 4.4.2 (abc)", "")[..1200]).replace("S predictor:0", "S predictor:5");
    assert!(read(mixed.into_bytes()).unwrap_err().contains("Field S predictor"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_file_with_any_bytes_damaged_or_cut_off_is_read_or_refused(
        damages in proptest::collection::vec((0_usize..2000, any::<u8>()), 0..8),
        end in any::<prop::sample::Index>(),
    ) {
        let mut bytes = file("Betaflight 4.4.2 (abc)", "");
        for (at, byte) in damages {
            bytes[at] = byte;
        }
        bytes.truncate(end.index(bytes.len() + 1));
        if let Ok(log) = parse_bytes(Path::new("x.bbl"), bytes, None) {
            prop_assert!(log.rows() >= 100 && log.time_s.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
