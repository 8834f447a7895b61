//! Logs of real vehicles, recorded by other people: they are read whole, and the shipped maps turn their signs right.
//!
//! The logs are not part of the project. They are looked for in `$SIL_DATA`, else in `../shared/data` beside the
//! workspace; where they are absent these tests say that they are skipped.

use campaigns::real_logs::crazypad::{self, Change, MOTOR_3, MOTOR_4};
use campaigns::real_logs::{TORQUE_SIGNS, files, load};
use sil_host::axis::Axis;
use sil_host::diagnosis::{Subject, nominal_prediction};
use sil_host::log::{Log, Quantity};
use sil_host::prediction::Channel;

/// Correlation of an input with the angular acceleration of an axis some rows later, in active rows.
fn correlation(log: &Log, axis: Axis, input: &[f64], delay_rows: usize, span_rows: usize) -> f64 {
    let rate = log.column(Quantity::Rate(axis)).unwrap();
    let active = log.active_rows();
    let rows = delay_rows.max(span_rows)..log.rows() - span_rows;
    let pairs: Vec<(f64, f64)> = rows
        .filter(|row| active[row - delay_rows] && active[*row])
        .map(|row| {
            let (before, after) = (row - span_rows, row + span_rows);
            let step_s = log.time_s[after] - log.time_s[before];
            (input[row - delay_rows], (rate[after] - rate[before]) / step_s)
        })
        .collect();
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let (mean_x, mean_y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 { pairs.iter().map(|(x, y)| of(x - mean_x, y - mean_y)).sum() };
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

/// The torque about an axis that docs/rig.md's mixer signs give, in commands.
fn torque_command(log: &Log, axis: Axis) -> Vec<f64> {
    let motors = log.motors().unwrap();
    let torque = |row: usize| (0..4).map(|m| TORQUE_SIGNS[axis.index()][m] * motors[m][row]).sum();
    (0..log.rows()).map(torque).collect()
}

#[test]
fn bench_with_free_pitch() {
    for path in files("rig_antx_2dof", "Lab") {
        let log = load(&path, "antx");
        assert_eq!(log.axes, [false, true, false]);
        assert!(log.rows() > 4000 && (0.0039..0.0041).contains(&log.median_step_s()));
        let active = log.active_rows().iter().filter(|active| **active).count() as f64;
        // "60 to 80 % of a log"
        assert!((0.55..0.85).contains(&(active / log.rows() as f64)), "{active}");
        let command = log.axis_command[1].clone().unwrap();
        let sign = correlation(&log, Axis::Pitch, &command, 5, 2);
        println!("{}: pitch_cmd to q' {sign:+.2}", path.display());
        assert!(sign > 0.4, "{}: {sign}", path.display());
        let (pitch, q) = (log.angle_rad[1].clone().unwrap(), log.rate_rad_s[1].clone().unwrap());
        let integral: f64 = (1..log.rows()).map(|row| (pitch[row] - pitch[row - 1]) * q[row]).sum();
        assert!(integral > 0.0, "pitch and q must have one sign");
    }
}

#[test]
fn stand_with_three_free_axes() {
    let maps = [("cl_3dof_LQIDG_mimo", "sharif"), ("cl_rollpitch", "sharif_roll_pitch"), ("cl_pitch", "sharif_pitch")];
    for (start, map) in maps {
        for path in files("rig_sharif_3dof", start) {
            let whole = load(&path, map);
            assert!((0.0199..0.0201).contains(&whole.median_step_s()));
            // off the end stops
            let from_s = if map == "sharif" { 15.0 } else { 5.4 };
            let log = whole.between(from_s, f64::INFINITY).unwrap();
            for axis in [Axis::Roll, Axis::Pitch].into_iter().filter(|axis| log.axes[axis.index()]) {
                let command = log.axis_command[axis.index()].clone().unwrap();
                let sign = correlation(&log, axis, &command, 7, 2);
                println!("{}: {} command to acceleration {sign:+.2}", path.display(), axis.name());
                assert!(sign > 0.4, "{}: {sign}", path.display());
                let angle = log.angle_rad[axis.index()].clone().unwrap();
                let rate = log.rate_rad_s[axis.index()].clone().unwrap();
                let integral: f64 = (1..log.rows()).map(|row| (angle[row] - angle[row - 1]) * rate[row]).sum();
                assert!(integral > 0.0, "{}: angle and rate must have one sign", path.display());
            }
        }
    }
}

#[test]
fn crazyflie_with_gyro_and_motors() {
    let axes_of = [("log15", Axis::Roll, 40), ("log15", Axis::Pitch, 40), ("log16", Axis::Yaw, 0)];
    for (name, axis, delay_rows) in axes_of {
        for path in files("flight_crazyflie_arplab", name) {
            let log = load(&path, "crazyflie_arplab");
            assert!(log.angle_rad.iter().all(Option::is_none));
            let sign = correlation(&log, axis, &torque_command(&log, axis), delay_rows, 5);
            println!("{name}: {} torque to acceleration {sign:+.2}", axis.name());
            assert!(sign > 0.5, "{name} {}: {sign}", axis.name());
        }
    }
}

#[test]
fn crazyflie_with_axis_commands_and_gyro() {
    for path in files("flight_crazypad", "controller_data") {
        let log = load(&path, "crazypad_controller");
        for axis in Axis::ALL {
            let command = log.axis_command[axis.index()].clone().unwrap();
            let sign = correlation(&log, axis, &command, 4, 1);
            println!("{}: {} command to acceleration {sign:+.2}", path.display(), axis.name());
            // a steady hover hardly excites: only the sign can be checked
            assert!(sign > 0.05, "{}: {}", path.display(), axis.name());
        }
    }
}

#[test]
fn crazyflie_with_motors_and_no_gyro() {
    for path in files("flight_crazypad", "motor_data") {
        let log = load(&path, "crazypad_motor");
        assert_eq!(log.axes, [true, false, true]);
        assert!(log.motors().is_some() && log.rate_rad_s.iter().all(Option::is_none));
    }
}

/// The prediction of the bench misses by far more than noise, as it must: the model knows neither the delay of 20 ms
/// nor the restoring moment nor the trim of the bench (the authors' model has the first two). What it is, is the
/// diagnosis' matter; that it shows, and that the one gain does what one gain can, is tested here.
#[test]
fn bench_with_free_pitch_is_predicted_and_missed() {
    for path in files("rig_antx_2dof", "Lab") {
        let log = load(&path, "antx");
        let prediction = nominal_prediction(&log, &Subject::Axes, None).unwrap();
        let (gain, predicted) = (prediction.input_gain_rad_s2[1].unwrap(), prediction.predicted);
        let [errors, _] = predicted.channel_errors();
        let (angle, rate) = (Channel::Angle(Axis::Pitch), Channel::Rate(Axis::Pitch));
        println!("{}", path.file_name().unwrap().to_string_lossy());
        println!("    gain {gain:.1} rad/s^2, {} windows", predicted.windows().count());
        println!("    {errors:?}");
        // the authors identified 405 rad/s^2 with a delay and a restoring moment; without them less fits better, and
        // where the bench mostly swings freely (Lab02) the swing, which the model lacks, decides: a small gain of
        // either sign
        assert!(gain.abs() < 405.0, "{gain}");
        let swings = path.to_string_lossy().contains("Lab02");
        assert!(if swings { gain.abs() < 0.25 * 405.0 } else { gain > 0.0 }, "{gain}");
        for channel in [angle, rate] {
            assert!(predicted.error(channel).unwrap().ratio() > 10.0);
        }
        // a window ends half a second after its start: much more than the 16 degrees of Lab01's second run, which the
        // model's missing trim makes, would be a wrong sign or unit
        assert!(errors.pitch_deg.unwrap() < 20.0);
        // sensors at rest, before the motors run: the gyro's scatter is the same within a factor of three
        let gyro = predicted.noise.std(rate).unwrap();
        assert!((0.0005..0.005).contains(&gyro), "{gyro}");
        for window in predicted.windows() {
            assert!(log.active_rows()[window.lead..window.end].iter().all(|active| *active));
            let longest = (window.lead + 1..window.end).map(|row| log.time_s[row] - log.time_s[row - 1]);
            assert!(longest.fold(0.0, f64::max) <= 0.0201, "a gap inside a window");
        }
    }
}

/// Gyro and motors, no attitude: predicted as three axes driven by the motors' signed sums.
#[test]
fn crazyflie_without_attitude_is_predicted() {
    for path in files("flight_crazyflie_arplab", "log15") {
        let prediction = nominal_prediction(&load(&path, "crazyflie_arplab"), &Subject::Axes, None).unwrap();
        let gains = prediction.input_gain_rad_s2.map(Option::unwrap);
        println!("{}: gains {gains:.1?}, {} windows", path.display(), prediction.predicted.windows().count());
        println!("    {:?}", prediction.predicted.channel_errors()[0]);
        // authors: d(thrust)/du = 0.109 N at u = 0.5; 0.028 m * 0.109 N * 2 / 1.03e-5 kg m^2 = 593 rad/s^2 per unit of
        // the half sum, less what a lag of 40 ms hides
        assert!((50.0..700.0).contains(&gains[0]) && (50.0..700.0).contains(&gains[1]), "{gains:?}");
    }
}

/// Cut propellers of motor 3, from most to least lift.
const CUTS: [&str; 4] = [
    "cut_propeller_M3_1mm_46mm",
    "cut_propeller_M3_2mm_2mm_43mm",
    "cut_propeller_M3_2.5mm_2.5mm_42mm",
    "cut_propeller_M3_3.5mm_3.5mm_40mm",
];

/// A weak motor 3 shows as 2 : -2 : 1 about roll, pitch and yaw, and the more of its propeller is cut, the more.
#[test]
fn crazyflie_with_a_cut_propeller_has_a_weak_motor() {
    let flights = crazypad::flights();
    if flights.is_empty() {
        return;
    }
    for (airframe, cuts) in [("E8", &CUTS[..]), ("E9", &CUTS[..2])] {
        let changes: Vec<Change> = cuts.iter().map(|cut| Change::of(&flights, airframe, cut, None)).collect();
        // the first has one blade cut to 46 mm and cannot be separated from a normal flight
        for (cut, change) in cuts.iter().zip(&changes).skip(1) {
            println!("{airframe} {cut}: {change} {:.2?}", change.weak_motor_shares(MOTOR_3));
            // in every kind of log and on every way: the signs of a weak motor 3, in yaw more than normal flights
            // differ
            for (each, normal) in change.each_pct.iter().zip(&change.normal_pct) {
                assert!(each[0] > 0.0 && each[1] < 0.0 && each[2] > normal[2], "{change:?}");
            }
            // nearer to a weak motor (1) than to a weight (0)
            assert!(change.weak_motor_shares(MOTOR_3).iter().all(|share| *share > 0.5), "{change:?}");
        }
        let pulls_pct: Vec<f64> = changes.iter().map(|change| change.pull_pct(MOTOR_3)).collect();
        assert!(pulls_pct.is_sorted_by(|less, more| less < more), "{pulls_pct:?}");
    }
    // the deepest cut, whose pull is three times what another seat of the propellers does: the ratio itself
    let [roll, pitch, yaw] = Change::of(&flights, "E8", CUTS[3], None).mean_pct;
    assert!((1.5..2.5).contains(&(roll / yaw)) && (-2.5..-1.5).contains(&(pitch / yaw)), "{roll} {pitch} {yaw}");
}

/// The weight under motor 3 hangs in its wash and costs lift: yaw changes with roll and pitch as it does of a weak
/// motor. The same weight under motor 4 of the other airframe pulls harder and changes no yaw.
#[test]
fn crazyflie_with_a_weight_near_motor_3_lifts_less_there() {
    let flights = crazypad::flights();
    if flights.is_empty() {
        return;
    }
    let near_3 = Change::of(&flights, "E9", "add_weight_W1_near_M3", None);
    println!("near motor 3: {near_3} {:.2?}", near_3.weak_motor_shares(MOTOR_3));
    for (each, normal) in near_3.each_pct.iter().zip(&near_3.normal_pct) {
        assert!(each.iter().zip(normal).all(|(each, normal)| each.abs() > *normal), "{near_3:?}");
    }
    assert!(near_3.weak_motor_shares(MOTOR_3).iter().all(|share| *share > 0.5), "{near_3:?}");
    let of_cut = |cut: &str| Change::of(&flights, "E9", cut, None).pull_pct(MOTOR_3);
    assert!((of_cut(CUTS[0])..of_cut(CUTS[1])).contains(&near_3.pull_pct(MOTOR_3)));

    // controller logs alone: motor logs of this label fly as normal ones do, so that they may have been without the
    // weight
    let near_4 = Change::of(&flights, "E8", "add_weight_W1_near_M4", Some("controller"));
    println!("near motor 4: {near_4} {:.2?}", near_4.weak_motor_shares(MOTOR_4));
    for (each, normal) in near_4.each_pct.iter().zip(&near_4.normal_pct) {
        assert!(each[0] > normal[0] && each[1] > normal[1] && each[2].abs() < normal[2], "{near_4:?}");
    }
    assert!(near_4.weak_motor_shares(MOTOR_4).iter().all(|share| share.abs() < 0.5), "{near_4:?}");
    assert!(near_4.pull_pct(MOTOR_4) > near_3.pull_pct(MOTOR_3));
}
