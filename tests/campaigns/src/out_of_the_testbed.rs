//! The thesis' last question about its controllers (section 7.3.1): the vehicle is taken out of the testbed. Are roll
//! and pitch alike then? How does it yaw? Is the MPC stable without the rings' inertia, and robust against what pushes
//! from outside? Flown with controllers that still take the vehicle for the one in the testbed, and with controllers
//! that were made again for what flies.

use rayon::prelude::*;
use serde::Serialize;
use shared_control::config::Controller;
use sil_host::axis::Axis;
use sil_host::controller_file::ControllerChoice;
use sil_host::cosim::record::FlightRecord;
use sil_host::effects::{Effect, StepDisturbance};
use sil_host::flight::FlightSetup;
use sil_host::margins::Margins;
use sil_host::metrics::AxisMetrics;
use sil_host::model::{Mounting, Rig, SensorNoise, VehicleModel};
use sil_host::scenario::{Scenario, Waypoint};
use sil_host::thesis::thesis_mpc;

/// Moment of inertia about z with the inner ring, kg m² (thesis, table 3.4): what the testbed's controller has for yaw.
const IZZ_IN_TESTBED_KG_M2: f64 = 0.0290742;
const SEED: u64 = 1;
/// The turn of the heading: this fast, from and to, s.
const TURN_RAD_S: f64 = 1.0;
const TURN_S: [f64; 2] = [2.0, 4.0];
const TURN_FLIGHT_S: f64 = 8.0;
/// Torque steps on roll, pitch and yaw, N m, when they set in and how long is looked, s.
const PUSH_NM: [f64; 3] = [0.1, 0.1, 0.02];
const PUSH_AT_S: f64 = 2.0;
const PUSH_FLIGHT_S: f64 = 8.0;
/// A vehicle that tilts further than this in the test sequence or in hover has lost it, rad: twice the largest step.
const LOST_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;

/// What flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Flown {
    /// The thesis' F450 in its rings.
    InTestbed,
    /// The same without rings, as light as its lift at half command carries.
    RingsOff,
    /// An F450 as people fly it.
    RealF450,
}

/// What its controllers take it for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TakenFor {
    /// The vehicle in the testbed, its rings' inertia included.
    InTestbed,
    /// What flies.
    Itself,
}

/// Who flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Contender {
    /// The thesis' MPC: 100 Hz, one free input.
    ThesisMpc,
    /// This project's cascade with default tuning, 400 Hz.
    Cascade,
    /// This project's MPC with default tuning, 400 Hz.
    Mpc,
}

impl Flown {
    /// All of them.
    pub const ALL: [Flown; 3] = [Flown::InTestbed, Flown::RingsOff, Flown::RealF450];

    /// As tables call it.
    pub fn words(self) -> &'static str {
        match self {
            Flown::InTestbed => "thesis' F450 in the testbed",
            Flown::RingsOff => "the same, rings off",
            Flown::RealF450 => "real F450 in free flight",
        }
    }

    /// The vehicle.
    pub fn model(self) -> VehicleModel {
        let testbed = VehicleModel::nominal(Rig::Gimbal);
        match self {
            Flown::InTestbed => testbed,
            Flown::RingsOff => {
                let lift_n = 4.0 * testbed.propulsion.equilibrium(testbed.base_command).lift_n;
                let mass_kg = lift_n / testbed.gravity_m_s2;
                let name = "F450 of the thesis, rings off".to_owned();
                VehicleModel { name, mounting: Mounting::Free { mass_kg }, ..testbed }
                    .with_rotor_drag(VehicleModel::USUAL_ROTOR_DRAG_1_S)
            }
            Flown::RealF450 => VehicleModel::nominal(Rig::Free),
        }
    }

    fn taken_for(self, taken: TakenFor) -> Option<VehicleModel> {
        let (flown, testbed) = (self.model(), VehicleModel::nominal(Rig::Gimbal));
        if taken == TakenFor::Itself || self == Flown::InTestbed {
            return None;
        }
        let Mounting::Gimbal { ring_inertia_kg_m2 } = testbed.mounting else { return None };
        let [ixx, iyy, _] = testbed.inertia_kg_m2;
        let inertia_kg_m2 = [ixx, iyy + ring_inertia_kg_m2, IZZ_IN_TESTBED_KG_M2];
        // that it flies, and how it knows level then, is no matter of its control laws
        Some(VehicleModel { inertia_kg_m2, mounting: flown.mounting, ..testbed })
    }
}

impl Contender {
    /// All of them.
    pub const ALL: [Contender; 3] = [Contender::ThesisMpc, Contender::Cascade, Contender::Mpc];

    /// As tables call it.
    pub fn words(self) -> &'static str {
        match self {
            Contender::ThesisMpc => "thesis' MPC",
            Contender::Cascade => "cascade",
            Contender::Mpc => "MPC",
        }
    }

    fn choice(self) -> ControllerChoice {
        match self {
            Contender::ThesisMpc => thesis_mpc().expect("a file of the project, tested"),
            Contender::Cascade => ControllerChoice::nominal(Controller::Cascade),
            Contender::Mpc => ControllerChoice::nominal(Controller::Mpc),
        }
    }
}

