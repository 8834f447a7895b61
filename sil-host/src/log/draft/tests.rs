//! Drafts of small tables in the names of many loggers.

use std::path::Path;

use super::super::Log;
use super::super::quantity::GRAVITY_M_S2;
use super::*;
use crate::vehicle::quaternion_world_from_body;

/// A table of these columns, 150 rows at 100 per second; what each row says is given by its number and its time, s. So
/// short a log tells nothing of signs.
fn table(header: &str, row: impl Fn(u32, f64) -> String) -> String {
    let line = |number: u32| row(number, 0.01 * f64::from(number)) + "\n";
    format!("{header}\n") + &(0..150).map(line).collect::<String>()
}

/// A number that no row repeats.
fn wave(time_s: f64, height: f64) -> f64 {
    height * (5.0 * time_s + height).sin()
}

fn drafted(text: &str) -> Draft {
    draft_from(Path::new("flight.csv"), &mut text.as_bytes()).unwrap().unwrap()
}

/// The draft and the log as read by it; there must be no problem left.
fn read(text: &str) -> (String, Log) {
    let Draft { toml, problems } = drafted(text);
    assert!(problems.is_empty(), "{problems:?}\n{toml}");
    let map = Map::parse("draft", &toml).unwrap();
    (toml, csv::parse("flight.csv", text, Some(&map)).unwrap())
}

fn rates(time_s: f64) -> String {
    format!("{},{},{}", wave(time_s, 0.5), wave(time_s, 0.4), wave(time_s, 0.3))
}

fn pulses(time_s: f64) -> String {
    [1500.0, 1510.0, 1520.0, 1530.0].map(|pulse_us| format!("{:.3}", pulse_us + wave(time_s, 20.0))).join(",")
}

#[test]
fn motors_are_found_under_the_names_of_outputs() {
    for names in [
        "out1,out2,out3,out4",
        "m1pwm,m2pwm,m3pwm,m4pwm",
        "M1,M2,M3,M4",
        "esc0,esc1,esc2,esc3",
        "m0,m1,m2,m3",
        "u0,u1,u2,u3",
    ] {
        let text =
            table(&format!("t,gx,gy,gz,{names}"), |_, time_s| format!("{time_s},{},{}", rates(time_s), pulses(time_s)));
        let (toml, log) = read(&text);
        for (motor, name) in names.split(',').enumerate() {
            let line = format!("motor{} = {{ column = \"{name}\", scale = 1e-3, offset = -1 }}", motor + 1);
            assert!(toml.contains(&line), "{line}\n{toml}");
            let expected = 0.5 + 0.01 * motor as f64 + 1e-3 * wave(0.3, 20.0);
            assert!((log.motors().unwrap()[motor][30] - expected).abs() < 2e-6, "{name}");
        }
        assert!(!toml.contains("_cmd = "), "{toml}");
    }
}

/// Motors by where they stand have this project's numbers: 1 front right, 2 rear left, 3 front left, 4 rear right.
#[test]
fn motors_are_found_by_their_places() {
    for names in [
        "pwm_fl,pwm_fr,pwm_rl,pwm_rr",
        "pwm_fl,pwm_fr,pwm_bl,pwm_br",
        "motor_front_left,motor_front_right,motor_back_left,motor_back_right",
        "escFL,escFR,escRL,escRR",
    ] {
        let text =
            table(&format!("t,gx,gy,gz,{names}"), |_, time_s| format!("{time_s},{},{}", rates(time_s), pulses(time_s)));
        let (toml, log) = read(&text);
        for (place, (name, motor)) in names.split(',').zip([3, 1, 2, 4]).enumerate() {
            assert!(toml.contains(&format!("motor{motor} = {{ column = \"{name}\"")), "{name}\n{toml}");
            let expected = 0.5 + 0.01 * place as f64 + 1e-3 * wave(0.3, 20.0);
            assert!((log.motors().unwrap()[motor - 1][30] - expected).abs() < 2e-6, "{name}");
        }
    }
}

/// Of four motors, and not the throttle of all; a force has no largest that a name tells.
#[test]
fn four_thrusts_are_motors() {
    let thrusts = |of_full: f64| {
        table("t,gx,gy,gz,thrust[0],thrust[1],thrust[2],thrust[3]", move |_, time_s| {
            let each = [0.5, 0.51, 0.52, 0.53].map(|thrust| (of_full * (thrust + wave(time_s, 0.02))).to_string());
            format!("{time_s},{},{}", rates(time_s), each.join(","))
        })
    };
    let (toml, log) = read(&thrusts(1.0));
    assert!((log.motors().unwrap()[3][30] - 0.53 - wave(0.3, 0.02)).abs() < 1e-9, "{toml}");
    let (toml, log) = read(&thrusts(7.0));
    let largest =
        log.motors().unwrap().iter().flat_map(|motor| motor.iter()).fold(0.0, |most: f64, now| most.max(*now));
    assert!((largest - 1.0).abs() < 1e-9 && toml.contains("not known: its unit"), "{toml}");
}

