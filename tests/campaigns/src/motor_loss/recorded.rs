//! Flights that other people recorded, brought to the steps of a control loop: what the detector of lost motors would
//! have been given.
//!
//! A log that is faster than the loop goes through the core's low-pass of the gyro at its own rate, then each step has
//! the mean of its rows; a slower one is interpolated, so that what is quicker than its rows is missing. Commands are
//! in force from their row on. What is believed of the vehicles is what a user would: identified from one log, of which
//! the others know nothing; where no log shows the vehicle, the F450 with the command at which this one hovers.

use shared_control::config::Tuning;
use shared_control::filter::LowPass2;
use shared_control::lift_curve::LiftCurve;
use shared_control::vehicle::VehicleParameters;
use sil_host::control_setup::vehicle_parameters;
use sil_host::diagnosis::{KnownScale, identify};
use sil_host::log::flown::Flown;
use sil_host::log::{BUILT_IN_MAPS, Log, Map, read};

use crate::real_logs::{TORQUE_SIGNS, crazyflie, files, load, name_of};

/// Of the loop.
pub const LOOP_RATE_HZ: f64 = 400.0;
/// A step of the log that is longer parts a flight, s.
const GAP_S: f64 = 0.1;
/// A Crazyflie, weighed (arXiv 2404.07837), and its rotors' distance from the centre, m.
const CRAZYFLIE_KG: f64 = 0.027;
const CRAZYFLIE_ARM_M: f64 = 0.0396;
/// `models/f450-free.toml`.
const F450_KG: f64 = 1.2;

/// What a step of the loop knows.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Body rates behind the gyro's low-pass, rad/s.
    pub rate_rad_s: [f64; 3],
    /// Specific force along z, m/s^2.
    pub force_z_m_s2: f64,
    /// Commands of the motors in docs/rig.md's order, 0..1.
    pub motors: [f64; 4],
}

/// A log's flight without gaps.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Of the log.
    pub name: String,
    /// What is believed of the vehicle.
    pub vehicle: VehicleParameters,
    /// At [`LOOP_RATE_HZ`].
    pub steps: Vec<Step>,
}

/// All recorded flights with gyro, accelerometer and the commands of four motors; none where the logs are absent.
///
/// # Panics
/// The logs are there and not what they were.
pub fn all() -> Vec<Recorded> {
    let crazyflies = files("flight_crazyflie_arplab", "");
    let [first, ..] = &crazyflies[..] else { return Vec::new() };
    let [from_s, to_s] = crazyflie::ROLL_PITCH_S;
    let log = load(first, "crazyflie_arplab");
    let known = KnownScale { mass_kg: Some(CRAZYFLIE_KG), arm_m: Some(CRAZYFLIE_ARM_M) };
    let excited = log.between(from_s, to_s).expect("a log of a minute");
    let model = identify(&[excited], known).expect("a log flown for identification").model;
    let believed = vehicle_parameters(&model);
    let mut flights = Vec::new();
    for path in &crazyflies {
        let log = load(path, "crazyflie_arplab");
        // of the other log the same parts as for yaw: before and after it is held
        let spans = if path == first { vec![[from_s, to_s]] } else { crazyflie::YAW_S.to_vec() };
        for [from_s, to_s] in spans {
            flights.extend(of_log(&log.between(from_s, to_s).expect("a part of it"), &name_of(path), &believed));
        }
    }
    let map = crazypad_map();
    for path in files("flight_crazypad", "controller_data") {
        let log = read(&path, Some(&map)).unwrap_or_else(|e| panic!("{e}"));
        let flown = Flown::of(&log);
        for flight in &flown.flights {
            let part = log.between(flight.from_s, flight.to_s).expect("a flight");
            flights.extend(of_log(&part, &name_of(&path), &hovering(&believed, CRAZYFLIE_KG, &part)));
        }
    }
    flights.extend(ardupilot());
    flights
}

/// Axis commands and gyro as the shipped map has them, and the accelerometer along z, in g.
fn crazypad_map() -> Map {
    let (name, text) = BUILT_IN_MAPS.iter().find(|(name, _)| *name == "crazypad_controller").expect("a shipped map");
    let force = "az_m_s2 = { column = \"controller_accelz\", scale = -9.81 }\n";
    Map::parse(name, &format!("{text}{force}")).expect("a line more")
}

/// An ArduPilot log outdoors; nobody knows the vehicle, and it is too quiet and too slow to be identified.
fn ardupilot() -> Vec<Recorded> {
    let Some(folder) = crate::real_logs::folder() else { return Vec::new() };
    let path = folder.join("flight_ardupilot_log171/log171.bin.gz");
    let log = read(&path, None).unwrap_or_else(|e| panic!("{e}"));
    let flown = Flown::of(&log);
    let parts = flown.flights.iter().map(|flight| log.between(flight.from_s, flight.to_s).expect("a flight"));
    parts.flat_map(|part| of_log(&part, "log171", &hovering(&VehicleParameters::F450_FREE, F450_KG, &part))).collect()
}

