//! A measured log against the simulation: in closed loop (the thesis' table 5.1) and in open-loop replay.

use serde::Serialize;

use crate::control_setup::command_for_lift;
use crate::controller_file::ControllerChoice;
use crate::cosim::{self, record::FlightRecord};
use crate::fidelity::{FidelityError, PredictionError, Replay, ReplayOptions, replay_axes, replay_plant};
use crate::flight::{FlightSetup, SetupError};
use crate::log::Log;
use crate::model::VehicleModel;
use crate::plant::Plant;
use crate::scenario::{DURATION_MAX_S, Scenario, Waypoint};
use crate::sensors::Sensors;
use crate::statistics::mean_absolute_deviation;

/// What the log is held against.
#[derive(Clone, Debug)]
pub enum Subject {
    /// Each axis a rigid body of unit inertia with one input gain, for foreign benches.
    Axes,
    /// A vehicle on its rig.
    Vehicle(Box<Vehicle>),
}

/// A vehicle model, and what flew it.
#[derive(Clone, Debug)]
pub struct Vehicle {
    /// The model.
    pub model: VehicleModel,
    /// What flew, if it is known; only then is there a closed loop to simulate.
    pub controller: Option<ControllerChoice>,
}

/// The result of holding a log against the simulation.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Simulated closed loop against measured; none without a controller or references.
    pub closed_loop: Option<ClosedLoop>,
    /// Open-loop replay of the logged commands, window by window.
    pub replay: Replay,
    /// What a reader should know of the closed loop: why there is none.
    pub notes: Vec<String>,
}

/// The simulated closed loop beside the measured one, at the log's rows.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// Simulated angles (roll, pitch), rad.
    pub simulated_rad: [Vec<f64>; 2],
    /// Mean absolute deviations.
    pub deviation: ClosedLoopDeviation,
}

/// `closed_loop` of the JSON of `sil compare`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClosedLoopDeviation {
    /// Mean |simulated - measured| of roll, degrees.
    pub roll_mean_abs_deg: f64,
    /// The same of pitch.
    pub pitch_mean_abs_deg: f64,
}

/// What `sil compare --json` writes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ComparisonSummary {
    /// The thesis' table 5.1.
    pub closed_loop: Option<ClosedLoopDeviation>,
    /// Of the open-loop replay.
    pub prediction_error: PredictionError,
}

/// A comparison that can't be made.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// The log does not allow it.
    #[error(transparent)]
    Fidelity(#[from] FidelityError),
    /// The controller does not.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// Its closed loop would be simulated for ages, gaps in time included.
    #[error(
        "time_s spans {duration_s} s; the closed loop is simulated for up to {DURATION_MAX_S} s (leave out --controller)"
    )]
    TooLong {
        /// From the log's first row to its last, s.
        duration_s: f64,
    },
}

impl Comparison {
    /// The figures alone.
    pub fn summary(&self) -> ComparisonSummary {
        ComparisonSummary {
            closed_loop: self.closed_loop.as_ref().map(|closed_loop| closed_loop.deviation),
            prediction_error: self.replay.prediction_error(),
        }
    }
}

/// Holds a log against the simulation.
///
/// # Errors
/// [`ComparisonError`]: a column that the subject needs is missing, no window is long enough, the controller can't fly.
pub fn compare(log: &Log, subject: &Subject) -> Result<Comparison, ComparisonError> {
    match subject {
        Subject::Axes => {
            let replay = replay_axes(log, &ReplayOptions::default())?;
            Ok(Comparison { closed_loop: None, replay, notes: Vec::new() })
        }
        Subject::Vehicle(vehicle) => {
            let Vehicle { model, controller } = vehicle.as_ref();
            let options = ReplayOptions { control_rate_hz: controller.map(|choice| f64::from(choice.rate_hz)) };
            // first the replay: it refuses a log whose time is in another unit, which would be simulated for hours
            let replay = replay_plant(log, model, &options)?;
            let closed_loop = match controller {
                Some(choice) => closed_loop(log, model, *choice)?,
                None => None,
            };
            let notes = match (controller, &closed_loop) {
                (Some(_), None) => vec![format!("no closed loop: the log lacks {}", missing_for_closed_loop(log))],
                _ => Vec::new(),
            };
            Ok(Comparison { closed_loop, replay, notes })
        }
    }
}