/// Thrust and three torques, as textbooks name them.
#[test]
fn four_inputs_with_signs_are_no_motors() {
    let text = table("t,gx,gy,gz,u1,u2,u3,u4", |_, time_s| {
        format!("{time_s},{},0.5,{},{},{}", rates(time_s), wave(time_s, 0.1), wave(time_s, 0.2), wave(time_s, 0.05))
    });
    let Draft { toml, problems } = drafted(&text);
    assert!(problems.len() == 1 && problems[0].starts_with("commands are missing"), "{problems:?}");
    assert!(toml.contains("# not used: u1, u2, u3, u4\n"), "{toml}");
}

/// One of them is never below 800, as a pulse width, the others are.
#[test]
fn four_motors_have_one_unit() {
    let text = table("t,gx,gy,gz,motor[0],motor[1],motor[2],motor[3]", |number, time_s| {
        let low = if number < 5 { 48.0 } else { 1000.0 };
        let each = [low, 1400.0, low, low].map(|least| (least + wave(time_s, 30.0)).to_string());
        format!("{time_s},{},{}", rates(time_s), each.join(","))
    });
    let (toml, log) = read(&text);
    assert_eq!(toml.matches("DShot").count(), 4, "{toml}");
    assert!((log.motors().unwrap()[1][30] - (1400.0 + wave(0.3, 30.0)) / 2047.0).abs() < 1e-9, "{toml}");
}

/// Speeds are measured and commanded by nobody.
#[test]
fn motors_in_radians_per_second_are_rotor_speeds() {
    let text = table("t,gx,gy,gz,m1_rads,m2_rads,m3_rads,m4_rads", |_, time_s| {
        format!("{time_s},{},1500.5,1510.25,1520,1530", rates(time_s))
    });
    let Draft { toml, problems } = drafted(&text);
    assert!(problems.len() == 1 && problems[0].contains("rotors' speeds, which the log has, are none"), "{problems:?}");
    let line = toml.lines().find(|line| line.starts_with("rpm2 = ")).unwrap();
    assert!(
        line.contains("m2_rads") && line.contains("scale = 9.549") && line.ends_with("rad/s by its name"),
        "{line}"
    );
    let with_commands = text.replace("m1_rads,m2_rads,m3_rads,m4_rads", "out1,out2,out3,m4_rads");
    assert!(drafted(&with_commands).toml.contains("rpm4 = { column = \"m4_rads\""), "{with_commands}");
}

/// NeuroBEM's names; what accelerates an angle is nothing that an accelerometer feels.
#[test]
fn angular_accelerations_are_no_accelerations_and_angular_velocities_are_rates() {
    let text = table("t,ang acc x,ang acc y,ang acc z,ang vel x,ang vel y,ang vel z,acc x,acc y,acc z,m1,m2,m3,m4", {
        |_, time_s| {
            let felt = format!("{},{},{}", wave(time_s, 0.1), wave(time_s, 0.2), -GRAVITY_M_S2 + wave(time_s, 0.3));
            format!("{time_s},1.5,2.5,3.5,{},{felt},{}", rates(time_s), pulses(time_s))
        }
    });
    let (toml, log) = read(&text);
    assert!(toml.contains("# not used: ang acc x, ang acc y, ang acc z\n"), "{toml}");
    assert!((log.column(Quantity::Rate(Axis::Pitch)).unwrap()[30] - wave(0.3, 0.4)).abs() < 1e-9, "{toml}");
    assert!((log.column(Quantity::Accel(Axis::Yaw)).unwrap()[30].abs() - GRAVITY_M_S2).abs() < 0.5, "{toml}");
}

