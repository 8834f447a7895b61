//! A Crazyflie flown for identification (ARP lab, arXiv 2404.07837): inertia, thrust curve and lag, by the diagnosis and by the authors' way, beside what
//! the authors found.
//!
//! The authors' way (their notebook): commands u behind a first-order lag; mass times the accelerometer along the lifts as a polynomial of
//! u, and the lag that leaves least of it; inertia from torque and angular acceleration row by row. They took the thrust curve from
//! a third flight, and did not measure Izz: it is 1.832 times the mean of the other two.

use sil_host::axis::Axis;
use sil_host::diagnosis::{Estimate, Subject, sizes};
use sil_host::log::Log;
use sil_host::model::{Mounting, VehicleModel};
use sil_host::vehicle::propulsion::Propulsion;

use super::TORQUE_SIGNS;
use super::least_squares::least_squares;

/// The flying part of the log for roll and pitch, s.
pub const ROLL_PITCH_S: [f64; 2] = [16.0, 51.0];
/// The flying parts of the log for yaw, s.
pub const YAW_S: [[f64; 2]; 2] = [[15.5, 21.5], [28.5, 32.0]];
/// The command about which these flights keep.
pub const HOVER: f64 = 0.65;
/// Distance of a rotor from the axes of roll and pitch, m (the authors').
const LEVER_M: f64 = 0.028;

/// What the authors give (paper and notebook).
pub mod authors {
    /// Lift of a motor, N: constant, linear and square.
    pub const LIFT_N: [f64; 3] = [0.02127, -0.01118, 0.12013];
    /// The motors' lag, s.
    pub const TIME_CONSTANT_S: f64 = 0.072;
    /// About roll, pitch and yaw, kg m^2; the last is a fixed ratio.
    pub const INERTIA_KG_M2: [f64; 3] = [1.029e-5, 1.105e-5, 1.955e-5];
    /// Reaction torque over lift, m.
    pub const TORQUE_PER_LIFT_M: f64 = 4.548e-3;
}

/// The polynomial of a thrust curve at a command, N.
pub fn lift_n([constant, linear, square]: [f64; 3], command: f64) -> f64 {
    constant + command * (linear + command * square)
}

/// Its slope, N per unit of command.
pub fn lift_slope_n([_, linear, square]: [f64; 3], command: f64) -> f64 {
    linear + 2.0 * command * square
}

/// A shipped model of the Crazyflie, from other literature.
///
/// # Panics
/// The file is gone.
pub fn vehicle() -> VehicleModel {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/crazyflie-free.toml");
    VehicleModel::load(path.as_ref()).expect("a model that ships")
}

/// The four commands behind a first-order lag, row by row.
fn lagged(log: &Log, time_constant_s: f64) -> Vec<[f64; 4]> {
    let motors = log.motors().expect("four motors");
    let mut state = motors.map(|motor| motor[0]);
    let mut rows = vec![state];
    for row in 1..log.rows() {
        let left = libm::exp((log.time_s[row - 1] - log.time_s[row]) / time_constant_s);
        state = core::array::from_fn(|i| motors[i][row - 1] + left * (state[i] - motors[i][row - 1]));
        rows.push(state);
    }
    rows
}

/// A thrust curve with the lag that suits it best.
#[derive(Clone, Copy, Debug)]
pub struct ThrustCurve {
    /// Lift of one motor, N: constant, linear and square.
    pub lift_n: [f64; 3],
    /// Lag, s.
    pub time_constant_s: f64,
    /// Root mean square of what is left of the force, N.
    pub left_n: f64,
}

