//! Rig logs with chosen effects, noise, rates, jitter and missing rows: for tests of what reads logs, and for learning.
//!
//! The plant is integrated by another method than that of ordinary flights (Dormand-Prince 5(4) in place of Runge-Kutta
//! 4) and much more finely, so that a log shows what is true of the vehicle and not how it was computed.

use crate::controller_file::ControllerChoice;
use crate::cosim::{self, record::FlightRecord};
use crate::effects::{BatterySag, BatterySagLaw, Effect};
use crate::flight::{FlightSetup, SetupError};
use crate::flight_log::{log_of_rows, rounded, rows_at_rate};
use crate::log::Log;
use crate::model::{SensorNoise, VehicleModel};
use crate::plant::{Plant, Truth};
use crate::scenario::{Scenario, Waypoint};
use crate::sensors::{Sensors, random::RandomStream};
use shared_control::config::Controller;

/// Error allowed in a step of the integrator, relative to the state or to one.
pub(crate) const TOLERANCE: f64 = 1e-9;

/// Latest that a row is written, as a share of the time from row to row: time must increase.
const JITTER_MAX_SHARE: f64 = 0.9;

/// A rig log to be made.
#[derive(Clone, Debug)]
pub struct Synthesis {
    /// Vehicle and rig, the effects in it.
    pub model: VehicleModel,
    /// What flies it.
    pub choice: ControllerChoice,
    /// What is flown; cut, or repeated end to end, to the duration.
    pub scenario: Scenario,
    /// Length, s.
    pub duration_s: f64,
    /// Rows per second, at most the controller's rate.
    pub log_rate_hz: u32,
    /// Collective command; the model's base command where none is given.
    pub throttle: Option<f64>,
    /// Noise of attitude and gyro; the model's where none is given.
    pub noise: Option<SensorNoise>,
    /// By how much rows are late, s: |N(0, jitter)|, at most 0.9 of the time from row to row. What is logged is the
    /// state at the late time.
    pub jitter_s: f64,
    /// Share of the rows that are missing, each by chance.
    pub drop_out_share: f64,
    /// Logs the battery's voltage even where no effect depends on it.
    pub battery: bool,
    /// Height of the rotors above ground at the start, m, in free flight; far from the ground where none is given.
    pub start_height_m: Option<f64>,
    /// Leaves all out of the log's comments but that it is synthetic.
    pub blind: bool,
    /// Seed of noise, jitter and drop-outs.
    pub seed: u64,
}

impl Synthesis {
    /// The test sequence under the cascade at 400 Hz, 200 rows a second, the model's noise, nothing missing.
    pub fn of(model: VehicleModel) -> Self {
        let scenario = Scenario::test_sequence();
        Self {
            model,
            choice: ControllerChoice::nominal(Controller::Cascade),
            duration_s: scenario.duration_s,
            scenario,
            log_rate_hz: 200,
            throttle: None,
            noise: None,
            jitter_s: 0.0,
            drop_out_share: 0.0,
            battery: false,
            start_height_m: None,
            blind: false,
            seed: 0,
        }
    }

    /// Flies it and gives its log. The first comment says that it is synthetic.
    ///
    /// # Errors
    /// [`SetupError`] where the configuration can't be flown.
    pub fn log(&self) -> Result<Log, SetupError> {
        let mut model = self.model.clone();
        model.noise = self.noise.unwrap_or(model.noise);
        model.base_command = self.throttle.unwrap_or(model.base_command);
        let scenario = repeated(&self.scenario, self.duration_s);
        let flight = FlightSetup { model, controller_model: None, choice: self.choice, scenario, seed: self.seed };
        let mut plant = Plant::new(&flight.model);
        plant.integrate_adaptively(TOLERANCE);
        if let Some(height_m) = self.start_height_m {
            plant.set_start_height_m(height_m);
        }
        let (record, rows) = if self.jitter_s > 0.0 {
            let record = self.fly_with_late_rows(&flight, &mut plant)?;
            let rows = (0..record.len()).collect();
            (record, rows)
        } else {
            let record = fly(&flight, &mut plant, &mut flight.sensors())?;
            let rows = rows_at_rate(&record, self.log_rate_hz);
            (record, rows)
        };
        let rows = self.without_drop_outs(rows);
        let mut log = log_of_rows(&record, &rows);
        if self.battery || model_has_battery(&flight.model) {
            let voltage = rows.iter().map(|&row| {
                plant.set_time_s(record.time_s[row]);
                rounded(plant.battery_v())
            });
            log.battery_v = Some(voltage.collect());
        }
        log.comments = self.comments(&flight);
        Ok(log)
    }