/// Of what the name says, or where it says nothing of what makes a rate of rows that there is.
#[test]
fn the_unit_of_time_is_its_names_or_the_rows() {
    for (name, per_s, key) in [
        ("t", 1.0, "time_s"),
        ("time_ms", 1e3, "time_ms"),
        ("millis", 1e3, "time_ms"),
        ("timestamp_us", 1e6, "time_us"),
        ("elapsed_time", 1.0, "time_s"),
        ("timestamp", 1e3, "time_ms"),
        ("timestamp", 1e6, "time_us"),
    ] {
        let text = table(&format!("{name},gx,gy,gz,m1,m2,m3,m4"), |number, time_s| {
            format!("{:.3},{},{}", 0.01 * per_s * f64::from(number), rates(time_s), pulses(time_s))
        });
        let (toml, log) = read(&text);
        assert!(toml.contains(&format!("\n{key} = {{ column = \"{name}\" }}")), "{name} {per_s}\n{toml}");
        assert!((log.time_s[149] - 1.49).abs() < 1e-9, "{name} {per_s}: {}", log.time_s[149]);
    }
}

/// A motor's own name is surer than an output's.
#[test]
fn outputs_beside_motors_are_not_used() {
    let text = table("t,gx,gy,gz,out1,out2,out3,out4,m1,m2,m3,m4", |_, time_s| {
        format!("{time_s},{},0.1,0.2,0.3,0.4,{}", rates(time_s), pulses(time_s))
    });
    let (toml, _) = read(&text);
    assert!(toml.contains("# not used: out1, out2, out3, out4\n"), "{toml}");
    assert!(toml.contains("motor4 = { column = \"m4\""), "{toml}");
}

#[test]
fn rates_are_found_by_letters_that_are_joined_and_by_numbers_from_one() {
    for names in ["omegax,omegay,omegaz", "omega1,omega2,omega3", "omega_0,omega_1,omega_2", "gyrox,gyroy,gyroz"] {
        let text = table(&format!("t,{names},m1,m2,m3,m4"), |_, time_s| {
            format!("{time_s},{},{}", rates(time_s), pulses(time_s))
        });
        let (toml, log) = read(&text);
        for (axis, height) in Axis::ALL.into_iter().zip([0.5, 0.4, 0.3]) {
            assert!(
                (log.column(Quantity::Rate(axis)).unwrap()[30] - wave(0.3, height)).abs() < 1e-9,
                "{names}\n{toml}"
            );
        }
    }
    let text = table("t,rollrate,pitchrate,roll,pitch,m1,m2,m3,m4", |_, time_s| {
        format!("{time_s},{},0.1,{}", rates(time_s), pulses(time_s))
    });
    let (toml, _) = read(&text);
    assert!(toml.contains("q_rad_s = { column = \"pitchrate\" }"), "{toml}");
}

/// Of four motors, in rad/s as the letter has it everywhere.
#[test]
fn four_omegas_are_rotor_speeds_and_no_rates() {
    let text = table("t,gx,gy,gz,omega1,omega2,omega3,omega4,m1,m2,m3,m4", |_, time_s| {
        format!("{time_s},{},500.5,510.25,520,530,{}", rates(time_s), pulses(time_s))
    });
    let (toml, log) = read(&text);
    let rpm = log.column(Quantity::Rpm(1)).unwrap()[30];
    assert!((rpm - 510.25 * 60.0 / (2.0 * std::f64::consts::PI)).abs() < 1e-3, "{rpm}\n{toml}");
    assert!(toml.contains("rpm2 = { column = \"omega2\"") && toml.contains("not known"), "{toml}");
}

/// Betaflight's and Cleanflight's CSV: so many counts to 1 g, which the rows do not say.
#[test]
fn counts_of_an_accelerometer_are_scaled_by_gravity() {
    for counts_per_g in [2048.0, 4096.0, 512.0, 1000.0, 777.0] {
        let text = table(
            "time (us),gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2],motor[0],motor[1],\
             motor[2],motor[3]",
            |number, time_s| {
                let [x, y] = [0.02, 0.03].map(|height| counts_per_g * wave(time_s, height));
                let z = counts_per_g * (1.0 + wave(time_s, 0.015));
                format!("{},{},{x:.0},{y:.0},{z:.0},{}", 10_000 * number, rates(time_s), pulses(time_s))
            },
        );
        let (toml, log) = read(&text);
        let z = log.accel_body_m_s2[2].as_ref().unwrap();
        let mean = z.iter().sum::<f64>() / z.len() as f64;
        // the waves' mean, and what the median is off by where no usual scale is near, are a hundredth each; which way
        // z counts so short a log does not tell
        assert!((mean.abs() / GRAVITY_M_S2 - 1.0).abs() < 0.02, "{counts_per_g}: {mean}\n{toml}");
        let is_usual = counts_per_g != 777.0;
        assert_eq!(toml.contains(&format!("{counts_per_g:.0} counts to 1 g")), is_usual, "{toml}");
        assert_eq!(toml.contains("not known: its scale"), !is_usual, "{toml}");
    }
    // and what is in g or in m/s^2 stays so
    for (unit, key) in [(1.0, "az_g"), (GRAVITY_M_S2, "az_m_s2")] {
        let text = table("t,gx,gy,gz,acc_x,acc_y,acc_z,m1,m2,m3,m4", |_, time_s| {
            let [x, y] = [0.02, 0.03].map(|height| unit * wave(time_s, height));
            format!("{time_s},{},{x},{y},{},{}", rates(time_s), unit * (wave(time_s, 0.01) - 1.0), pulses(time_s))
        });
        let (toml, _) = read(&text);
        assert!(toml.contains(&format!("{key} = {{ column = \"acc_z\" }}")), "{toml}");
    }
}

