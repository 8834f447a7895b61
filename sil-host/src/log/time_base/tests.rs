//! A known motion, sampled at several rates, comes back as rows that lie on it.

use super::super::recording::{Stream, StreamColumn};
use super::*;

/// Roll and pitch, rad, and body rates, rad/s.
fn motion(time_s: f64) -> ([f64; 2], [f64; 3]) {
    let (roll, roll_rate) = (0.3 * (4.0 * time_s).sin(), 1.2 * (4.0 * time_s).cos());
    let (pitch, pitch_rate) = (0.2 * (3.0 * time_s).cos(), -0.6 * (3.0 * time_s).sin());
    // yaw stands still: q and r share the pitch rate
    ([roll, pitch], [roll_rate, pitch_rate * roll.cos(), -pitch_rate * roll.sin()])
}

fn stream(name: &str, time_s: &[f64], quantities: &[(Quantity, &dyn Fn(f64) -> f64)]) -> Stream {
    let column = |(quantity, of): &(Quantity, &dyn Fn(f64) -> f64)| StreamColumn {
        quantity: *quantity,
        source: format!("{name}.{}", quantity.name()),
        value: time_s.iter().map(|time_s| of(*time_s)).collect(),
    };
    Stream { name: name.to_owned(), time_s: time_s.to_vec(), columns: quantities.iter().map(column).collect() }
}

fn times(from_s: f64, to_s: f64, rate_hz: f64) -> Vec<f64> {
    (0..=((to_s - from_s) * rate_hz).round() as usize).map(|i| from_s + i as f64 / rate_hz).collect()
}

fn gyro(time_s: &[f64]) -> Stream {
    let rate = |axis: usize| move |time_s: f64| motion(time_s).1[axis];
    let [p, q, r] = [rate(0), rate(1), rate(2)];
    let quantities: [(Quantity, &dyn Fn(f64) -> f64); 3] =
        [(Quantity::Rate(Axis::Roll), &p), (Quantity::Rate(Axis::Pitch), &q), (Quantity::Rate(Axis::Yaw), &r)];
    stream("gyro", time_s, &quantities)
}

fn attitude(time_s: &[f64]) -> Stream {
    let quantities: [(Quantity, &dyn Fn(f64) -> f64); 2] = [
        (Quantity::Angle(Axis::Roll), &|time_s| motion(time_s).0[0]),
        (Quantity::Angle(Axis::Pitch), &|time_s| motion(time_s).0[1]),
    ];
    stream("attitude", time_s, &quantities)
}

/// Each motor's command says when it was sent and to whom.
fn motors(time_s: &[f64]) -> Stream {
    let command = |motor: usize| move |time_s: f64| 0.005 * time_s + 0.1 * motor as f64 + 0.1;
    let of = [command(0), command(1), command(2), command(3)];
    let quantities: Vec<(Quantity, &dyn Fn(f64) -> f64)> =
        of.iter().enumerate().map(|(motor, of)| (Quantity::Motor(motor), of as &dyn Fn(f64) -> f64)).collect();
    stream("motors", time_s, &quantities)
}

fn recording(streams: Vec<Stream>) -> Recording {
    Recording { flight_controller: "test".to_owned(), streams, ..Recording::default() }
}

/// Gyro at 100, attitude at 10, motors at 37 readings per second, none at the times of another.
fn several_rates() -> Recording {
    let [gyro_s, attitude_s, motors_s] =
        [times(1.0, 9.0, 100.0), times(0.507, 9.507, 10.0), times(0.2113, 10.2113, 37.0)];
    recording(vec![attitude(&attitude_s), motors(&motors_s), gyro(&gyro_s)])
}

