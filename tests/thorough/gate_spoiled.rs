//! The gate of logs on simulated ones: whatever effect is in them they pass, and spoiled copies are refused with the
//! line of the map that mends them. The copies of real logs are spoiled alike.

use campaigns::blind::{Conditions, EFFECTS, EFFECTS_IN_FREE_FLIGHT, Hidden};
use campaigns::real_logs::{files, folder, load};
use sil_host::axis::Axis;
use sil_host::effects::Effect;
use sil_host::log::sanity::examine;
use sil_host::log::{Column, Log, read};
use sil_host::model::{Rig, VehicleModel};
use sil_host::sensors::random::RandomStream;
use sil_host::synthesis::Synthesis;

fn synthetic(rig: Rig, effects: &[&str], seed: u64, duration_s: f64) -> Log {
    let mut model = VehicleModel::nominal(rig);
    let inertia_kg_m2 = model.inertia_kg_m2;
    model.effects = effects.iter().map(|short| Effect::parse_for(short, rig, inertia_kg_m2).unwrap()).collect();
    Synthesis { seed, duration_s, ..Synthesis::of(model) }.log().unwrap()
}

fn refusals(log: &Log) -> String {
    examine(log, None).contradictions.iter().map(|c| format!("{c}\n")).collect()
}

/// Refusals of an effect that is clearly there, in a log of 15 s.
fn refusals_of(name: &'static str, conditions: Conditions, draws: &mut RandomStream) -> String {
    let effect = Hidden::draw(name, conditions.duration_s, conditions.rig, draws);
    let short = effect.short(4.0 * effect.first_size);
    let refused = refusals(&conditions.synthesised(std::slice::from_ref(&short)));
    refused.lines().map(|line| format!("{short}: {line}\n")).collect()
}

// the blind campaigns have the same gate before them, with sizes that are only just to be seen
#[test]
fn every_effect_passes() {
    let mut draws = RandomStream::new(1, "gate");
    let mut refused = String::new();
    for (seed, name) in (0..).zip(EFFECTS) {
        let conditions = Conditions::draw(seed, 8.0, &mut draws);
        refused += &refusals_of(name, conditions, &mut draws);
    }
    for (seed, name) in (0..).zip(EFFECTS_IN_FREE_FLIGHT) {
        let conditions = Conditions::draw_free(seed, 8.0, &mut draws);
        refused += &refusals_of(name, conditions, &mut draws);
    }
    assert!(refused.is_empty(), "{refused}");
}

#[test]
fn large_effects_pass() {
    let large = [
        "gyro_scale:axis=roll,scale=0.4",
        "gyro_scale:axis=pitch,scale=2.5",
        "weak_motor:motor=1,scale=0.6",
        "motor_lag:time_constant_s=0.1",
        "attitude_delay:delay_s=0.08",
        "gyro_bias:axis=pitch,bias_rad_s=0.3",
        "torque_bias:axis=pitch,torque_nm=0.2",
        "imu_misalignment:yaw_rad=0.2",
    ];
    for rig in [Rig::Gimbal, Rig::Free] {
        for effect in large {
            let log = synthetic(rig, &[effect], 1, 10.0);
            assert_eq!(refusals(&log), "", "{effect}");
        }
        let log = synthetic(rig, &[], 2, 10.0);
        println!("{:?}", examine(&log, None).confirmed);
    }
}

/// A way to spoil a log, what the refusal must name, and the line of the map that mends it.
struct Spoiled {
    name: &'static str,
    spoil: fn(&mut Log),
    names: &'static [&'static str],
}

fn scale(column: &mut Column, by: f64) {
    column.iter_mut().flatten().for_each(|value| *value *= by);
}

fn scale_all(columns: &mut [Column], by: f64) {
    columns.iter_mut().for_each(|column| scale(column, by));
}

fn turn(log: &mut Log, axis: Axis) {
    scale(&mut log.rate_rad_s[axis.index()], -1.0);
    scale(&mut log.angle_rad[axis.index()], -1.0);
}