/// The authors' way on a part of a log: the force along the lifts as a polynomial of the lagged commands.
///
/// # Panics
/// The log has no accelerometer.
pub fn thrust_curve(log: &Log, vehicle: &VehicleModel) -> ThrustCurve {
    let Mounting::Free { mass_kg } = vehicle.mounting else { panic!("free flight") };
    let down = log.accel_body_m_s2[2].as_ref().expect("an accelerometer");
    let force_n: Vec<f64> = down.iter().map(|down| -mass_kg * down).collect();
    let with_lag = |time_constant_s: f64| {
        let commands = lagged(log, time_constant_s);
        let sum = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            commands.iter().map(|row| row.iter().map(|u| of(*u)).sum()).collect()
        };
        let (ones, linear, square) = (sum(&|_| 1.0), sum(&|u| u), sum(&|u| u * u));
        let (lift_n, left_n) = least_squares([&ones, &linear, &square], &force_n);
        ThrustCurve { lift_n, time_constant_s, left_n }
    };
    let lags = (30..=110).map(|ms| 1e-3 * f64::from(ms));
    lags.map(with_lag).min_by(|a, b| a.left_n.total_cmp(&b.left_n)).expect("lags")
}

/// Means and standard deviations of the means of numbers that are found in each fifth of a log by itself.
pub fn by_fifths<const N: usize>(log: &Log, of: impl Fn(&Log) -> [f64; N]) -> [Estimate; N] {
    let (first_s, length_s) = (log.time_s[0], 0.2 * log.duration_s());
    let part = |k: u32| {
        let from_s = first_s + f64::from(k) * length_s;
        of(&log.between(from_s, from_s + length_s).expect("a fifth of a log"))
    };
    let fifths: Vec<[f64; N]> = (0..5).map(part).collect();
    core::array::from_fn(|i| {
        let mean = fifths.iter().map(|fifth| fifth[i]).sum::<f64>() / 5.0;
        let squares: f64 = fifths.iter().map(|fifth| (fifth[i] - mean) * (fifth[i] - mean)).sum();
        // of five values, over the root of five
        Estimate { value: mean, std: (squares / 4.0 / 5.0).sqrt() }
    })
}

/// Inertia about an axis, kg m^2, from the torque of a thrust curve and the angular acceleration row by row: the authors' way, torque on acceleration, which takes
/// all that is not inertia for an error of the torque; and acceleration on torque, which takes it for one of the acceleration.
/// The former is too small by their squared correlation, if the latter is right.
///
/// # Panics
/// The log has no gyro.
pub fn regressed_inertia_kg_m2(log: &Log, curve: [f64; 3], time_constant_s: f64, axis: Axis) -> [f64; 2] {
    const SIDE: usize = 5;
    let rate = log.rate_rad_s[axis.index()].as_ref().expect("a gyro");
    let commands = lagged(log, time_constant_s);
    let (mut on_acceleration, mut both, mut on_torque) = (0.0, 0.0, 0.0);
    for row in SIDE..log.rows() - SIDE {
        let torque_nm = LEVER_M * difference(&commands[row], axis, |u| lift_n(curve, u));
        let step_s = log.time_s[row + SIDE] - log.time_s[row - SIDE];
        let acceleration = (rate[row + SIDE] - rate[row - SIDE]) / step_s;
        on_acceleration += acceleration * acceleration;
        both += acceleration * torque_nm;
        on_torque += torque_nm * torque_nm;
    }
    [both / on_acceleration, on_torque / both]
}

/// What the motors that turn the vehicle one way about an axis have more than the others.
fn difference(commands: &[f64; 4], axis: Axis, of: impl Fn(f64) -> f64) -> f64 {
    commands.iter().zip(TORQUE_SIGNS[axis.index()]).map(|(u, sign)| sign * of(*u)).sum()
}

/// What moves the vehicle about yaw, by least squares over windows of half a second.
#[derive(Clone, Copy, Debug)]
pub struct Yaw {
    /// Reaction torque over lift over Izz, 1/(kg m).
    pub torque_per_lift_over_inertia: f64,
    /// How far the rotors' own turning turns the vehicle: rate about yaw per unit of command that two motors have more than the others, rad/s.
    pub rate_per_command_rad_s: f64,
    /// Braking, 1/s.
    pub damping_1_s: f64,
    /// Root mean square of what is left of the rate, rad/s: with all this, and without rotors and braking.
    pub left_rad_s: [f64; 2],
}