/// The figures of one vehicle under one controller.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// What flies.
    pub flown: Flown,
    /// Who flies it.
    pub contender: Contender,
    /// What for.
    pub taken_for: TakenFor,
    /// True if the test sequence, the turn or a push ends beyond 60 degrees.
    pub lost: bool,
    /// The test sequence, roll and pitch.
    pub steps: [AxisMetrics; 2],
    /// Largest error of the heading while roll and pitch step, degrees; in free flight.
    pub heading_in_steps_deg: Option<f64>,
    /// Mean and largest error of the heading, degrees, in a turn of 2 rad at 1 rad/s; in free flight.
    pub turn_deg: Option<[f64; 2]>,
    /// Largest angle after 0.1 N m on roll, 0.1 on pitch and, in free flight, 0.02 on yaw, degrees.
    pub pushed_deg: [Option<f64>; 3],
    /// Of roll and pitch in hover; none where the loop oscillates by itself.
    pub margins: Option<[Margins; 2]>,
}

/// All vehicles under all controllers.
pub fn outcomes() -> Vec<Outcome> {
    let all = Flown::ALL.into_iter().flat_map(|flown| {
        let taken: &[TakenFor] =
            if flown == Flown::InTestbed { &[TakenFor::Itself] } else { &[TakenFor::InTestbed, TakenFor::Itself] };
        Contender::ALL.into_iter().flat_map(move |contender| taken.iter().map(move |taken| (flown, contender, *taken)))
    });
    all.collect::<Vec<_>>().into_par_iter().map(|(flown, contender, taken)| outcome(flown, contender, taken)).collect()
}

/// One of them.
///
/// # Panics
/// If a controller refuses the vehicle: these do not.
pub fn outcome(flown: Flown, contender: Contender, taken_for: TakenFor) -> Outcome {
    let setup = FlightSetup {
        model: flown.model(),
        controller_model: flown.taken_for(taken_for),
        choice: contender.choice(),
        scenario: Scenario::test_sequence(),
        seed: SEED,
    };
    let sequence = setup.fly().expect("a controller of the project");
    let is_free = flown != Flown::InTestbed;
    let turned = is_free.then(|| record(&setup, &[], turn()));
    let pushed: Vec<Option<FlightRecord>> = Axis::ALL
        .into_iter()
        .map(|axis| {
            (is_free || axis != Axis::Yaw).then(|| record(&setup, &[push(axis)], Scenario::hover(PUSH_FLIGHT_S)))
        })
        .collect();
    let flights = [&sequence.record].into_iter().chain(&turned).chain(pushed.iter().flatten());
    let lost = flights.into_iter().any(is_lost);
    let peak = |axis: Axis| Some(largest(record_of(&pushed, axis)?.angle_of(axis.index()).into_iter()));
    Outcome {
        flown,
        contender,
        taken_for,
        lost,
        steps: [sequence.summary.axes.roll, sequence.summary.axes.pitch],
        heading_in_steps_deg: is_free.then(|| largest(sequence.record.angle_of(2).into_iter())),
        turn_deg: turned.map(|record| heading_errors_deg(&record)),
        pushed_deg: Axis::ALL.map(peak),
        margins: setup.margins().expect("a controller of the project"),
    }
}

fn record_of(records: &[Option<FlightRecord>], axis: Axis) -> Option<&FlightRecord> {
    records.get(axis.index())?.as_ref()
}

/// The same controller in another flight, without noise.
fn record(setup: &FlightSetup, effects: &[Effect], scenario: Scenario) -> FlightRecord {
    let model = VehicleModel { effects: effects.to_vec(), noise: SensorNoise::NONE, ..setup.model.clone() };
    let known = setup.controller_model.clone().unwrap_or_else(|| setup.model.clone());
    let setup = FlightSetup { model, controller_model: Some(known), scenario, ..setup.clone() };
    setup.fly().expect("a controller of the project").record
}

fn push(axis: Axis) -> Effect {
    Effect::StepDisturbance(StepDisturbance { axis, torque_nm: PUSH_NM[axis.index()], start_s: PUSH_AT_S })
}

fn turn() -> Scenario {
    let turning = Waypoint { yaw_rate_rad_s: TURN_RAD_S, ..Waypoint::level(TURN_S[0]) };
    let waypoints = vec![Waypoint::level(0.0), turning, Waypoint::level(TURN_S[1])];
    Scenario { name: "a turn of the heading".into(), duration_s: TURN_FLIGHT_S, waypoints }
}

/// Mean and largest error of the heading, degrees.
fn heading_errors_deg(record: &FlightRecord) -> [f64; 2] {
    let wanted_rad = |time_s: f64| TURN_RAD_S * (time_s.clamp(TURN_S[0], TURN_S[1]) - TURN_S[0]);
    let errors: Vec<f64> =
        record.time_s.iter().zip(record.angle_of(2)).map(|(time_s, yaw_rad)| yaw_rad - wanted_rad(*time_s)).collect();
    let mean_rad = errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len() as f64;
    [mean_rad.to_degrees(), largest(errors.into_iter())]
}

/// Largest size, degrees.
fn largest(angles_rad: impl Iterator<Item = f64>) -> f64 {
    angles_rad.fold(0.0, |largest: f64, angle| largest.max(angle.abs())).to_degrees()
}

fn is_lost(record: &FlightRecord) -> bool {
    record.ended_early || record.angle_rad.iter().any(|[roll, pitch, _]| roll.abs().max(pitch.abs()) > LOST_RAD)
}