/// Gives our motors the columns of others.
fn reorder(log: &mut Log, from: [usize; 4]) {
    let motors = log.motor_command.clone();
    log.motor_command = from.map(|motor| motors[motor].clone());
}

fn hold(column: &mut Column, from_share: f64) {
    let Some(values) = column else { return };
    let from = (from_share * values.len() as f64) as usize;
    let value = values[from];
    values[from..].iter_mut().for_each(|held| *held = value);
}

/// Turns the gyro by 45 degrees about yaw, which is what a plus frame's motors look like, too.
fn turn_gyro_by_45_degrees(log: &mut Log) {
    let (p, q) = (log.rate_rad_s[0].clone().unwrap(), log.rate_rad_s[1].clone().unwrap());
    let half = std::f64::consts::FRAC_1_SQRT_2;
    log.rate_rad_s[0] = Some(p.iter().zip(&q).map(|(p, q)| half * (p + q)).collect());
    log.rate_rad_s[1] = Some(p.iter().zip(&q).map(|(p, q)| half * (q - p)).collect());
    log.angle_rad = [None, None, None];
}

const OF_ANGLES_AND_RATES: [Spoiled; 13] = [
    Spoiled {
        name: "rates in deg/s",
        spoil: |l| scale_all(&mut l.rate_rad_s, 57.29578),
        names: &["deg/s", "p_deg_s = {", "q_deg_s = {"],
    },
    Spoiled { name: "q in deg/s", spoil: |l| scale(&mut l.rate_rad_s[1], 57.29578), names: &["deg/s", "q_deg_s = {"] },
    Spoiled {
        name: "angles in degrees",
        spoil: |l| scale_all(&mut l.angle_rad, 57.29578),
        names: &["degrees", "_deg = {"],
    },
    Spoiled {
        name: "pitch in degrees",
        spoil: |l| scale(&mut l.angle_rad[1], 57.29578),
        names: &["degrees", "pitch_deg = {"],
    },
    Spoiled {
        name: "q turned",
        spoil: |l| scale(&mut l.rate_rad_s[1], -1.0),
        names: &["turned", "q_rad_s = {", "sign = -1"],
    },
    Spoiled {
        name: "pitch turned",
        spoil: |l| scale(&mut l.angle_rad[1], -1.0),
        names: &["turned", "pitch_rad = {", "sign = -1"],
    },
    Spoiled { name: "time in ms", spoil: |l| l.time_s.iter_mut().for_each(|t| *t *= 1e3), names: &["time_ms = {"] },
    Spoiled { name: "time in us", spoil: |l| l.time_s.iter_mut().for_each(|t| *t *= 1e6), names: &["time_us = {"] },
    Spoiled { name: "time too short", spoil: |l| l.time_s.iter_mut().for_each(|t| *t *= 1e-3), names: &["time"] },
    Spoiled { name: "q stops", spoil: |l| hold(&mut l.rate_rad_s[1], 0.5), names: &["q_rad_s", "stays at"] },
    Spoiled { name: "q is 0", spoil: |l| scale(&mut l.rate_rad_s[1], 0.0), names: &["q_rad_s", "stays at"] },
    Spoiled { name: "pitch stops", spoil: |l| hold(&mut l.angle_rad[1], 0.4), names: &["pitch_rad", "stays at"] },
    Spoiled {
        name: "all stops",
        spoil: |l| {
            for column in l.angle_rad.iter_mut().chain(&mut l.rate_rad_s).chain(&mut l.accel_body_m_s2) {
                hold(column, 0.6);
            }
        },
        names: &["froze"],
    },
];

const OF_TWO_AXES: [Spoiled; 3] = [
    Spoiled {
        name: "p turned",
        spoil: |l| scale(&mut l.rate_rad_s[0], -1.0),
        names: &["turned", "p_rad_s = {", "sign = -1"],
    },
    Spoiled {
        name: "p and q swapped",
        spoil: |l| l.rate_rad_s.swap(0, 1),
        names: &["swapped", "p_rad_s = { column = \"q_rad_s\""],
    },
    Spoiled { name: "roll and pitch swapped", spoil: |l| l.angle_rad.swap(0, 1), names: &["swapped"] },
];

