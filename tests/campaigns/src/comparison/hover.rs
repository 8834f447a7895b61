//! At hover on the nominal vehicle: what a torque from outside does, and what the sensors' noise makes the motors do.

use rayon::prelude::*;
use serde::Serialize;
use shared_control::torque_observer::DisturbanceAlert;
use sil_host::axis::Axis;
use sil_host::controller_file::AlertName;
use sil_host::cosim::record::FlightRecord;
use sil_host::effects::{Effect, StepDisturbance};
use sil_host::flight::FlightSetup;
use sil_host::margins::{self, Margins};
use sil_host::metrics::mean;
use sil_host::model::{SensorNoise, VehicleModel};
use sil_host::scenario::Scenario;

use super::alert_margins;
use super::contender::Contender;
use super::draw::Draw;
use super::weather::Weather;

/// The torque that sets in, N m: as much as the ring's centre of gravity can be wrong.
const TORQUE_NM: f64 = 0.1;
const SETS_IN_S: f64 = 1.0;
/// Recovered is what stays within this, rad.
const RECOVERED_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
const TORQUE_FLIGHT_S: f64 = 5.0;
const NOISE_FLIGHT_S: f64 = 11.0;
/// What is left of the start, s.
const SETTLE_S: f64 = 1.0;
/// Of a drawn vehicle: when all but the noise has settled, when the torque sets in, and the end, s.
const PUSH_S: [f64; 3] = [2.5, 4.0, 5.5];

/// Answer to a torque step of 0.1 N m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TorqueStep {
    /// Largest angle, degrees.
    pub peak_deg: f64,
    /// Time until the angle stays within half a degree, s; none if it does not within the flight.
    pub recovery_s: Option<f64>,
}

/// What a drawn vehicle does at hover, with its noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Push {
    /// Largest change of the roll after a torque step of 0.1 N m, degrees.
    pub peak_deg: f64,
    /// Standard deviation of the motors' commands before.
    pub command_deviation: f64,
}

/// How much later a loop may be, and how much of a disturbance it makes more of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LeastMargins {
    /// Delay with which the loop still comes to rest, ms.
    pub delay_ms: f64,
    /// Largest part of a disturbing sine that is left at its own frequency.
    pub sensitivity_peak: f64,
}

impl LeastMargins {
    /// The worse of roll and pitch; none of a loop without a delay margin.
    pub fn of_both([roll, pitch]: &[Margins; 2]) -> Option<Self> {
        Some(Self {
            delay_ms: roll.delay_ms?.min(pitch.delay_ms?),
            sensitivity_peak: roll.sensitivity_peak.max(pitch.sensitivity_peak),
        })
    }
}

/// What a controller does at hover.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hover {
    /// Torque steps about roll and pitch.
    pub torque_step: [TorqueStep; 2],
    /// Standard deviation of the motors' commands under the sensors' noise.
    pub command_deviation: f64,
    /// The torque step about roll with vibration and the gyro's notches against it, which are late.
    pub torque_step_with_notches: TorqueStep,
    /// Margins of roll and pitch in calm; none if the loop oscillates by itself.
    pub margins: Option<[Margins; 2]>,
    /// With an observer that is alert as often as it may be; none where it never is.
    pub alert: Option<LeastMargins>,
}

impl Hover {
    /// Flies and measures.
    pub fn of(contender: &Contender) -> Self {
        let with_notches = Contender { with_notches: true, ..contender.clone() };
        let noisy = fly(contender, Draw::nominal(0).model_on(contender.rig), NOISE_FLIGHT_S);
        Self {
            torque_step: [torque_step(contender, Axis::Roll), torque_step(contender, Axis::Pitch)],
            command_deviation: command_deviation(&noisy, [SETTLE_S, NOISE_FLIGHT_S]),
            torque_step_with_notches: torque_step(&with_notches, Axis::Roll),
            margins: margins_in_calm(contender),
            alert: margins_in_alert(contender),
        }
    }
}

/// Margins of roll and pitch in calm; none if the loop oscillates by itself.
pub fn margins_in_calm(contender: &Contender) -> Option<[Margins; 2]> {
    margins_of(&kept(contender, AlertName::Never), &Draw::nominal(0))
}

/// Margins of roll with an observer that is alert as often as it may be; none where it never is.
pub fn margins_in_alert(contender: &Contender) -> Option<LeastMargins> {
    let tuning = contender.setup(&Draw::nominal(0), &Scenario::hover(1.0)).tuning();
    let is_ever = contender.stand_in.is_none() && tuning.mpc_disturbance_alert != DisturbanceAlert::Never;
    is_ever.then(|| alert_margins::measured(&kept(contender, AlertName::Always)))
}