/// The columns without which there is no closed loop to compare.
pub(crate) fn missing_for_closed_loop(log: &Log) -> String {
    let needed = [
        ("roll_rad", &log.angle_rad[0]),
        ("pitch_rad", &log.angle_rad[1]),
        ("roll_ref_rad", &log.reference_rad[0]),
        ("pitch_ref_rad", &log.reference_rad[1]),
    ];
    let missing: Vec<&str> = needed.iter().filter(|(_, column)| column.is_none()).map(|(name, _)| *name).collect();
    missing.join(", ")
}

/// Simulates the closed loop on the log's references from the log's first attitude, without sensor noise; gives the flight's
/// set-up too. None where the log lacks attitude or references.
///
/// # Errors
/// [`ComparisonError`]: the log is too long, the controller can't fly.
pub(crate) fn simulated_flight(
    log: &Log,
    model: &VehicleModel,
    choice: ControllerChoice,
) -> Result<Option<(FlightSetup, FlightRecord)>, ComparisonError> {
    let (Some(measured_roll), Some(measured_pitch)) = (&log.angle_rad[0], &log.angle_rad[1]) else { return Ok(None) };
    let Some(scenario) = reference_scenario(log) else { return Ok(None) };
    if scenario.duration_s > DURATION_MAX_S {
        return Err(ComparisonError::TooLong { duration_s: log.duration_s() });
    }
    let mut model = model.clone();
    if let Some(throttle) = usual_throttle(log, &model) {
        model.base_command = throttle;
    }
    let setup = FlightSetup { model, controller_model: None, choice, scenario, seed: 0 };
    let mut control = setup.control_side()?;
    let mut plant = Plant::new(&setup.model);
    plant.set_attitude([measured_roll[0], measured_pitch[0], 0.0], [0.0; 3]);
    let parameters = setup.design_parameters();
    let mut sensors = Sensors::ideal().with_effects(&setup.model.effects);
    let record = cosim::fly(&parameters, &mut plant, &mut sensors, &mut control, &setup.scenario, None);
    Ok(Some((setup, record)))
}

/// The simulated closed loop at the log's rows.
pub(crate) fn closed_loop(
    log: &Log,
    model: &VehicleModel,
    choice: ControllerChoice,
) -> Result<Option<ClosedLoop>, ComparisonError> {
    let (Some(measured_roll), Some(measured_pitch)) = (&log.angle_rad[0], &log.angle_rad[1]) else { return Ok(None) };
    let Some((_, record)) = simulated_flight(log, model, choice)? else { return Ok(None) };
    let row_times: Vec<f64> = log.time_s.iter().map(|time| time - log.time_s[0]).collect();
    let simulated_rad = [0, 1].map(|axis| at_times(&row_times, &record.time_s, &record.angle_of(axis)));
    let deviation_deg = |axis: usize, measured: &[f64]| {
        mean_absolute_deviation(&simulated_rad[axis], measured).map_or(f64::NAN, f64::to_degrees)
    };
    let deviation = ClosedLoopDeviation {
        roll_mean_abs_deg: deviation_deg(0, measured_roll),
        pitch_mean_abs_deg: deviation_deg(1, measured_pitch),
    };
    Ok(Some(ClosedLoop { simulated_rad, deviation }))
}