#[test]
fn rows_are_the_gyros_and_hold_what_had_been_sent_by_then() {
    let recording = several_rates();
    let log = log_of("log", recording.clone(), None).unwrap();
    assert_eq!(log.time_s, recording.streams[2].time_s);
    let sent = log.sent_commands.as_ref().unwrap();
    let stamps = &recording.streams[1].time_s;
    for row in 0..log.rows() {
        let last_s = stamps.iter().rev().find(|stamp| **stamp <= log.time_s[row]).unwrap();
        for motor in 0..4 {
            let expected = 0.005 * last_s + 0.1 * motor as f64 + 0.1;
            assert_eq!(log.motors().unwrap()[motor][row], expected);
        }
    }
    // the first is in force at the first row; all later ones act at their own times
    assert!(sent.time_s[0] <= log.time_s[0] && sent.time_s[1] > log.time_s[0]);
    let after = stamps.iter().filter(|stamp| **stamp > log.time_s[0] && **stamp <= 9.0).count();
    assert_eq!(sent.rows(), after + 1);
    assert_eq!(log.commands(), &**sent);
    // and a part of the log begins with the one in force there
    let part = log.between(4.0, 6.0).unwrap();
    let of_part = &part.sent_commands.as_ref().unwrap().time_s;
    assert!(of_part[0] <= part.time_s[0] && of_part[1] > part.time_s[0]);
}

#[test]
fn commands_that_come_seldom_are_said_to() {
    let said = |rate_hz: f64| {
        let mut recording = several_rates();
        recording.streams[1] = motors(&times(0.2113, 10.2113, rate_hz));
        log_of("log", recording, None)
            .unwrap()
            .notes
            .iter()
            .any(|note| note.starts_with("commands were logged 10 times"))
    };
    assert!(said(10.0) && !said(37.0));
}

#[test]
fn a_slow_attitude_is_bent_between_its_readings_and_comes_round() {
    let mut recording = several_rates();
    // a yaw that goes round and round
    let yaw = |time_s: f64| crate::statistics::wrapped(2.0 * time_s);
    let column = recording.streams[0].time_s.iter().map(|time_s| yaw(*time_s)).collect();
    recording.streams[0].add(Quantity::Angle(Axis::Yaw), "yaw", column);
    let log = log_of("log", recording, None).unwrap();
    let error = |axis: usize, of: &dyn Fn(f64) -> f64| {
        let column = log.angle_rad[axis].as_ref().unwrap();
        // the first and the last step have a neighbour on one side only
        let rows = log.time_s.iter().zip(column).filter(|(time_s, _)| (1.1..8.9).contains(*time_s));
        rows.map(|(time_s, angle)| crate::statistics::wrapped(angle - of(*time_s)).abs()).fold(0.0, f64::max)
    };
    // slopes across two steps of 0.1 s are off by 0.3 * 4^3 * 0.1^2 / 6 = 0.032 rad/s at most, alike at both ends of a
    // step; of that s (1 - s) (1 - 2 s) <= 0.096 over 0.1 s is 3.1e-4 rad; with Hermite's own error, 0.3 * 4^4 * 0.1^4
    // / 384 = 2e-5, below 3.5e-4. A straight line would be off by 0.3 * 4^2 * 0.1^2 / 8 = 6e-3 rad
    for axis in 0..2 {
        let error = error(axis, &|time_s| motion(time_s).0[axis]);
        assert!(error < 3.5e-4, "{error}");
    }
    assert!(error(2, &yaw) < 1e-9);
}

#[test]
fn commands_at_the_rows_times_need_no_times_of_their_own() {
    let time_s = times(0.0, 5.0, 50.0);
    let log = log_of("log", recording(vec![gyro(&time_s), motors(&time_s)]), None).unwrap();
    assert_eq!((log.sent_commands.as_ref(), log.rows()), (None, time_s.len()));
    assert_eq!(log.commands(), &log);
}

#[test]
fn where_a_needed_stream_has_a_gap_there_are_no_rows() {
    let mut recording = several_rates();
    let (attitude, motors) = (&mut recording.streams[0], 1);
    let kept: Vec<f64> = attitude.time_s.iter().copied().filter(|s| !(3.0..4.0).contains(s)).collect();
    recording.streams[0] = self::attitude(&kept);
    let kept: Vec<f64> = recording.streams[motors].time_s.iter().copied().filter(|s| !(6.0..7.0).contains(s)).collect();
    recording.streams[motors] = self::motors(&kept);
    let log = log_of("log", recording, None).unwrap();
    // the attitude's gap from its last reading to its next; the motors' from five steps after their last command on
    assert!(log.time_s.iter().all(|s| !(2.92..4.0).contains(s) && !(6.0 + 5.0 / 37.0..7.0).contains(s)));
    assert!(log.time_s.iter().any(|s| (6.02..6.1).contains(s)));
    assert!(log.notes.iter().any(|note| note.contains("at which another stream has a gap")), "{:?}", log.notes);
}

