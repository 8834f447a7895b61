//! A simulated flight as the log that a logger on board would have written, and rig logs with chosen effects.

use crate::controller_file::ControllerChoice;
use crate::cosim::{self, clock::Clock, record::FlightRecord};
use crate::flight::{FlightSetup, SetupError};
use crate::log::{Column, Log};
use crate::model::{SensorNoise, VehicleModel};
use crate::plant::Plant;
use crate::scenario::{Scenario, Waypoint};

/// Values are written in steps of this (rad, rad/s, ...): a hundredth of the finest sensor's, and short to read.
const RESOLUTION: f64 = 1e-6;

/// A rig log to be made.
#[derive(Clone, Debug)]
pub struct SynthesisSetup {
    /// Vehicle and rig, the effects in it.
    pub model: VehicleModel,
    /// What flies it.
    pub choice: ControllerChoice,
    /// Length, s; the test sequence is cut or repeated to fill it.
    pub duration_s: f64,
    /// Rows per second, at most the controller's rate.
    pub log_rate_hz: u32,
    /// Collective command; the model's base command where none is given.
    pub throttle: Option<f64>,
    /// Noise of attitude and gyro; the model's where none is given.
    pub noise: Option<SensorNoise>,
    /// Seed of the noise.
    pub seed: u64,
}

/// Flies the set-up and gives its log. The first comment says that it is synthetic.
///
/// # Errors
/// [`SetupError`] where the configuration can't be flown.
pub fn synthesise(setup: &SynthesisSetup) -> Result<Log, SetupError> {
    let mut model = setup.model.clone();
    if let Some(noise) = setup.noise {
        model.noise = noise;
    }
    if let Some(throttle) = setup.throttle {
        model.base_command = throttle;
    }
    let scenario = repeated(&Scenario::test_sequence(), setup.duration_s);
    let flight = FlightSetup { model, choice: setup.choice, scenario, seed: setup.seed };
    let mut control = flight.control_side()?;
    let mut plant = Plant::new(&flight.model);
    let mut sensors = flight.sensors();
    let parameters = flight.design_parameters();
    let record = cosim::fly(&parameters, &mut plant, &mut sensors, &mut control, &flight.scenario, None);
    let mut log = flight_log(&record, setup.log_rate_hz);
    log.comments = synthetic_comments(setup, &flight);
    Ok(log)
}

fn synthetic_comments(setup: &SynthesisSetup, flight: &FlightSetup) -> Vec<String> {
    let effects: Vec<String> = setup
        .model
        .effects
        .iter()
        .map(|effect| {
            let parameters: Vec<String> =
                effect.parameters().iter().map(|(name, value)| format!("{name}={value}")).collect();
            let axis = effect.axis().map_or(String::new(), |axis| format!("axis={},", axis.name()));
            format!("{}:{axis}{}", effect.name(), parameters.join(","))
        })
        .collect();
    let effects = if effects.is_empty() { "none".to_owned() } else { effects.join("; ") };
    vec![
        "SYNTHETIC: made by a simulation (sil synth), measured nowhere".to_owned(),
        format!("model: {}; effects: {effects}", flight.model.name),
        format!(
            "controller: {} at {} Hz; log rate {} Hz; seed {}",
            setup.choice.name(),
            setup.choice.rate_hz,
            setup.log_rate_hz,
            setup.seed
        ),
    ]
}

/// The log of a recorded flight: the rows of a logger at `log_rate_hz`, each taken at the first control step at or
/// after its time, so that its commands are in force until the next.
pub fn flight_log(record: &FlightRecord, log_rate_hz: u32) -> Log {
    let mut clock = Clock::new(log_rate_hz);
    let rows: Vec<usize> = (0..record.len())
        .filter(|&i| {
            let due = clock.tick((record.time_s[i] * 1e6).round() as u64);
            // a logger that was late takes the next row on time again
            while due && clock.next_us() as f64 <= record.time_s[i] * 1e6 {
                clock.tick(clock.next_us());
            }
            due
        })
        .collect();
    let column = |value: &dyn Fn(usize) -> f64| -> Column { Some(rows.iter().map(|&i| rounded(value(i))).collect()) };
    Log {
        axes: [true, true, false],
        time_s: rows.iter().map(|&i| rounded(record.time_s[i])).collect(),
        angle_rad: core::array::from_fn(|axis| column(&|i| record.logged_angle_rad[i][axis])),
        rate_rad_s: core::array::from_fn(|axis| column(&|i| record.logged_rate_body_rad_s[i][axis])),
        motor_command: core::array::from_fn(|motor| column(&|i| record.commands[i][motor])),
        reference_rad: [column(&|i| record.reference_rad[i][0]), column(&|i| record.reference_rad[i][1]), None],
        accel_body_m_s2: core::array::from_fn(|axis| column(&|i| record.logged_force_m_s2[i][axis])),
        ..Log::default()
    }
}

fn rounded(value: f64) -> f64 {
    // dividing by the inverse, not multiplying by the resolution, gives the double nearest to the decimal
    (value / RESOLUTION).round() / (1.0 / RESOLUTION)
}

/// A scenario cut, or repeated end to end, to a duration.
fn repeated(scenario: &Scenario, duration_s: f64) -> Scenario {
    let repeats = (duration_s / scenario.duration_s).ceil().max(1.0) as usize;
    let waypoints = (0..repeats)
        .flat_map(|k| {
            let shift_s = k as f64 * scenario.duration_s;
            scenario.waypoints.iter().map(move |&waypoint| Waypoint { start_s: waypoint.start_s + shift_s, ..waypoint })
        })
        .filter(|waypoint| waypoint.start_s < duration_s)
        .collect();
    Scenario { name: scenario.name.clone(), duration_s, waypoints }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Rig;
    use shared_control::config::Controller;

    fn setup(log_rate_hz: u32, control_rate_hz: u32) -> SynthesisSetup {
        let choice = ControllerChoice { rate_hz: control_rate_hz, ..ControllerChoice::nominal(Controller::Cascade) };
        SynthesisSetup {
            model: VehicleModel::nominal(Rig::Gimbal),
            choice,
            duration_s: 4.0,
            log_rate_hz,
            throttle: None,
            noise: None,
            seed: 7,
        }
    }

    #[test]
    fn rows_come_at_the_logs_rate_and_hold_the_command_in_force() {
        for (log_rate, control_rate) in [(400, 400), (100, 400), (150, 400), (100, 100)] {
            let log = synthesise(&setup(log_rate, control_rate)).unwrap();
            assert_eq!(log.rows(), 4 * log_rate as usize, "{log_rate} of {control_rate}");
            assert!(log.time_s.windows(2).all(|t| t[1] > t[0]));
            assert!(log.comments[0].starts_with("SYNTHETIC"));
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
        let bytes = |seed| {
            let mut out = Vec::new();
            crate::log::write(&synthesise(&SynthesisSetup { seed, ..setup(200, 400) }).unwrap(), &mut out).unwrap();
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
}
