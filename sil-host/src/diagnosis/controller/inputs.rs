//! What a controller saw and did according to a log, made ready for the control core.
//!
//! The core takes counts of the IMU at a multiple of the control rate; a log holds one reading a step, taken at the
//! step's instant. The readings in between are interpolated, which keeps the motion and loses their noise. Of what the
//! log does not hold, the gyro's bias and the attitude at the start come from its angles, the throttle from the motors'
//! mean lift; the specific force, where it is not logged, is gravity's in the logged attitude. Before the first row the
//! vehicle is held at rest, as before a flight, so that the core calibrates and arms itself.

use shared_control::config::Config;
use shared_control::mixer::MixerConfig;
use shared_control::signals::{ArmingRequest, ImuBatch, Setpoint};

use crate::axis::Axis;
use crate::cosim::contract::{DesignParameters, HELD_US, events_at};
use crate::log::{Log, Quantity};
use crate::scenario::{Scenario, Waypoint};
use crate::sensors::imu;
use crate::vehicle::signed_sums;

/// Rows whose time from the row before is off by more than this share of a control step are late, or rows are missing.
const UNEVEN_MAX: f64 = 0.25;
/// Share by which the log's rate may differ from the controller's.
const RATE_TOLERANCE: f64 = 0.01;
const BIAS_PASSES: usize = 3;
/// Rows that give the attitude at the start, s.
const START_S: f64 = 0.5;

/// A log that can't be replayed through a controller.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum NotReplayable {
    #[error(
        "the log has {log_hz:.0} rows a second and the controller runs at {controller_hz}: what it saw in between is \
         unknown"
    )]
    Rate { log_hz: f64, controller_hz: u32 },
    #[error("rows are missing or late at {time_s} s: what the controller saw there is unknown")]
    Uneven { time_s: f64 },
    #[error("the log lacks {0}")]
    Missing(String),
}

/// One step of the controller.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) time_us: u64,
    pub(super) imu: ImuBatch,
    pub(super) setpoint: Setpoint,
    pub(super) arming: ArmingRequest,
    /// What the motors did; none before the log begins.
    pub(super) flown: Option<Flown>,
}

/// The motors' commands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flown {
    /// Torque about the body's axes by the controllers' own lift curve, N m.
    pub(super) torque_body_nm: [f32; 3],
    /// A motor stood at an end of its range.
    pub(super) saturated: bool,
}