#[test]
fn a_quantity_that_covers_little_is_left_out_and_one_that_covers_most_cuts_the_rows() {
    let height = |from_s: f64| stream("height", &times(from_s, 9.0, 20.0), &[(Quantity::Height, &|time_s| time_s)]);
    for (from_s, is_there) in [(1.5, true), (5.0, false)] {
        let mut recording = several_rates();
        recording.streams.push(height(from_s));
        let log = log_of("log", recording, None).unwrap();
        assert_eq!(log.height_m.is_some(), is_there);
        assert_eq!(log.time_s[0], if is_there { from_s } else { 1.0 });
        assert_eq!(log.notes.iter().any(|note| note.contains("height_m left out")), !is_there);
    }
}

#[test]
fn a_battery_is_known_across_gaps_and_beyond_its_ends() {
    let mut recording = several_rates();
    recording.streams.push(stream("battery", &[2.0, 2.1, 2.2, 7.0], &[(Quantity::Battery, &|time_s| 12.0 - time_s)]));
    let log = log_of("log", recording, None).unwrap();
    let volts = log.battery_v.as_ref().unwrap();
    for (time_s, volts) in log.time_s.iter().zip(volts) {
        assert!((volts - (12.0 - time_s.clamp(2.0, 7.0))).abs() < 1e-12);
    }
    assert_eq!(log.rows(), 801);
}

#[test]
fn single_stamps_out_of_order_cost_one_reading_each_and_a_clock_that_runs_back_is_refused() {
    let good = times(1.0, 9.0, 100.0);
    // a repeated stamp, one far too low, one far too high: the row is gone, no other
    for (at, stamp, gone) in [(300, good[299], good[299]), (300, 0.0, good[300]), (300, 1e6, good[300])] {
        let mut time_s = good.clone();
        time_s[at] = stamp;
        let mut recording = several_rates();
        recording.streams[2] = gyro(&time_s);
        let log = log_of("log", recording, None).unwrap();
        assert_eq!(log.rows(), good.len() - 1, "{stamp}");
        let left: Vec<f64> = good.iter().copied().filter(|s| *s != gone || stamp == gone).collect();
        assert!(log.time_s.iter().all(|s| left.contains(s)));
        assert!(log.notes.iter().any(|note| note.contains("gyro: 1 readings replaced")), "{:?}", log.notes);
    }
    let mut recording = several_rates();
    let again: Vec<f64> = good.iter().chain(&good).copied().collect();
    recording.streams[2] = gyro(&again);
    let message = log_of("log", recording, None).unwrap_err().to_string();
    assert_eq!(
        message,
        "log: `gyro`: its time runs back: reading 801 at 1 s follows 9 s, 801 readings are out of order"
    );
    let stamp = good[0];
    recording = several_rates();
    recording.streams[2] = gyro(&vec![stamp; good.len()]);
    let message = log_of("log", recording, None).unwrap_err().to_string();
    assert!(message.contains(&format!("its time stands still: reading 1 at {stamp} s follows {stamp} s")), "{message}");
}

/// Flight controllers write a message twice where two of their loops log it: that is no accident, however often.
#[test]
fn readings_that_were_written_twice_count_once() {
    let good = times(1.0, 9.0, 100.0);
    let twice: Vec<f64> =
        good.iter().enumerate().flat_map(|(row, s)| vec![*s; 1 + usize::from(row % 4 == 0)]).collect();
    let read = |time_s: &[f64]| {
        let mut recording = several_rates();
        recording.streams[2] = gyro(time_s);
        log_of("log", recording, None).unwrap()
    };
    let (once, log) = (read(&good), read(&twice));
    assert_eq!((log.time_s, log.rate_rad_s), (once.time_s, once.rate_rad_s));
    assert!(log.notes.iter().any(|note| note.contains("gyro: 201 readings")), "{:?}", log.notes);
}