/// A vehicle whose lift goes with the command and carries it at this flight's mean: these flight controllers straighten
/// the curve behind their commands.
fn hovering(believed: &VehicleParameters, mass_kg: f64, log: &Log) -> VehicleParameters {
    let rows = motors(log);
    let command = rows.iter().flatten().sum::<f64>() / (4 * rows.len()) as f64;
    let lift_max_n = mass_kg * f64::from(believed.gravity_m_s2) / (4.0 * command);
    VehicleParameters { lift_curve: LiftCurve::straight(lift_max_n as f32), ..*believed }
}

/// The commands of four motors, row by row.
fn motors(log: &Log) -> Vec<[f64; 4]> {
    if let Some(columns) = log.motors() {
        return (0..log.rows()).map(|row| columns.map(|column| column[row])).collect();
    }
    let per_axis = log.motor_per_axis_command.expect("a map that says how motors are told");
    let thrust = log.thrust_command.as_ref().expect("a thrust command");
    let axes = log.axis_command.each_ref().map(|column| column.as_ref().expect("three axes"));
    let of = |row: usize, motor: usize| {
        let turns = (0..3).map(|axis| TORQUE_SIGNS[axis][motor] * per_axis[axis] * axes[axis][row]).sum::<f64>();
        (thrust[row] + turns).clamp(0.0, 1.0)
    };
    (0..log.rows()).map(|row| core::array::from_fn(|motor| of(row, motor))).collect()
}

/// A log's stretches without gaps on the loop's steps.
fn of_log(log: &Log, name: &str, vehicle: &VehicleParameters) -> Vec<Recorded> {
    let parted: Vec<usize> = (1..log.rows()).filter(|row| log.time_s[*row] - log.time_s[row - 1] > GAP_S).collect();
    let ends: Vec<usize> = [0].into_iter().chain(parted).chain([log.rows()]).collect();
    let motors = motors(log);
    let rates = log.rate_rad_s.each_ref().map(|column| filtered(column.as_ref().expect("a gyro"), log.rate_hz()));
    let force = log.accel_body_m_s2[2].as_ref().expect("an accelerometer");
    let stretch = |rows: &[usize]| -> Vec<Step> {
        let (first, last) = (rows[0], rows[1] - 1);
        let duration_s = log.time_s[last] - log.time_s[first];
        let count = (duration_s * LOOP_RATE_HZ) as usize;
        let time_s = &log.time_s[first..=last];
        (0..count)
            .map(|step| {
                let from_s = time_s[0] + step as f64 / LOOP_RATE_HZ;
                let to_s = from_s + 1.0 / LOOP_RATE_HZ;
                let at = |column: &[f64]| mean_between(time_s, &column[first..=last], [from_s, to_s]);
                let in_force = first + time_s.partition_point(|row_s| *row_s <= to_s) - 1;
                Step {
                    rate_rad_s: rates.each_ref().map(|column| at(column)),
                    force_z_m_s2: at(force),
                    motors: motors[in_force],
                }
            })
            .collect()
    };
    let recorded = |steps| Recorded { name: name.to_owned(), vehicle: *vehicle, steps };
    ends.windows(2).filter(|rows| rows[1] - rows[0] > 1).map(|rows| recorded(stretch(rows))).collect()
}

/// As the core's estimator has the gyro, where the log is fast enough to have what that takes out.
fn filtered(column: &[f64], rate_hz: f64) -> Vec<f64> {
    if rate_hz < LOOP_RATE_HZ {
        return column.to_vec();
    }
    let low_pass = LowPass2::new(Tuning::for_vehicle(&VehicleParameters::F450_FREE).gyro_cutoff_hz, rate_hz as f32);
    let mut state = low_pass.settled(column[0] as f32);
    column.iter().map(|value| f64::from(low_pass.update(&mut state, *value as f32))).collect()
}

/// Mean of the rows of a step, or what a straight line between its neighbours says at the step's end.
fn mean_between(time_s: &[f64], column: &[f64], [from_s, to_s]: [f64; 2]) -> f64 {
    let first = time_s.partition_point(|row_s| *row_s <= from_s);
    let end = time_s.partition_point(|row_s| *row_s <= to_s);
    if end - first >= 2 {
        return column[first..end].iter().sum::<f64>() / (end - first) as f64;
    }
    let after = end.clamp(1, column.len() - 1);
    let share = ((to_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1])).clamp(0.0, 1.0);
    column[after - 1] + share * (column[after] - column[after - 1])
}
