//! At hover on the nominal vehicle: what a torque from outside does, and what the sensors' noise makes the motors do.

use sil_host::axis::Axis;
use sil_host::cosim::record::FlightRecord;
use sil_host::effects::{Effect, StepDisturbance};
use sil_host::flight::FlightSetup;
use sil_host::margins::{self, Margins};
use sil_host::metrics::mean;
use sil_host::model::{SensorNoise, VehicleModel};
use sil_host::scenario::Scenario;

use super::contender::Contender;
use super::draw::Draw;

/// The torque that sets in, N m: as much as the ring's centre of gravity can be wrong.
const TORQUE_NM: f64 = 0.1;
const SETS_IN_S: f64 = 1.0;
/// Recovered is what stays within this, rad.
const RECOVERED_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
const TORQUE_FLIGHT_S: f64 = 5.0;
const NOISE_FLIGHT_S: f64 = 11.0;
/// What is left of the start, s.
const SETTLE_S: f64 = 1.0;

/// Answer to a torque step of 0.1 N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueStep {
    /// Largest angle, degrees.
    pub peak_deg: f64,
    /// Time until the angle stays within half a degree, s; none if it does not within the flight.
    pub recovery_s: Option<f64>,
}

/// What a controller does at hover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hover {
    /// Torque steps about roll and pitch.
    pub torque_step: [TorqueStep; 2],
    /// Standard deviation of the motors' commands under the sensors' noise.
    pub command_deviation: f64,
    /// Margins of roll and pitch; none if the loop oscillates by itself.
    pub margins: Option<[Margins; 2]>,
}

impl Hover {
    /// Flies and measures.
    pub fn of(contender: &Contender) -> Self {
        let model = Draw::nominal(0).model();
        let parameters = contender.setup(&Draw::nominal(0), &Scenario::hover(1.0)).design_parameters();
        let responses = margins::measure(&model, &parameters, &contender.control_side());
        Self {
            torque_step: [torque_step(contender, Axis::Roll), torque_step(contender, Axis::Pitch)],
            command_deviation: command_deviation(&fly(contender, model, NOISE_FLIGHT_S)),
            margins: responses.map(|axes| axes.map(|response| margins::margins(&response))),
        }
    }
}

fn fly(contender: &Contender, model: VehicleModel, duration_s: f64) -> FlightRecord {
    contender.fly(&FlightSetup { model, ..contender.setup(&Draw::nominal(0), &Scenario::hover(duration_s)) })
}

fn torque_step(contender: &Contender, axis: Axis) -> TorqueStep {
    let mut model = Draw::nominal(0).model();
    model.effects.push(Effect::StepDisturbance(StepDisturbance { axis, torque_nm: TORQUE_NM, start_s: SETS_IN_S }));
    model.noise = SensorNoise::NONE;
    let record = fly(contender, model, TORQUE_FLIGHT_S);
    let angles_rad = record.angle_of(axis.index());
    let last_outside = angles_rad.iter().rposition(|angle| angle.abs() > RECOVERED_RAD);
    let recovered_s = last_outside.map_or(Some(SETS_IN_S), |row| record.time_s.get(row + 1).copied());
    TorqueStep {
        peak_deg: angles_rad.iter().fold(0.0, |peak: f64, angle| peak.max(angle.abs())).to_degrees(),
        recovery_s: recovered_s.map(|time_s| time_s - SETS_IN_S),
    }
}

fn command_deviation(record: &FlightRecord) -> f64 {
    let rows = record.time_s.partition_point(|&time_s| time_s < SETTLE_S)..record.len();
    let variances = [0, 1, 2, 3].map(|motor| {
        let commands: Vec<f64> = record.commands[rows.clone()].iter().map(|motors| motors[motor]).collect();
        let middle = mean(&commands);
        mean(&commands.iter().map(|command| (command - middle) * (command - middle)).collect::<Vec<_>>())
    });
    mean(&variances).sqrt()
}