/// With the observer in one state.
fn kept(contender: &Contender, alert: AlertName) -> Contender {
    let mut kept = contender.clone();
    kept.choice.tuning.mpc_disturbance_alert = Some(alert);
    kept
}

/// Margins of many vehicles in calm, in their order, their rings balanced; a loop that oscillates has none.
pub fn margins_all(contender: &Contender, draws: &[Draw]) -> Vec<LeastMargins> {
    let calm = kept(contender, AlertName::Never);
    let oscillates = LeastMargins { delay_ms: 0.0, sensitivity_peak: f64::INFINITY };
    // the constant torque against the ring's moment would count as an oscillation
    let balanced = |draw: &Draw| Draw { ring_moment_nm: 0.0, ..*draw };
    let of =
        |draw: &Draw| margins_of(&calm, &balanced(draw)).as_ref().and_then(LeastMargins::of_both).unwrap_or(oscillates);
    draws.par_iter().map(of).collect()
}

fn margins_of(contender: &Contender, draw: &Draw) -> Option<[Margins; 2]> {
    let parameters = contender.setup(draw, &Scenario::hover(1.0)).design_parameters();
    let model = draw.model_on(contender.rig);
    let responses = margins::measure(&model, &parameters, &contender.control_side());
    responses.map(|axes| axes.map(|response| margins::margins(&response)))
}

/// Pushes many vehicles, in their order.
pub fn push_all(contender: &Contender, draws: &[Draw]) -> Vec<Push> {
    let [settled_s, set_in_s, end_s] = PUSH_S;
    let push = |draw: &Draw| {
        let setup = contender.setup(draw, &Scenario::hover(end_s));
        let record = contender.fly(&setup, |time_s| [if time_s >= set_in_s { TORQUE_NM } else { 0.0 }, 0.0, 0.0]);
        let roll_rad = record.angle_of(Axis::Roll.index());
        let before = record.time_s.partition_point(|&time_s| time_s < set_in_s).saturating_sub(1);
        let from_rad = roll_rad.get(before).copied().unwrap_or(f64::NAN);
        let moved_rad = roll_rad.iter().skip(before).map(|roll_rad| (roll_rad - from_rad).abs());
        Push {
            peak_deg: moved_rad.fold(0.0, f64::max).to_degrees(),
            command_deviation: command_deviation(&record, [settled_s, set_in_s]),
        }
    };
    draws.par_iter().map(push).collect()
}

fn fly(contender: &Contender, model: VehicleModel, duration_s: f64) -> FlightRecord {
    let setup = contender.setup(&Draw::nominal(0), &Scenario::hover(duration_s));
    contender.fly(&FlightSetup { model, ..setup }, |_| [0.0; 3])
}

fn torque_step(contender: &Contender, axis: Axis) -> TorqueStep {
    let mut model = Draw::nominal(0).model_on(contender.rig);
    model.effects.push(Effect::StepDisturbance(StepDisturbance { axis, torque_nm: TORQUE_NM, start_s: SETS_IN_S }));
    model.noise = SensorNoise::NONE;
    if contender.with_notches {
        // without lines to stop they would go out
        Weather::Vibration.shake(&mut model);
    }
    let record = fly(contender, model, TORQUE_FLIGHT_S);
    let angles_rad = record.angle_of(axis.index());
    let last_outside = angles_rad.iter().rposition(|angle| angle.abs() > RECOVERED_RAD);
    let recovered_s = last_outside.map_or(Some(SETS_IN_S), |row| record.time_s.get(row + 1).copied());
    TorqueStep {
        peak_deg: angles_rad.iter().fold(0.0, |peak: f64, angle| peak.max(angle.abs())).to_degrees(),
        recovery_s: recovered_s.map(|time_s| time_s - SETS_IN_S),
    }
}

fn command_deviation(record: &FlightRecord, within_s: [f64; 2]) -> f64 {
    let [first, end] = within_s.map(|at_s| record.time_s.partition_point(|&time_s| time_s < at_s));
    let rows = first..end;
    let variances = [0, 1, 2, 3].map(|motor| {
        let commands: Vec<f64> = record.commands[rows.clone()].iter().map(|motors| motors[motor]).collect();
        let middle = mean(&commands);
        mean(&commands.iter().map(|command| (command - middle) * (command - middle)).collect::<Vec<_>>())
    });
    mean(&variances).sqrt()
}