#[test]
fn a_wild_reading_is_none_and_a_wrong_unit_is_an_error() {
    let mut recording = several_rates();
    recording.streams[2].columns[0].value[400] = 1e9;
    let log = log_of("log", recording.clone(), None).unwrap();
    let p = log.rate_rad_s[0].as_ref().unwrap();
    // the row is the gyro's; p lies between its neighbours
    assert!((p[400] - motion(log.time_s[400]).1[0]).abs() < 1e-3);
    let degrees = |stream: &mut Stream| stream.columns[1].value.iter_mut().for_each(|value| *value *= 1e4);
    degrees(&mut recording.streams[2]);
    let message = log_of("log", recording, None).unwrap_err().to_string();
    assert!(
        message.contains("`gyro.q_rad_s`: ") && message.contains("lie outside of -100..100 as q_rad_s"),
        "{message}"
    );
}

/// Axis commands and their collective, zero before it lifts off at 4 s; yaw's is what is given.
fn commanded(yaw: &dyn Fn(f64) -> f64) -> Stream {
    let turn = |time_s: f64| 0.1 * (7.0 * time_s).sin();
    let lift = |time_s: f64| if time_s < 4.0 { 0.0 } else { 0.5 };
    let quantities: [(Quantity, &dyn Fn(f64) -> f64); 4] = [
        (Quantity::Command(Axis::Roll), &turn),
        (Quantity::Command(Axis::Pitch), &turn),
        (Quantity::Command(Axis::Yaw), yaw),
        (Quantity::Thrust, &lift),
    ];
    stream("commands", &times(0.5, 9.5, 50.0), &quantities)
}

/// PX4 up to 1.12 wrote yaw commands of 2.77 before it was armed; in flight no mixer takes such.
#[test]
fn commands_out_of_range_before_the_flight_refuse_nothing_and_in_flight_all() {
    let read = |yaw: &dyn Fn(f64) -> f64| {
        let gyro_s = times(1.0, 9.0, 100.0);
        log_of("log", recording(vec![attitude(&gyro_s), commanded(yaw), gyro(&gyro_s)]), None)
    };
    let log = read(&|time_s| if time_s < 3.0 { 2.77 } else { 0.3 }).unwrap();
    let yaw = log.axis_command[2].as_ref().unwrap();
    assert_eq!((yaw[0], yaw[log.rows() - 1]), (1.0, 0.3));
    assert_eq!(log.rows(), 801);
    let said = |note: &String| note.starts_with("commands.yaw_cmd: 125 of 451 readings are outside of -1.05..1.05");
    assert!(log.notes.iter().any(said), "{:?}", log.notes);
    let message = read(&|time_s| if (3.0..=6.0).contains(&time_s) { 0.3 } else { 2.77 }).unwrap_err().to_string();
    assert!(message.contains("`commands.yaw_cmd`: ") && message.contains("of -1.05..1.05 as yaw_cmd"), "{message}");
    assert!(message.contains("the first 2.77 at 6.02 s"), "{message}");
}

#[test]
fn what_is_missing_is_named_with_what_is_there() {
    let time_s = times(0.0, 5.0, 50.0);
    let message = |streams| log_of("log", recording(streams), None).unwrap_err().to_string();
    let no_motors = message(vec![gyro(&time_s)]);
    assert!(no_motors.contains("holds no outputs of four motors, or axis commands; it holds: p_rad_s"), "{no_motors}");
    assert!(message(vec![motors(&time_s)]).contains("holds no body rates or angles; it holds: motor1"));
    let apart = message(vec![gyro(&time_s), motors(&times(100.0, 110.0, 50.0))]);
    assert!(apart.contains("found 0; it holds gyro 50 from 0.00 s to 5.00 s, motors 50 from 100.00 s"), "{apart}");
}