/// As logs are that were merged from several rates: docs/log-format.md reads blank fields as missing values.
#[test]
fn what_is_logged_at_a_slower_rate_is_taken_and_said() {
    let text = table("t,gx,gy,gz,vbat_V,roll,pitch,m1,m2,m3,m4", |number, time_s| {
        let slow = |every: u32, value: f64| if number % every == 0 { value.to_string() } else { String::new() };
        let [volts, roll, pitch] =
            [slow(20, 12.0 - 0.1 * time_s), slow(5, wave(time_s, 0.2)), slow(5, wave(time_s, 0.1))];
        format!("{time_s},{},{volts},{roll},{pitch},{}", rates(time_s), pulses(time_s))
    });
    let (toml, log) = read(&text);
    assert!((log.battery_v.as_ref().unwrap()[40] - 11.96).abs() < 1e-9, "{toml}");
    assert!(log.angle_rad[1].is_some(), "{toml}");
    let line = toml.lines().find(|line| line.starts_with("battery_v = ")).unwrap();
    assert!(line.contains("in 8 of 150 rows"), "{line}");
}

/// A shorter table beside the log, whose rows have times of their own: by the rows of the first it would be read at
/// wrong times.
#[test]
fn a_second_table_beside_the_first_is_left_out_and_said() {
    let text = table("t,gx,gy,gz,m1,m2,m3,m4,t2,roll,pitch", |number, time_s| {
        let beside = if number < 30 { format!("{},0.1,0.2", 0.05 * f64::from(number)) } else { ",,".to_owned() };
        format!("{time_s},{},{},{beside}", rates(time_s), pulses(time_s))
    });
    let (toml, log) = read(&text);
    assert!(log.angle_rad[0].is_none(), "{toml}");
    let said = toml.lines().find(|line| line.starts_with("# not used, of another table")).unwrap();
    assert!(said.ends_with(": t2, roll, pitch") && said.contains("30 of 150 rows"), "{said}");
}

/// A column of words is none of numbers, however many of its fields are blank.
#[test]
fn words_are_no_slower_rate() {
    let text = table("t,gx,gy,gz,m1,m2,m3,m4,roll", |number, time_s| {
        let said = ["", "left", "0.1", ""][number as usize % 4];
        format!("{time_s},{},{},{said}", rates(time_s), pulses(time_s))
    });
    let (toml, log) = read(&text);
    assert!(log.angle_rad[0].is_none() && toml.contains("# not used: roll\n"), "{toml}");
}

/// The rows of a body that tilts and turns, as a quaternion; its angles are read back.
#[test]
fn a_quaternion_gives_the_angles() {
    for (names, guessed) in [("qw,qx,qy,qz", false), ("q[0],q[1],q[2],q[3]", true), ("att.w,att.x,att.y,att.z", false)]
    {
        let angles = |time_s: f64| [wave(time_s, 0.3), wave(time_s, 0.2), time_s];
        let text = table(&format!("t,{names},gx,gy,gz,m1,m2,m3,m4"), |_, time_s| {
            let q = quaternion_world_from_body(angles(time_s)).map(|part| format!("{part:.9}")).join(",");
            format!("{time_s},{q},{},{}", rates(time_s), pulses(time_s))
        });
        let (toml, log) = read(&text);
        let columns = names.split(',').map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
        for axis in Axis::ALL {
            assert!(toml.contains(&format!("{}_rad = {{ euler_of = [{columns}] }}", axis.name())), "{toml}");
            for row in [0, 40, 140] {
                let (own, expected) =
                    (log.angle_rad[axis.index()].as_ref().unwrap()[row], angles(log.time_s[row])[axis.index()]);
                assert!((own - expected).abs() < 1e-7, "{names} {} {row}: {own} {expected}", axis.name());
            }
        }
        assert_eq!(toml.contains("the order of the four"), guessed, "{toml}");
    }
}

