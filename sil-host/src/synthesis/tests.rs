use super::*;
use crate::model::Rig;
use shared_control::config::Controller;

fn setup(log_rate_hz: u32, control_rate_hz: u32) -> Synthesis {
    let choice = ControllerChoice { rate_hz: control_rate_hz, ..ControllerChoice::nominal(Controller::Cascade) };
    let nominal = Synthesis::of(VehicleModel::nominal(Rig::Gimbal));
    Synthesis { choice, duration_s: 4.0, log_rate_hz, seed: 7, ..nominal }
}

#[test]
fn rows_come_at_the_logs_rate_and_hold_the_command_in_force() {
    for (log_rate, control_rate) in [(400, 400), (100, 400), (150, 400), (100, 100)] {
        let log = setup(log_rate, control_rate).log().unwrap();
        assert_eq!(log.rows(), 4 * log_rate as usize, "{log_rate} of {control_rate}");
        assert!(log.time_s.windows(2).all(|t| t[1] > t[0]));
        assert!(log.comments[0].starts_with("SYNTHETIC"));
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let bytes = |seed| {
        let mut out = Vec::new();
        let noisy = Synthesis { seed, jitter_s: 1e-3, drop_out_share: 0.05, ..setup(200, 400) };
        crate::log::write(&noisy.log().unwrap(), &mut out).unwrap();
        out
    };
    assert!(bytes(1) == bytes(1));
    assert!(bytes(1) != bytes(2));
}

#[test]
fn a_long_log_repeats_the_sequence() {
    let long = repeated(&Scenario::test_sequence(), 60.0);
    assert_eq!(long.duration_s, 60.0);
    assert!((long.at(29.75 + 2.0).roll_rad - long.at(2.0).roll_rad).abs() < 1e-12);
    assert!(long.at(2.0).roll_rad > 0.5);
}

/// A flight without sensor noise, with effects.
fn quiet(effects: &[&str]) -> Synthesis {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    model.effects = effects.iter().map(|short| Effect::parse(short, Rig::Gimbal).unwrap()).collect();
    let noise = SensorNoise::NONE;
    Synthesis { noise: Some(noise), ..Synthesis { model, ..setup(400, 400) } }
}

fn column(column: &crate::log::Column) -> &[f64] {
    column.as_deref().unwrap()
}

/// The delay changes nothing in the loop, so that a delay of whole rows gives the very angles of earlier rows.
#[test]
fn reported_attitude_lags_by_the_delay_and_the_gyro_does_not() {
    let prompt = quiet(&[]).log().unwrap();
    let late = quiet(&["attitude_delay:delay_s=0.0125"]).log().unwrap();
    assert_eq!(prompt.rate_rad_s, late.rate_rad_s);
    assert_eq!(prompt.motor_command, late.motor_command);
    for axis in 0..2 {
        let (prompt, late) = (column(&prompt.angle_rad[axis]), column(&late.angle_rad[axis]));
        assert!(prompt.iter().any(|angle| angle.abs() > 0.3) || axis == 1);
        for row in 5..prompt.len() {
            // rounded to 1e-6 on both sides; looks cut the integrator's steps elsewhere
            assert!((late[row] - prompt[row - 5]).abs() < 1.5e-6, "{row}: {} {}", late[row], prompt[row - 5]);
        }
        assert_eq!(late[..5], [prompt[0]; 5]);
    }
}

/// A delay between rows, and rows between control steps: what is logged is what a fine log shows there.
#[test]
fn late_rows_hold_the_state_at_their_own_time() {
    let fine = Synthesis { choice: ControllerChoice { rate_hz: 400, ..setup(400, 400).choice }, ..quiet(&[]) };
    let reference = fine.log().unwrap();
    let delay_s = 0.0037;
    let late =
        Synthesis { log_rate_hz: 100, jitter_s: 2e-3, ..quiet(&["attitude_delay:delay_s=0.0037"]) }.log().unwrap();
    assert_eq!(late.rows(), 400);
    assert!(late.time_s.windows(2).all(|pair| pair[1] > pair[0]));
    let lateness: Vec<f64> = late.time_s.iter().enumerate().map(|(row, time_s)| time_s - row as f64 * 0.01).collect();
    assert!(lateness.iter().all(|late_s| (-1e-9..0.009 + 1e-6).contains(late_s)));
    // the mean of |N(0, s)| is s sqrt(2 / pi); its standard error 0.6 s / 20
    let mean_s = lateness.iter().sum::<f64>() / 400.0;
    assert!((mean_s - 2e-3 * 0.797_885).abs() < 5.0 * 0.03 * 2e-3, "{mean_s}");
    for row in 1..late.rows() {
        let time_s = late.time_s[row];
        let at = |series: &[f64], rates: &[f64], time_s: f64| {
            // from the row before on with its rate and acceleration; roll alone moves in the first seconds
            let before = ((time_s + 1e-9) * 400.0).floor() as usize;
            let since_s = time_s - before as f64 / 400.0;
            let acceleration = (rates[(before + 1).min(rates.len() - 1)] - rates[before]) * 400.0;
            series[before] + since_s * (rates[before] + 0.5 * since_s * acceleration)
        };
        let roll = at(column(&reference.angle_rad[0]), column(&reference.rate_rad_s[0]), (time_s - delay_s).max(0.0));
        // the gyro counts in 1.06e-3 rad/s, over 2.5 ms: 3e-6 rad; jerk over 2.5 ms: up to 4e-6
        assert!((column(&late.angle_rad[0])[row] - roll).abs() < 1.5e-5, "{time_s}: {roll}");
        // the command in force is that of the control step before
        let step = ((time_s + 1e-9) * 400.0).floor() as usize;
        assert_eq!(column(&late.motor_command[2])[row], column(&reference.motor_command[2])[step]);
    }
}

#[test]
fn rows_drop_out_by_chance() {
    let full = setup(200, 400).log().unwrap();
    let holed = Synthesis { drop_out_share: 0.1, ..setup(200, 400) }.log().unwrap();
    // 800 rows: 720 remain, five standard deviations of the binomial distribution are 42
    assert!((678..762).contains(&holed.rows()), "{}", holed.rows());
    // those that remain are the same rows
    let mut rows = full.time_s.iter().zip(column(&full.angle_rad[0]));
    for (time_s, angle) in holed.time_s.iter().zip(column(&holed.angle_rad[0])) {
        assert!(rows.any(|row| row == (time_s, angle)), "{time_s}");
    }
}

#[test]
fn the_battery_is_logged_where_thrust_follows_it_or_on_request() {
    assert!(setup(200, 400).log().unwrap().battery_v.is_none());
    let steady = Synthesis { battery: true, ..setup(200, 400) }.log().unwrap();
    assert_eq!(steady.battery_v, Some(vec![12.0; 800]));
    let falling = quiet(&["battery_sag:per_volt=0.1,fall_v_s=0.05"]).log().unwrap();
    let voltage = column(&falling.battery_v);
    assert!((voltage[0] - 12.0).abs() < 1e-9 && (voltage[1599] - (12.0 - 0.05 * 1599.0 / 400.0)).abs() < 1e-6);
}

/// What a diagnosis must not read off the comments.
#[test]
fn a_blind_log_says_only_that_it_is_synthetic() {
    let effects = ["spring:axis=roll,stiffness_nm_rad=0.1", "weak_motor:motor=2,scale=0.95"];
    let open = quiet(&effects).log().unwrap();
    let comments = open.comments.join("\n");
    assert!(
        comments.contains("spring:axis=roll,stiffness_nm_rad=0.1,rest_rad=0; weak_motor:motor=2,scale=0.95"),
        "{comments}"
    );
    let blind = Synthesis { blind: true, ..quiet(&effects) }.log().unwrap();
    assert_eq!(blind.comments, ["SYNTHETIC: made by a simulation (sil synth), measured nowhere"]);
    assert_eq!(blind.angle_rad, open.angle_rad);
}

/// Each effect, as its example has it, in a whole flight on its rig: the log differs from the nominal one, is finite,
/// and the vehicle stays in the air.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn every_effect_shows_in_a_flight() {
    let fly = |rig, duration_s, effects: Vec<Effect>| {
        let model = VehicleModel { effects, ..VehicleModel::nominal(rig) };
        Synthesis { model, duration_s, battery: true, blind: true, ..setup(100, 400) }.log().unwrap()
    };
    for rig in [Rig::Gimbal, Rig::Free] {
        for entry in Effect::CATALOGUE.iter().filter(|entry| entry.rigs[0] == rig) {
            // past the first steps of roll; the step of torque comes at 10 s
            let duration_s = if entry.example.contains("start_s") { 11.0 } else { 3.0 };
            let nominal = fly(rig, duration_s, Vec::new());
            let log = fly(rig, duration_s, vec![Effect::parse(entry.example, rig).unwrap()]);
            assert_eq!(log.rows() as f64, 100.0 * duration_s, "{}", entry.name);
            let columns = log.angle_rad.iter().chain(&log.rate_rad_s).chain(&log.motor_command);
            assert!(columns.flatten().flatten().all(|value| value.is_finite() && value.abs() < 20.0), "{}", entry.name);
            assert!(log != nominal, "{} changes nothing", entry.name);
        }
    }
}

/// What holds a free vehicle before the flight carries it, so that the core finds level and arms whatever the motors
/// lift.
#[test]
fn a_free_vehicle_flies_however_much_its_motors_lift() {
    for effect in ["thrust_scale:scale=0.6", "mass_error:scale=0.7", "mass_error:scale=1.5"] {
        let mut model = VehicleModel::nominal(Rig::Free);
        model.effects = vec![Effect::parse(effect, Rig::Free).unwrap()];
        let log = Synthesis { duration_s: 1.0, ..Synthesis::of(model) }.log().unwrap();
        assert!(log.motor_command.iter().all(|motor| column(motor).iter().all(|command| *command > 0.3)), "{effect}");
    }
}