/// The log's references as a scenario from time zero; none if it has none.
fn reference_scenario(log: &Log) -> Option<Scenario> {
    let (roll, pitch) = (log.reference_rad[0].as_ref()?, log.reference_rad[1].as_ref()?);
    let start_s = *log.time_s.first()?;
    let changed = |row: &usize| *row == 0 || roll[*row] != roll[row - 1] || pitch[*row] != pitch[row - 1];
    let waypoints = (0..log.rows())
        .filter(changed)
        .map(|row| Waypoint {
            roll_rad: roll[row],
            pitch_rad: pitch[row],
            ..Waypoint::level(log.time_s[row] - start_s)
        })
        .collect();
    // one step more, so that the last row lies inside
    let duration_s = log.duration_s() + log.median_step_s();
    Some(Scenario { name: "the log's references".into(), duration_s, waypoints })
}

/// Collective that flew most of the time: the command of the median of the motors' mean lift.
fn usual_throttle(log: &Log, model: &VehicleModel) -> Option<f64> {
    let motors = log.motors()?;
    let lift_n = |command: f64| model.propulsion.equilibrium(command.clamp(0.0, 1.0)).lift_n;
    let mut mean_lifts: Vec<f64> =
        (0..log.rows()).map(|row| motors.iter().map(|motor| lift_n(motor[row])).sum::<f64>() / 4.0).collect();
    mean_lifts.sort_by(f64::total_cmp);
    let wanted_n = *mean_lifts.get(mean_lifts.len() / 2)?;
    Some(command_for_lift(model, wanted_n))
}