/// Reaction torque, the rotors' acceleration, damping and a constant moment, fitted to the rate about yaw.
///
/// # Panics
/// The log has no gyro.
pub fn yaw(parts: &[Log], curve: [f64; 3], time_constant_s: f64) -> Yaw {
    const WINDOW_S: f64 = 0.5;
    let mut columns: [Vec<f64>; 4] = Default::default();
    let mut measured = Vec::new();
    for log in parts {
        let rate = log.rate_rad_s[2].as_ref().expect("a gyro");
        let commands = lagged(log, time_constant_s);
        let window_of = |row: usize| ((log.time_s[row] - log.time_s[0]) / WINDOW_S) as usize;
        let mut first = 0;
        while first + 1 < log.rows() {
            let end = (first..log.rows()).find(|row| window_of(*row) != window_of(first)).unwrap_or(log.rows());
            let mut window: [Vec<f64>; 5] = Default::default();
            let (mut lift, mut turned) = (0.0, 0.0);
            for row in first..end {
                let step_s = if row > first { log.time_s[row] - log.time_s[row - 1] } else { 0.0 };
                lift += step_s * difference(&commands[row], Axis::Yaw, |u| lift_n(curve, u));
                turned += step_s * rate[row];
                let speeds = difference(&commands[row], Axis::Yaw, |u| u);
                let values = [lift, log.time_s[row], speeds, turned, rate[row]];
                window.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
            }
            // the rate at a window's begin is free
            for (column, window) in columns.iter_mut().chain([&mut measured]).zip(&window) {
                let mean = window.iter().sum::<f64>() / window.len() as f64;
                column.extend(window.iter().map(|value| value - mean));
            }
            first = end;
        }
    }
    let [lift, time, speeds, turned] = columns.each_ref().map(Vec::as_slice);
    let (_, without) = least_squares([lift, time], &measured);
    let (factors, left) = least_squares([lift, time, speeds, turned], &measured);
    Yaw {
        torque_per_lift_over_inertia: factors[0],
        rate_per_command_rad_s: factors[2],
        damping_1_s: -factors[3],
        left_rad_s: [left, without],
    }
}

/// What the diagnosis says of roll and pitch.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Inertia over the model's about roll and pitch, if the motors lift what the model says: torque over inertia is what shows.
    pub inertia_scale: [f64; 2],
    /// Lag of the motors, the model's and what comes to it, s.
    pub lag_s: f64,
}

/// The diagnosis' sizes on the log for roll and pitch, beside the constant moments that every vehicle has.
///
/// # Panics
/// The log can't be diagnosed, or the model has no lag.
pub fn roll_and_pitch(log: &Log, vehicle: &VehicleModel) -> Sizes {
    let Propulsion::Generic(rotor) = vehicle.propulsion else { panic!("a model with a lag") };
    let asked = [
        ("inertia_error", Some(Axis::Roll)),
        ("inertia_error", Some(Axis::Pitch)),
        ("motor_lag", None),
        ("torque_bias", Some(Axis::Roll)),
        ("torque_bias", Some(Axis::Pitch)),
        ("torque_bias", Some(Axis::Yaw)),
    ];
    // what the accelerometer says of the lifts is the thrust curve's matter
    let gyro_alone = Log { accel_body_m_s2: [None, None, None], ..log.clone() };
    let sizes = sizes(&gyro_alone, &Subject::Vehicle(vehicle), &asked).expect("a log with windows");
    let value = |place: usize, name: &str| sizes[place].as_ref().expect("an effect of the catalogue")[name].value;
    Sizes {
        inertia_scale: [value(0, "scale"), value(1, "scale")],
        lag_s: rotor.time_constant_s + value(2, "time_constant_s"),
    }
}