/// What a table has as an angle goes before, and four numbers that are no unit are nothing.
#[test]
fn a_quaternion_beside_angles_gives_what_they_lack() {
    let text = table("t,roll_rad,pitch_rad,qw,qx,qy,qz,gx,gy,gz,m1,m2,m3,m4", |_, time_s| {
        let q = quaternion_world_from_body([0.0, 0.0, 0.5]).map(|part| format!("{part:.9}")).join(",");
        format!("{time_s},{},{},{q},{},{}", wave(time_s, 0.3), wave(time_s, 0.2), rates(time_s), pulses(time_s))
    });
    let (toml, log) = read(&text);
    assert!(toml.contains("roll_rad = { column = \"roll_rad\" }") && toml.contains("yaw_rad = { euler_of ="), "{toml}");
    assert!((log.angle_rad[2].as_ref().unwrap()[3] - 0.5).abs() < 1e-7);
}

/// The commands' names say nothing: what else was recognised stays in the draft, for its user to go on with.
#[test]
fn what_is_recognised_stays_where_the_commands_are_not() {
    let text = table("t,roll_rad,pitch_rad,gx,gy,gz,unit_a,unit_b", |_, time_s| {
        format!("{time_s},{},{},{},0.1,0.2", wave(time_s, 0.3), wave(time_s, 0.2), rates(time_s))
    });
    let Draft { toml, problems } = drafted(&text);
    assert!(problems.len() == 1 && problems[0].starts_with("commands are missing"), "{problems:?}");
    for kept in ["axes = [\"roll\", \"pitch\", \"yaw\"]", "roll_rad = { column", "q_rad_s = { column = \"gy\" }"] {
        assert!(toml.contains(kept), "{kept}\n{toml}");
    }
    assert!(toml.contains("# not used: unit_a, unit_b"), "{toml}");
}

/// Six motors in step with the throttle, or four and two outputs for other things.
#[test]
fn six_motors_are_no_quadrotors() {
    let table_of = |further: fn(f64) -> f64| {
        table("t,gx,gy,gz,m1,m2,m3,m4,m5,m6", move |_, time_s| {
            let throttle = 0.5 + wave(time_s, 0.2);
            let motors = [0.01, 0.02, 0.03, 0.04].map(|trim| (throttle + trim).to_string()).join(",");
            format!("{time_s},{0},{motors},{1},{1}", rates(time_s), further(throttle))
        })
    };
    let draft = drafted(&table_of(|throttle| throttle - 0.02));
    let said = "m5 and m6 move as its first four motors do: only quadrotors are simulated";
    assert!(draft.problems.iter().any(|problem| problem == said), "{:?}", draft.problems);
    let (toml, _) = read(&table_of(|_| 0.5));
    assert!(toml.contains("motor4 = { column = \"m4\"") && toml.contains("# not used: m5, m6"), "{toml}");
}

/// Names that say more than they need, of a laboratory's own controller.
#[test]
fn plain_names_go_before_those_that_say_more() {
    let thrusts: Vec<String> =
        (1..=4).map(|motor| format!("Thrust motors normalized QUADCOPTER T{motor} [-]")).collect();
    // a mode that did not fly
    let idle: Vec<String> = thrusts.iter().map(|name| name.replace("normalized", "spare")).collect();
    let header = format!(
        "Initial timestamp, Current time [s], Wanted roll of the user [rad], Roll [rad], Pitch [rad], \
         Angular velocity x [rad/s], Angular velocity y [rad/s], Algorithm execution time [us], {}, {}",
        idle.join(", "),
        thrusts.join(", ")
    );
    let text = table(&header, |row, time_s| {
        let thrusts = [0.5, 0.51, 0.52, 0.53].map(|thrust| (thrust + wave(time_s, 0.02)).to_string()).join(",");
        format!(
            "17,{time_s},0.1,{},{},{},{},{row},0,0,0,0,{thrusts}",
            wave(time_s, 0.2),
            wave(time_s, 0.1),
            0.1,
            wave(time_s, 0.3)
        )
    });
    let (toml, log) = read(&text);
    for line in [
        "time_s = { column = \"Current time [s]\"",
        "roll_rad = { column = \"Roll [rad]\"",
        "motor4 = { column = \"Thrust motors normalized QUADCOPTER T4 [-]\"",
    ] {
        assert!(toml.contains(line), "{line}\n{toml}");
    }
    assert_eq!(log.rows(), 150);
}