/// A series at other times, linear in between, held at its ends.
fn at_times(wanted_s: &[f64], time_s: &[f64], values: &[f64]) -> Vec<f64> {
    wanted_s
        .iter()
        .map(|&wanted| {
            let after = time_s.partition_point(|&time| time < wanted);
            match (after.checked_sub(1), values.get(after)) {
                (Some(before), Some(&next)) => {
                    let share = (wanted - time_s[before]) / (time_s[after] - time_s[before]);
                    values[before] + share * (next - values[before])
                }
                (None, Some(&first)) => first,
                (_, None) => values.last().copied().unwrap_or(f64::NAN),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{BatterySag, BatterySagLaw, Effect};
    use crate::model::Rig;
    use crate::synthesis::Synthesis;
    use shared_control::config::Controller;

    fn log_of(choice: ControllerChoice, effect: Option<&str>, throttle: f64) -> Log {
        let mut model = VehicleModel::nominal(Rig::Gimbal);
        model.effects.extend(effect.map(|text| Effect::parse(text, Rig::Gimbal).unwrap()));
        Synthesis { choice, throttle: Some(throttle), seed: 11, ..Synthesis::of(model) }.log().unwrap()
    }

    fn nominal(choice: ControllerChoice) -> Subject {
        Subject::Vehicle(Box::new(Vehicle { model: VehicleModel::nominal(Rig::Gimbal), controller: Some(choice) }))
    }

    /// What is left between the same flight with and without noise is the log's noise (0.002 rad: a mean |x| of 0.09
    /// degrees) and the estimator's drift with the gyro noise (a tenth of a degree).
    #[test]
    fn a_nominal_log_deviates_by_its_noise_only() {
        let cascade = ControllerChoice::nominal(Controller::Cascade);
        let comparison = compare(&log_of(cascade, None, 0.45), &nominal(cascade)).unwrap();
        let closed_loop = comparison.closed_loop.unwrap().deviation;
        assert!(closed_loop.roll_mean_abs_deg < 0.2 && closed_loop.pitch_mean_abs_deg < 0.2, "{closed_loop:?}");
        let error = comparison.replay.prediction_error();
        let ratio = error.nominal.pitch_deg.unwrap() / error.noise_floor.pitch_deg.unwrap();
        assert!((0.85..1.15).contains(&ratio), "nominal over noise floor: {ratio}");
    }

    /// Under the thesis' MPC, which estimates no disturbance.
    #[test]
    fn an_off_balance_ring_shows_in_the_pitch_of_both() {
        let thesis =
            ControllerChoice::parse(include_str!("../demonstration/thesis-mpc.toml"), "thesis-mpc.toml").unwrap();
        let ring = Some("cg_offset:axis=pitch,cos_moment_nm=0.1");
        let comparison = compare(&log_of(thesis, ring, 0.5), &nominal(thesis)).unwrap();
        let deviation = comparison.closed_loop.as_ref().unwrap().deviation;
        assert!(deviation.pitch_mean_abs_deg > 5.0 * deviation.roll_mean_abs_deg, "{deviation:?}");
        let error = comparison.replay.prediction_error();
        assert!(error.nominal.pitch_deg.unwrap() > 3.0 * error.noise_floor.pitch_deg.unwrap());
        // roll is not quite free of it: a wrong pitch rate enters it through J'(phi)
        assert!(error.nominal.roll_deg.unwrap() < 0.1 * error.nominal.pitch_deg.unwrap());
    }

    /// A log with effects of plant, actuators and environment, some of them of time, held against the model that has them:
    /// the replay misses by the noise floor, where the nominal model misses by much more.
    #[test]
    fn an_extended_model_explains_the_log_of_its_effects() {
        for effects in [
            &["spring:axis=roll,stiffness_nm_rad=0.05", "viscous_friction:axis=pitch,coefficient_nms=0.02"][..],
            &["step_disturbance:axis=pitch,torque_nm=0.03,start_s=7.3"],
            &["periodic_disturbance:axis=roll,amplitude_nm=0.03,frequency_hz=1.7,phase_rad=1"],
            &["actuation_delay:delay_s=0.013", "motor_lag:time_constant_s=0.02"],
            &["battery_sag:per_volt=0.3,fall_v_s=0.05"],
            &["battery_sag:per_s=0.01", "weak_motor:motor=4,scale=0.96"],
            &["inertia_error:axis=pitch,scale=1.3", "inertia_coupling:product_kg_m2=0.003"],
        ] {
            let mut model = VehicleModel::nominal(Rig::Gimbal);
            model.effects = effects.iter().map(|short| Effect::parse(short, Rig::Gimbal).unwrap()).collect();
            let log = Synthesis { log_rate_hz: 400, duration_s: 15.0, seed: 5, ..Synthesis::of(model.clone()) }
                .log()
                .unwrap();
            // a measured battery takes the place of the simulated one
            for effect in &mut model.effects {
                if let Effect::BatterySag(BatterySag { law: BatterySagLaw::Voltage { fall_v_s, .. } }) = effect {
                    *fall_v_s = 0.0;
                }
            }
            let ratios = |model: VehicleModel| {
                let subject = Subject::Vehicle(Box::new(Vehicle { model, controller: None }));
                let error = compare(&log, &subject).unwrap().replay.prediction_error();
                [
                    error.nominal.p_deg_s.unwrap() / error.noise_floor.p_deg_s.unwrap(),
                    error.nominal.q_deg_s.unwrap() / error.noise_floor.q_deg_s.unwrap(),
                ]
            };
            let (extended, nominal) = (ratios(model), ratios(VehicleModel::nominal(Rig::Gimbal)));
            // the share that a finite log leaves to chance
            assert!(extended.iter().all(|ratio| (0.9..1.1).contains(ratio)), "{effects:?}: {extended:?}");
            assert!(nominal.iter().any(|ratio| *ratio > 1.5), "{effects:?}: nominal {nominal:?}");
        }
    }

    #[test]
    fn usual_throttle_is_the_one_that_flew() {
        let model = VehicleModel::nominal(Rig::Gimbal);
        // half of the time the vehicle is turning, and the collective gives way where a motor saturates
        assert!(
            (usual_throttle(&log_of(ControllerChoice::nominal(Controller::Cascade), None, 0.42), &model).unwrap()
                - 0.42)
                .abs()
                < 0.005
        );
    }

    #[test]
    fn series_are_interpolated_and_held_at_the_ends() {
        let out = at_times(&[-1.0, 0.5, 2.0, 9.0], &[0.0, 1.0, 2.0], &[1.0, 3.0, 5.0]);
        assert_eq!(out, [1.0, 2.0, 5.0, 5.0]);
        assert!(at_times(&[0.0], &[], &[])[0].is_nan());
    }
}
