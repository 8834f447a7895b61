//! The estimator on flights that were measured: gyro and accelerometer of other people's logs, row by row through the
//! core, beside the attitude that the vehicle itself reported. Nothing is tuned on these.
//!
//! - ANT-X: PX4 on a bench; pitch is free, and the bench slides along a rail, so that it is neither held nor flies
//!   free: both are tried. Against PX4's own pitch while motors run.
//! - ArduPilot's log 171: outdoors, an IMU logged 49 times a second as it was at that instant, in turns of 100 deg/s:
//!   what is between the rows is lost, and the integral with it. Against its own roll and pitch, until it crashes.
//! - ARP lab's Crazyflie: no attitude, but it stands on the ground before and after its flight, so that what the
//!   estimate has become by landing shows against the accelerometer at rest.

use nalgebra::{UnitQuaternion, Vector3};
use shared_control::frames::{down_in_body, euler_from_q};
use shared_control::sensing::estimator::{self, EstimatorConfig, EstimatorState};
use shared_control::sensing::gyro_bias::GyroBias;
use shared_control::sensing::imu::{Flown, ImuConfig, ImuState, condition};
use shared_control::sensing::levelling::Support;
use shared_control::signals::RawImuSample;
use sil_host::log::{Log, read};

use crate::real_logs::{files, folder, load};

/// Motors below this stand still.
const TURNING: f64 = 0.02;
/// Time after the motors' start that counts as take-off, s.
const TAKE_OFF_S: f64 = 2.0;
/// When ArduPilot's log 171 crashes, s.
const CRASHED_S: f64 = 238.0;
/// Time at rest after landing over which the accelerometer is averaged, s.
const LANDED_S: f64 = 1.0;

/// One log's figures, degrees.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// Which log, and as what it was taken.
    pub name: String,
    /// Time in flight, s.
    pub flown_s: f64,
    /// Root mean square and largest difference from the vehicle's own attitude, or what is left at landing.
    pub rms_deg: f64,
    /// See there.
    pub max_deg: f64,
}

/// All logs; none where they are absent.
///
/// # Panics
/// A log is there and can't be read.
pub fn replayed() -> Vec<Replayed> {
    let Some(data) = folder() else { return Vec::new() };
    let mut all = Vec::new();
    for path in files("rig_antx_2dof", "Lab") {
        let log = load(&path, "antx");
        let name = path.file_name().unwrap_or_default().to_string_lossy().replace(".csv.gz", "");
        for support in [Support::Held, Support::Air] {
            all.extend(against_its_own(&log, &name, support));
        }
    }
    let ardupilot = read(&data.join("flight_ardupilot_log171/log171.bin.gz"), None).expect("the ArduPilot log");
    all.extend(against_its_own(&ardupilot, "ArduPilot log 171", Support::Air));
    for path in files("flight_crazyflie_arplab", "log") {
        let name = path.file_name().unwrap_or_default().to_string_lossy().replace(".csv.gz", "");
        all.extend(against_rest(&load(&path, "crazyflie_arplab"), &name));
    }
    all
}

/// As a table.
pub fn table(all: &[Replayed]) -> String {
    let mut text = String::from("| log | flown, s | RMS, deg | max, deg |\n|---|---|---|---|\n");
    for Replayed { name, flown_s, rms_deg, max_deg } in all {
        text.push_str(&format!("| {name} | {flown_s:.0} | {rms_deg:.2} | {max_deg:.2} |\n"));
    }
    text
}

/// A row of a replay.
struct Row {
    time_s: f64,
    turning: bool,
    down_body: Vector3<f32>,
    q_world_from_body: UnitQuaternion<f32>,
    force_m_s2: [f64; 3],
}