const OF_MOTORS: [Spoiled; 9] = [
    Spoiled {
        name: "motors 1 and 2",
        spoil: |l| reorder(l, [1, 0, 2, 3]),
        names: &["motor1 = { column = \"motor2\"", "motor2 = { column = \"motor1\""],
    },
    Spoiled { name: "motors 1 and 3", spoil: |l| reorder(l, [2, 1, 0, 3]), names: &["motor1 = { column = \"motor3\""] },
    Spoiled { name: "motors 3 and 4", spoil: |l| reorder(l, [0, 1, 3, 2]), names: &["motor3 = { column = \"motor4\""] },
    Spoiled { name: "motors around", spoil: |l| reorder(l, [3, 2, 0, 1]), names: &["motor", "another order"] },
    Spoiled { name: "motors as 1432", spoil: |l| reorder(l, [0, 3, 2, 1]), names: &["motor2 = { column = \"motor4\""] },
    Spoiled {
        name: "motors opposite",
        spoil: |l| reorder(l, [1, 0, 3, 2]),
        names: &["motor1 = { column = \"motor2\"", "motor3 = { column = \"motor4\""],
    },
    Spoiled {
        name: "pitch and q turned",
        spoil: |l| turn(l, Axis::Pitch),
        names: &["q_rad_s = {", "pitch_rad = {", "sign = -1"],
    },
    Spoiled {
        name: "all turned",
        spoil: |l| {
            turn(l, Axis::Roll);
            turn(l, Axis::Pitch);
        },
        names: &["goes against"],
    },
    Spoiled {
        name: "a frame turned by 90 degrees",
        spoil: |l| {
            l.rate_rad_s.swap(0, 1);
            l.angle_rad.swap(0, 1);
            turn(l, Axis::Pitch);
        },
        names: &["motors"],
    },
];

/// Where roll and pitch have about the same inertia.
const OF_THE_FRAME: [Spoiled; 1] = [Spoiled {
    name: "a frame turned by 45 degrees",
    spoil: turn_gyro_by_45_degrees,
    names: &["degrees about yaw", "plus frame", "frame_turn_deg ="],
}];

const OF_THE_ACCELEROMETER: [Spoiled; 6] = [
    Spoiled {
        name: "accelerometer in g",
        spoil: |l| scale_all(&mut l.accel_body_m_s2, 1.0 / 9.80665),
        names: &["likely g", "az_g = {"],
    },
    Spoiled {
        name: "z upward",
        spoil: |l| scale(&mut l.accel_body_m_s2[2], -1.0),
        names: &["z upward", "az_m_s2 = {", "sign = -1"],
    },
    Spoiled { name: "accelerometer turned", spoil: |l| scale_all(&mut l.accel_body_m_s2, -1.0), names: &["z upward"] },
    Spoiled { name: "y and z swapped", spoil: |l| l.accel_body_m_s2.swap(1, 2), names: &["swapped"] },
    Spoiled { name: "accelerometer in mm/s^2", spoil: |l| scale_all(&mut l.accel_body_m_s2, 1e3), names: &["unit"] },
    Spoiled {
        name: "gravity taken off",
        spoil: |l| l.accel_body_m_s2[2].iter_mut().flatten().for_each(|z| *z += 9.80665),
        names: &["taken off"],
    },
];

const OF_THE_TILT: [Spoiled; 3] = [
    Spoiled {
        name: "x turned",
        spoil: |l| scale(&mut l.accel_body_m_s2[0], -1.0),
        names: &["against", "ax_m_s2 = {", "sign = -1"],
    },
    Spoiled {
        name: "y turned",
        spoil: |l| scale(&mut l.accel_body_m_s2[1], -1.0),
        names: &["ay_m_s2 = {", "sign = -1"],
    },
    Spoiled {
        name: "x and y swapped",
        spoil: |l| l.accel_body_m_s2.swap(0, 1),
        names: &["ax_m_s2 = { column = \"ay_m_s2\""],
    },
];