/// The columns that a replay needs, row by row.
struct Rows<'l> {
    angle_rad: [&'l [f64]; 2],
    rate_rad_s: [&'l [f64]; 2],
    yaw_rate_rad_s: Option<&'l [f64]>,
    force_m_s2: Option<[&'l [f64]; 3]>,
    reference_rad: [&'l [f64]; 2],
    motors: [&'l [f64]; 4],
    period_s: f64,
    gravity_m_s2: f64,
}

/// The controller's steps, those of the hold first, then one a row.
///
/// # Errors
/// [`NotReplayable`]
pub(super) fn steps(log: &Log, config: &Config, parameters: &DesignParameters) -> Result<Vec<Step>, NotReplayable> {
    check_rate(log, parameters.control_rate_hz)?;
    let rows = Rows::of(log, parameters)?;
    let at_rest = rows.at_rest();
    let mut steps = held_steps(&rows, &at_rest, parameters);
    let first = steps.len();
    let mut lift_n = 0.0;
    for row in 0..log.rows() {
        let time_us = tick_us(first + row, parameters.control_rate_hz);
        let (flown, mean_lift_n) = flown(&config.mixer, rows.motors.map(|motor| motor[row]));
        if row == 0 || !flown.saturated {
            lift_n = mean_lift_n;
        }
        steps.push(Step {
            time_us,
            imu: rows.samples(row, first, &at_rest, parameters),
            setpoint: Setpoint {
                roll_rad: rows.reference_rad[0][row] as f32,
                pitch_rad: rows.reference_rad[1][row] as f32,
                yaw_rate_rad_s: 0.0,
                throttle: config.mixer.lift_curve.command(lift_n),
                acro_rad_s: None,
            },
            arming: ArmingRequest::None,
            flown: Some(flown),
        });
    }
    Ok(steps)
}

fn check_rate(log: &Log, controller_hz: u32) -> Result<(), NotReplayable> {
    let period_s = 1.0 / f64::from(controller_hz);
    if (log.median_step_s() / period_s - 1.0).abs() > RATE_TOLERANCE {
        return Err(NotReplayable::Rate { log_hz: log.rate_hz(), controller_hz });
    }
    let start_s = log.time_s[0];
    let is_off = |row: &usize| ((log.time_s[*row] - start_s) / period_s - *row as f64).abs() > UNEVEN_MAX;
    match (0..log.rows()).find(is_off) {
        Some(row) => Err(NotReplayable::Uneven { time_s: log.time_s[row] }),
        None => Ok(()),
    }
}

impl<'l> Rows<'l> {
    fn of(log: &'l Log, parameters: &DesignParameters) -> Result<Self, NotReplayable> {
        let mut missing: Vec<String> = Vec::new();
        let mut take = |quantity: Quantity| -> &'l [f64] {
            log.column(quantity).unwrap_or_else(|| {
                missing.push(quantity.name());
                &[]
            })
        };
        let tilt = [Axis::Roll, Axis::Pitch];
        let rows = Self {
            angle_rad: tilt.map(|axis| take(Quantity::Angle(axis))),
            rate_rad_s: tilt.map(|axis| take(Quantity::Rate(axis))),
            yaw_rate_rad_s: log.column(Quantity::Rate(Axis::Yaw)),
            force_m_s2: match Axis::ALL.map(|axis| log.column(Quantity::Accel(axis))) {
                [Some(x), Some(y), Some(z)] => Some([x, y, z]),
                _ => None,
            },
            reference_rad: tilt.map(|axis| take(Quantity::Reference(axis))),
            motors: [0, 1, 2, 3].map(|motor| take(Quantity::Motor(motor))),
            period_s: 1.0 / f64::from(parameters.control_rate_hz),
            gravity_m_s2: parameters.gravity_m_s2,
        };
        if missing.is_empty() { Ok(rows) } else { Err(NotReplayable::Missing(missing.join(", "))) }
    }

    fn len(&self) -> usize {
        self.angle_rad[0].len()
    }

    /// Body rates. A gimbal turns about z by no more than its pitch axis is tilted.
    fn gyro_rad_s(&self, row: usize) -> [f64; 3] {
        let [p, q] = self.rate_rad_s.map(|rate| rate[row]);
        let r = self.yaw_rate_rad_s.map_or_else(|| -q * libm::tan(self.angle_rad[0][row]), |rate| rate[row]);
        [p, q, r]
    }

    fn specific_force_m_s2(&self, row: usize) -> [f64; 3] {
        let gravity = || self.gravity_in_body_m_s2(self.angle_rad.map(|angle| angle[row]));
        self.force_m_s2.map_or_else(gravity, |force| force.map(|axis| axis[row]))
    }

    /// What the accelerometer of a vehicle at rest reads.
    fn gravity_in_body_m_s2(&self, [roll_rad, pitch_rad]: [f64; 2]) -> [f64; 3] {
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (libm::sincos(roll_rad), libm::sincos(pitch_rad));
        [sin_pitch, -cos_pitch * sin_roll, -cos_pitch * cos_roll].map(|share| share * self.gravity_m_s2)
    }

    /// Attitude at the start and the gyro's bias: level and slope of what the angles are beyond the integrated rates.
    fn at_rest(&self) -> AtRest {
        let mut at_rest = AtRest { angle_rad: [0.0; 2], gyro_bias_rad_s: [0.0; 2] };
        // a tilted vehicle shows less of its bias; what the first pass leaves of it, the others find
        for _ in 0..BIAS_PASSES {
            let beyond = self.beyond_rates(&at_rest);
            let first = ((START_S / self.period_s) as usize).clamp(1, beyond.len());
            at_rest.angle_rad = [0, 1].map(|axis| beyond[..first].iter().map(|b| b[axis]).sum::<f64>() / first as f64);
            for (axis, bias) in at_rest.gyro_bias_rad_s.iter_mut().enumerate() {
                *bias -= slope(beyond.iter().map(|b| b[axis])) / self.period_s;
            }
        }
        at_rest
    }

    /// Logged angles less the integrated rates, roll and pitch, rad.
    fn beyond_rates(&self, at_rest: &AtRest) -> Vec<[f64; 2]> {
        let mut turned_rad = [0.0; 2];
        let row_of = |row| {
            let [p, q, r] = self.gyro_rad_s(row);
            let (p, q) = (p - at_rest.gyro_bias_rad_s[0], q - at_rest.gyro_bias_rad_s[1]);
            let [roll, pitch] = self.angle_rad.map(|angle| angle[row]);
            let ((sin, cos), tan) = (libm::sincos(roll), libm::tan(pitch));
            let before = turned_rad;
            turned_rad[0] += (p + (q * sin + r * cos) * tan) * self.period_s;
            turned_rad[1] += (q * cos - r * sin) * self.period_s;
            [roll - before[0], pitch - before[1]]
        };
        (0..self.len()).map(row_of).collect()
    }

    /// The samples of a row's step: interpolated from the row before to this one.
    fn samples(&self, row: usize, first: usize, at_rest: &AtRest, parameters: &DesignParameters) -> ImuBatch {
        let before = |now: [f64; 3], of: &dyn Fn(usize) -> [f64; 3]| if row == 0 { now } else { of(row - 1) };
        let gyro = self.gyro_rad_s(row);
        let gyro_before = if row == 0 { at_rest.gyro_rad_s() } else { before(gyro, &|row| self.gyro_rad_s(row)) };
        let force = self.specific_force_m_s2(row);
        let force_before = before(force, &|row| self.specific_force_m_s2(row));
        let per_step = samples_per_step(parameters);
        (1..=per_step)
            .map(|sample| {
                let share = sample as f64 / per_step as f64;
                let between = |from: [f64; 3], to: [f64; 3]| [0, 1, 2].map(|i| from[i] + share * (to[i] - from[i]));
                let time_us = tick_us((first + row - 1) * per_step + sample, parameters.imu_rate_hz);
                imu::quantise(time_us, between(gyro_before, gyro), between(force_before, force))
            })
            .collect()
    }
}

/// The vehicle before the log begins.
struct AtRest {
    angle_rad: [f64; 2],
    gyro_bias_rad_s: [f64; 2],
}

impl AtRest {
    fn gyro_rad_s(&self) -> [f64; 3] {
        [self.gyro_bias_rad_s[0], self.gyro_bias_rad_s[1], 0.0]
    }
}

/// Least-squares slope of a series over its index.
fn slope(series: impl ExactSizeIterator<Item = f64>) -> f64 {
    let middle = (series.len() as f64 - 1.0) / 2.0;
    let (mut product, mut square) = (0.0, 0.0);
    for (index, value) in series.enumerate() {
        let from_middle = index as f64 - middle;
        product += from_middle * value;
        square += from_middle * from_middle;
    }
    if square > 0.0 { product / square } else { 0.0 }
}

fn samples_per_step(parameters: &DesignParameters) -> usize {
    (parameters.imu_rate_hz / parameters.control_rate_hz.max(1)) as usize
}

/// As [`crate::cosim::clock::Clock`] has it.
fn tick_us(tick: usize, rate_hz: u32) -> u64 {
    let rate_hz = u64::from(rate_hz.max(1));
    (tick as u64 * 1_000_000 + rate_hz / 2) / rate_hz
}

/// At rest, armed, then hovering in the rig's hands, as [`crate::cosim`] begins a flight.
fn held_steps(rows: &Rows<'_>, at_rest: &AtRest, parameters: &DesignParameters) -> Vec<Step> {
    let [roll_rad, pitch_rad] = rows.reference_rad.map(|reference| reference[0]);
    let waypoint = Waypoint { roll_rad, pitch_rad, ..Waypoint::level(0.0) };
    let scenario = Scenario { name: String::new(), duration_s: 0.0, waypoints: vec![waypoint] };
    let (gyro, force) = (at_rest.gyro_rad_s(), rows.gravity_in_body_m_s2(at_rest.angle_rad));
    let per_step = samples_per_step(parameters);
    let mut steps = Vec::new();
    loop {
        let step = steps.len();
        let time_us = tick_us(step, parameters.control_rate_hz);
        if time_us >= HELD_US {
            return steps;
        }
        let first = if step == 0 { 0 } else { (step - 1) * per_step + 1 };
        let samples = first..=step * per_step;
        let imu = samples.map(|sample| imu::quantise(tick_us(sample, parameters.imu_rate_hz), gyro, force)).collect();
        let events = events_at(&scenario, parameters, time_us);
        steps.push(Step { time_us, imu, setpoint: events.setpoint, arming: events.arming, flown: None });
    }
}

/// Torque and mean lift (N) of four commands, by the controllers' lift curve.
fn flown(mixer: &MixerConfig, commands: [f64; 4]) -> (Flown, f32) {
    let lifts_n = commands.map(|command| mixer.lift_curve.lift(command as f32));
    let [roll_n, pitch_n, yaw_n] = signed_sums(lifts_n);
    let torque_body_nm = [mixer.lever_m * roll_n, mixer.lever_m * pitch_n, mixer.torque_per_lift_m * yaw_n];
    let saturated = commands.iter().any(|command| *command <= 0.0 || *command >= 1.0);
    (Flown { torque_body_nm, saturated }, 0.25 * lifts_n.into_iter().sum::<f32>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control_setup::vehicle_parameters;
    use crate::controller_file::ControllerChoice;
    use crate::diagnosis::controller::parameters::Numbers;
    use crate::diagnosis::controller::replay::Design;
    use crate::effects::Effect;
    use crate::flight::FlightSetup;
    use crate::flight_log::flight_log;
    use crate::model::{Rig, SensorNoise, VehicleModel};
    use shared_control::config::Controller;

    /// A log of five seconds, and the controller that flew it.
    fn flown(controller: Controller, effect: Option<&str>, is_noisy: bool) -> (Log, Design, Numbers) {
        let mut model = VehicleModel::nominal(Rig::Gimbal);
        model.effects.extend(effect.map(|text| Effect::parse(text, Rig::Gimbal).unwrap()));
        if !is_noisy {
            model.noise = SensorNoise::NONE;
        }
        let choice = ControllerChoice::nominal(controller);
        let scenario = Scenario { duration_s: 5.0, ..Scenario::test_sequence() };
        let setup = FlightSetup { model, controller_model: None, choice, scenario, seed: 4 };
        let log = flight_log(&setup.fly().unwrap().record, choice.rate_hz);
        let vehicle = vehicle_parameters(&setup.known_model());
        let design = Design { vehicle, clocks: setup.design_parameters(), controller };
        (log, design, Numbers { tuning: setup.tuning(), control_horizon: choice.control_horizon })
    }

    fn steps_of(log: &Log, design: &Design, numbers: &Numbers) -> Result<Vec<Step>, NotReplayable> {
        steps(log, &design.config(numbers).unwrap(), &design.clocks)
    }

    /// Without noise nothing is lost between the rows but the counts' rounding: a replay repeats the commands to a
    /// thousandth of what the manoeuvres demand (tens of rad/s^2), whatever the plant did.
    #[test]
    fn a_replay_repeats_the_commands() {
        for controller in [Controller::Cascade, Controller::Mpc] {
            for effect in [None, Some("cg_offset:axis=pitch,cos_moment_nm=0.1")] {
                let (log, design, numbers) = flown(controller, effect, false);
                let steps = steps_of(&log, &design, &numbers).unwrap();
                for axis in design.residual(&steps, &numbers).unwrap() {
                    let rms = (axis.iter().map(|value| value * value).sum::<f64>() / axis.len() as f64).sqrt();
                    assert!(rms < 0.03, "{controller:?} {effect:?}: {rms} rad/s^2");
                }
            }
        }
    }

    #[test]
    fn bias_and_attitude_at_the_start_come_from_the_angles() {
        let bias = Some("gyro_bias:axis=pitch,bias_rad_s=0.03");
        let (log, design, _) = flown(Controller::Cascade, bias, true);
        let at_rest = Rows::of(&log, &design.clocks).unwrap().at_rest();
        // angles to 0.002 rad, integrated noise of the gyro to 0.001 rad over five seconds
        assert!((at_rest.gyro_bias_rad_s[1] - 0.03).abs() < 1e-3 && at_rest.gyro_bias_rad_s[0].abs() < 1e-3);
        assert!(at_rest.angle_rad.iter().all(|angle| angle.abs() < 1e-3), "{:?}", at_rest.angle_rad);
    }

    #[test]
    fn what_cannot_be_replayed_is_said() {
        let (log, mut design, numbers) = flown(Controller::Cascade, None, true);
        let refusal = |log: &Log, design: &Design| steps_of(log, design, &numbers).unwrap_err().to_string();
        let mut holed = log.clone();
        holed.time_s.iter_mut().skip(800).for_each(|time_s| *time_s += 0.0025);
        assert!(refusal(&holed, &design).contains("missing or late at 2.0025 s"), "{}", refusal(&holed, &design));
        let mut bare = log.clone();
        (bare.motor_command[2], bare.reference_rad[0]) = (None, None);
        assert_eq!(refusal(&bare, &design), "the log lacks roll_ref_rad, motor3");
        design.clocks = DesignParameters::new(9.81, 0.5, 100);
        assert!(refusal(&log, &design).contains("400 rows a second and the controller runs at 100"));
    }
}