fn flown(log: &Log, support: Support) -> Vec<Row> {
    let config = ImuConfig::pixhawk1_mpu6000(100.0, log.rate_hz() as f32);
    let estimator_config = EstimatorConfig::NOMINAL;
    let (mut imu, mut state, mut gyro) = (ImuState::default(), EstimatorState::default(), GyroBias::default());
    let at = |column: &Option<Vec<f64>>, row: usize| column.as_ref().map_or(0.0, |column| column[row]);
    let start_s = log.time_s[0];
    let mut rows = Vec::new();
    for row in 0..log.rows() {
        let rate = [0, 1, 2].map(|axis| at(&log.rate_rad_s[axis], row) as f32);
        let force_m_s2 = [0, 1, 2].map(|axis| at(&log.accel_body_m_s2[axis], row));
        let counts = |axes: &shared_control::sensing::imu::AxisMap, body: [f32; 3], unit: f32| {
            axes.from_body(body).map(|value| (value / unit).round() as i16)
        };
        let sample = RawImuSample {
            time_us: ((log.time_s[row] - start_s) * 1e6) as u64 + 1,
            gyro_counts: counts(&config.gyro_axes, rate, config.gyro_rad_s_per_count),
            accel_counts: counts(&config.accel_axes, force_m_s2.map(|f| f as f32), config.accel_m_s2_per_count),
        };
        let motors = log
            .motors()
            .map_or(at(&log.thrust_command, row), |motors| motors.iter().map(|motor| motor[row]).sum::<f64>() / 4.0);
        let turning = motors > TURNING;
        let step = condition(&config, &mut imu, &[sample], sample.time_us, Flown::default());
        let carried = turning.then_some(support);
        let estimate = estimator::update(&estimator_config, &mut state, &mut gyro, &step, sample.time_us, carried);
        let q_world_from_body = estimate.q_world_from_body;
        let down_body = down_in_body(&q_world_from_body);
        rows.push(Row { time_s: log.time_s[row], turning, down_body, q_world_from_body, force_m_s2 });
    }
    rows
}

fn against_its_own(log: &Log, name: &str, support: Support) -> Option<Replayed> {
    let pitch_rad = log.angle_rad[1].as_ref()?;
    let rows = flown(log, support);
    let begun_s = rows.iter().find(|row| row.turning)?.time_s + TAKE_OFF_S;
    let mut errors_deg = Vec::new();
    for (row, at) in
        rows.iter().enumerate().filter(|(_, row)| row.turning && (begun_s..CRASHED_S).contains(&row.time_s))
    {
        let angles = euler_from_q(&at.q_world_from_body);
        let pitch_deg = (f64::from(angles.pitch_rad) - pitch_rad[row]).to_degrees();
        let roll_deg = log.angle_rad[0].as_ref().map_or(0.0, |roll_rad| {
            let turn_rad = f64::from(angles.roll_rad) - roll_rad[row];
            turn_rad.sin().atan2(turn_rad.cos()).to_degrees()
        });
        errors_deg.push(pitch_deg.hypot(roll_deg));
    }
    let squares: f64 = errors_deg.iter().map(|error| error * error).sum();
    Some(Replayed {
        name: format!("{name}, {support:?}"),
        flown_s: errors_deg.len() as f64 / log.rate_hz(),
        rms_deg: (squares / errors_deg.len() as f64).sqrt(),
        max_deg: errors_deg.iter().copied().fold(0.0, f64::max),
    })
}

fn against_rest(log: &Log, name: &str) -> Option<Replayed> {
    let rows = flown(log, Support::Air);
    let first = rows.iter().find(|row| row.turning)?.time_s;
    let landed = rows.iter().rfind(|row| row.turning)?;
    let at_rest: Vec<&Row> =
        rows.iter().filter(|row| (landed.time_s + 0.5..landed.time_s + 0.5 + LANDED_S).contains(&row.time_s)).collect();
    let mean: [f64; 3] =
        core::array::from_fn(|axis| at_rest.iter().map(|row| row.force_m_s2[axis]).sum::<f64>() / at_rest.len() as f64);
    let down = -Vector3::from(mean.map(|f| f as f32)).normalize();
    let left_deg = f64::from(down.cross(&landed.down_body).norm().asin()).to_degrees();
    let name = format!("{name}, left at landing ({} rows of rest)", at_rest.len());
    Some(Replayed { name, flown_s: landed.time_s - first, rms_deg: left_deg, max_deg: left_deg })
}