    /// Flies, and records rows at a logger's own, late times.
    fn fly_with_late_rows(&self, flight: &FlightSetup, plant: &mut Plant) -> Result<FlightRecord, SetupError> {
        let effects = &flight.model.effects;
        let mut logger = Sensors::new(&flight.model.noise, logger_seed(self.seed)).with_effects(effects);
        // attitude that is reported late is the logger's affair: the controller makes its own of the gyro
        let prompt: Vec<Effect> =
            effects.iter().filter(|effect| !matches!(effect, Effect::AttitudeDelay(_))).copied().collect();
        let mut sensors = Sensors::new(&flight.model.noise, self.seed).with_effects(&prompt);
        let delay_s = logger.attitude_delay_s();
        let times_s = self.late_times_s();
        plant.look_at(times_s.iter().flat_map(|time_s| [*time_s, (time_s - delay_s).max(0.0)]));
        let steps = fly(flight, plant, &mut sensors)?;
        let seen = plant.take_seen();
        let imu = flight.control_side()?.config().sensing.imu;
        let mut rows = FlightRecord::default();
        for time_s in times_s {
            let step = steps.time_s.partition_point(|step_s| *step_s <= time_s).saturating_sub(1);
            let (Some(now), Some(before)) = (seen_at(&seen, time_s), seen_at(&seen, (time_s - delay_s).max(0.0)))
            else {
                // the flight ended before this row
                break;
            };
            let sample = logger.imu_of(now);
            let (gyro, force) = (imu.gyro_rad_s(&sample), imu.specific_force_m_s2(&sample));
            rows.time_s.push(time_s);
            rows.reference_rad.push(steps.reference_rad[step]);
            rows.logged_angle_rad.push(logger.attitude([before.roll_rad, before.pitch_rad, before.yaw_rad]));
            rows.logged_rate_body_rad_s.push([gyro.x, gyro.y, gyro.z].map(f64::from));
            rows.logged_force_m_s2.push([force.x, force.y, force.z].map(f64::from));
            if plant.flies_free() {
                rows.logged_navigation.push(logger.navigation(now));
            }
            rows.commands.push(steps.commands[step]);
        }
        Ok(rows)
    }

    fn late_times_s(&self) -> Vec<f64> {
        let mut lateness = RandomStream::new(self.seed, "jitter");
        let period_s = 1.0 / f64::from(self.log_rate_hz.max(1));
        let rows = (self.duration_s / period_s).round() as usize;
        let late_s = |_: &usize| (self.jitter_s * lateness.normal()).abs().min(JITTER_MAX_SHARE * period_s);
        let late_s: Vec<f64> = (0..rows).collect::<Vec<_>>().iter().map(late_s).collect();
        // times are written to the microsecond; what is logged is the state at the time that is written
        late_s.iter().enumerate().map(|(row, late_s)| rounded(row as f64 * period_s + late_s)).collect()
    }

    fn without_drop_outs(&self, rows: Vec<usize>) -> Vec<usize> {
        if self.drop_out_share <= 0.0 {
            return rows;
        }
        let mut chance = RandomStream::new(self.seed, "drop-outs");
        rows.into_iter().filter(|_| chance.uniform() >= self.drop_out_share).collect()
    }

    fn comments(&self, flight: &FlightSetup) -> Vec<String> {
        let mut comments = vec!["SYNTHETIC: made by a simulation (sil synth), measured nowhere".to_owned()];
        if self.blind {
            return comments;
        }
        let effects: Vec<String> = self.model.effects.iter().map(Effect::to_short).collect();
        let effects = if effects.is_empty() { "none".to_owned() } else { effects.join("; ") };
        comments.push(format!("model: {}; effects: {effects}", flight.model.name));
        let ControllerChoice { rate_hz, .. } = self.choice;
        comments.push(format!(
            "controller: {} at {rate_hz} Hz; log rate {} Hz; seed {}",
            self.choice.name(),
            self.log_rate_hz,
            self.seed
        ));
        comments
    }
}

fn fly(flight: &FlightSetup, plant: &mut Plant, sensors: &mut Sensors) -> Result<FlightRecord, SetupError> {
    let mut control = flight.control_side()?;
    Ok(cosim::fly(&flight.design_parameters(), plant, sensors, &mut control, &flight.scenario, None))
}

/// What was seen at a time that was requested; times round in the last digits.
fn seen_at(seen: &[Truth], time_s: f64) -> Option<&Truth> {
    seen.get(seen.partition_point(|truth| truth.time_s < time_s - 1e-8))
}

/// A seed of its own for the logger, whose noise is not the controller's.
fn logger_seed(seed: u64) -> u64 {
    seed ^ u64::from_be_bytes(*b"\0\0logger")
}

fn model_has_battery(model: &VehicleModel) -> bool {
    let by_voltage =
        |effect: &Effect| matches!(effect, Effect::BatterySag(BatterySag { law: BatterySagLaw::Voltage { .. } }));
    model.effects.iter().any(by_voltage)
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
mod tests;
