//! The closed loop of a logged flight, simulated on the log's references beside the measured one (the thesis' table
//! 5.1).

use serde::Serialize;

use crate::control_setup::command_for_lift;
use crate::controller_file::ControllerChoice;
use crate::cosim::{self, record::FlightRecord};
use crate::flight::{FlightSetup, SetupError};
use crate::log::Log;
use crate::model::VehicleModel;
use crate::plant::Plant;
use crate::prediction::NotPredictable;
use crate::scenario::{DURATION_MAX_S, Scenario, Waypoint};
use crate::sensors::Sensors;
use crate::statistics::{mean_absolute_deviation, median};

/// A log that can't be held against the simulation.
#[derive(Debug, thiserror::Error)]
pub enum LogRefused {
    /// The log does not allow it.
    #[error(transparent)]
    NotPredictable(#[from] NotPredictable),
    /// The controller does not.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// Its closed loop would be simulated for ages, gaps in time included.
    #[error(
        "time_s spans {duration_s} s; the closed loop is simulated for up to {DURATION_MAX_S} s \
         (leave out --controller)"
    )]
    TooLong {
        /// From the log's first row to its last, s.
        duration_s: f64,
    },
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

/// Simulates the closed loop on the log's references from the log's first attitude, without sensor noise; gives the
/// flight's set-up too. None where the log lacks attitude or references.
///
/// # Errors
/// [`LogRefused`]: the log is too long, the controller can't fly.
pub(crate) fn simulated_flight(
    log: &Log,
    model: &VehicleModel,
    choice: ControllerChoice,
) -> Result<Option<(FlightSetup, FlightRecord)>, LogRefused> {
    let (Some(measured_roll), Some(measured_pitch)) = (&log.angle_rad[0], &log.angle_rad[1]) else { return Ok(None) };
    let Some(scenario) = reference_scenario(log) else { return Ok(None) };
    if scenario.duration_s > DURATION_MAX_S {
        return Err(LogRefused::TooLong { duration_s: log.duration_s() });
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
) -> Result<Option<ClosedLoop>, LogRefused> {
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
    let mean_lift_n = |row: usize| motors.iter().map(|motor| lift_n(motor[row])).sum::<f64>() / 4.0;
    Some(command_for_lift(model, median((0..log.rows()).map(mean_lift_n).collect())))
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
    use crate::model::Rig;
    use crate::synthesis::Synthesis;
    use shared_control::config::Controller;

    #[test]
    fn usual_throttle_is_the_one_that_flew() {
        let model = VehicleModel::nominal(Rig::Gimbal);
        // half of the time the vehicle is turning, and the collective gives way where a motor saturates
        let choice = ControllerChoice::nominal(Controller::Cascade);
        let log = Synthesis { choice, throttle: Some(0.42), seed: 11, ..Synthesis::of(model.clone()) }.log().unwrap();
        assert!((usual_throttle(&log, &model).unwrap() - 0.42).abs() < 0.005);
    }

    #[test]
    fn series_are_interpolated_and_held_at_the_ends() {
        let out = at_times(&[-1.0, 0.5, 2.0, 9.0], &[0.0, 1.0, 2.0], &[1.0, 3.0, 5.0]);
        assert_eq!(out, [1.0, 2.0, 5.0, 5.0]);
        assert!(at_times(&[0.0], &[], &[])[0].is_nan());
    }
}