const OF_COMMANDS: [Spoiled; 1] = [Spoiled {
    name: "pitch command turned",
    spoil: |l| scale(&mut l.axis_command[1], -1.0),
    names: &["pitch_cmd = {", "sign = -1"],
}];

/// Those of the ways that a log does not refuse as it should; how many were tried.
fn missed(of: &str, log: &Log, ways: &[&[Spoiled]], tried: &mut usize) -> String {
    let mut missed = String::new();
    for way in ways.iter().copied().flatten() {
        *tried += 1;
        let mut spoiled = log.clone();
        (way.spoil)(&mut spoiled);
        let said = refusals(&spoiled);
        if !way.names.iter().all(|name| said.contains(name)) {
            missed += &format!("{of}, {}: expected {:?}, said:\n{said}\n", way.name, way.names);
        }
    }
    missed
}

#[test]
fn spoiled_simulated_logs_are_refused() {
    let mut tried = 0;
    let mut all = String::new();
    let gimbal = synthetic(Rig::Gimbal, &["weak_motor:motor=2,scale=0.8", "motor_lag:time_constant_s=0.03"], 3, 30.0);
    let of_rig: [&[Spoiled]; 5] = [&OF_ANGLES_AND_RATES, &OF_TWO_AXES, &OF_MOTORS, &OF_THE_ACCELEROMETER, &OF_THE_TILT];
    all += &missed("gimbal", &gimbal, &of_rig, &mut tried);
    let free = synthetic(Rig::Free, &["gyro_scale:axis=pitch,scale=1.3"], 4, 30.0);
    let of_flight: [&[Spoiled]; 5] =
        [&OF_ANGLES_AND_RATES, &OF_TWO_AXES, &OF_MOTORS, &OF_THE_FRAME, &OF_THE_ACCELEROMETER];
    all += &missed("free", &free, &of_flight, &mut tried);
    println!("{tried} tried");
    assert!(all.is_empty(), "{all}");
}

#[test]
fn spoiled_real_logs_are_refused() {
    let mut tried = 0;
    let mut all = String::new();
    for path in files("rig_antx_2dof", "Lab01_part1_part1_log_0") {
        let log = load(&path, "antx");
        all += &missed(
            "antx",
            &log,
            &[&OF_ANGLES_AND_RATES[1..2], &OF_ANGLES_AND_RATES[3..], &OF_COMMANDS, &OF_THE_ACCELEROMETER],
            &mut tried,
        );
    }
    for path in files("rig_sharif_3dof", "cl_rollpitch_LQR_d1") {
        let log = load(&path, "sharif_roll_pitch");
        all += &missed("sharif", &log, &[&OF_ANGLES_AND_RATES[..11], &OF_TWO_AXES, &OF_COMMANDS], &mut tried);
    }
    for path in files("flight_crazyflie_arplab", "log15") {
        let log = load(&path, "crazyflie_arplab");
        all += &missed(
            "crazyflie",
            &log,
            &[&OF_MOTORS[..6], &OF_MOTORS[7..], &OF_THE_FRAME, &OF_THE_ACCELEROMETER],
            &mut tried,
        );
    }
    if let Some(data) = folder() {
        for name in ["flight_ardupilot_log171/log171.bin.gz", "formats/pyulog_sample.ulg.gz"] {
            let log = read(&data.join(name), None).unwrap();
            all +=
                &missed(name, &log, &[&OF_ANGLES_AND_RATES[..9], &OF_TWO_AXES, &OF_THE_ACCELEROMETER[..5]], &mut tried);
        }
    }
    println!("{tried} tried");
    assert!(all.is_empty(), "{all}");
}
