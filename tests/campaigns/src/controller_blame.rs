//! Blind search for a changed number of a controller: `sil fly`'s log of a controller with one number changed, or none,
//! is held against the nominal controller. A case is made by its number alone: cascade and MPC by turns, every number
//! in turn, its axis, the size and sign of the change, the noise; every second flight has an effect in the plant too.

use std::fmt::Write;

use shared_control::config::Controller;
use sil_host::controller_file::{ControllerChoice, TuningChange};
use sil_host::diagnosis::controller::{Examination, examine};
use sil_host::effects::Effect;
use sil_host::flight::FlightSetup;
use sil_host::flight_log::flight_log;
use sil_host::log::{self, Log};
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;
use sil_host::sensors::random::RandomStream;

/// Changes, as factors of the number: log-uniform between these, up or down.
const CHANGE: [f64; 2] = [1.2, 1.7];
/// By what more the slow ones are changed: of the disturbance estimate a log like these shows no less.
const SLOW: f64 = 1.6;
/// Effects of the plant that every second flight has one of.
const PLANT: [&str; 4] = [
    "cg_offset:axis=pitch,cos_moment_nm=0.08",
    "viscous_friction:axis=roll,coefficient_nms=0.02",
    "weak_motor:motor=2,scale=0.93",
    "gyro_bias:axis=pitch,bias_rad_s=0.03",
];

type OfAxes = fn(&mut TuningChange) -> &mut Option<[f32; 3]>;
type One = fn(&mut TuningChange) -> &mut Option<f32>;

/// A field of the tuning and where its value is.
enum Field {
    Axes(OfAxes, fn(&shared_control::config::Tuning) -> [f32; 3]),
    One(One, fn(&shared_control::config::Tuning) -> f32),
}

macro_rules! axes {
    ($field:ident) => {
        (stringify!($field), Field::Axes(|change| &mut change.$field, |tuning| tuning.$field))
    };
}

macro_rules! one {
    ($field:ident) => {
        (stringify!($field), Field::One(|change| &mut change.$field, |tuning| tuning.$field))
    };
}

fn cascade_numbers() -> Vec<(&'static str, Field)> {
    vec![
        axes!(rate_proportional_1_s),
        axes!(angle_gain_1_s),
        axes!(rate_derivative),
        axes!(rate_integral_1_s2),
        axes!(shaping_gain_1_s),
        one!(acceleration_share),
        one!(rate_derivative_cutoff_hz),
        one!(gyro_cutoff_hz),
    ]
}

fn mpc_numbers() -> Vec<(&'static str, Field)> {
    vec![
        axes!(mpc_increment_weight),
        axes!(mpc_lead_s),
        one!(mpc_disturbance_bandwidth_rad_s),
        one!(mpc_prediction_step_s),
        axes!(shaping_gain_1_s),
        one!(acceleration_share),
    ]
}

/// What was changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Changed {
    /// Name in the controller file.
    pub parameter: &'static str,
    /// Axis, of numbers that each has its own of.
    pub axis: Option<&'static str>,
    /// Its value in flight.
    pub value: f64,
    /// As modelled.
    pub nominal: f64,
}

/// One flight.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number.
    pub seed: u64,
    /// The nominal controller.
    pub modelled: ControllerChoice,
    /// What was changed in flight, if anything.
    pub changed: Option<Changed>,
    /// Effect of the plant.
    pub plant: Option<&'static str>,
    /// The log.
    pub log: Log,
}

impl Case {
    /// Flies a case by its number, as long as this or to the end of the test sequence; `is_changed` false for the
    /// nominal controller.
    ///
    /// # Panics
    /// If it can't be flown.
    pub fn new(seed: u64, duration_s: f64, is_changed: bool) -> Case {
        let mut draws = RandomStream::new(seed, "controller blame");
        let controller = if seed.is_multiple_of(2) { Controller::Cascade } else { Controller::Mpc };
        let modelled = ControllerChoice::nominal(controller);
        let mut flown = modelled;
        let mut model = VehicleModel::nominal(Rig::Gimbal);
        let plant = (seed / 2 % 2 == 1).then(|| PLANT[(seed / 4 % 4) as usize]);
        model.effects.extend(plant.map(|text| Effect::parse(text, Rig::Gimbal).expect("an effect")));
        let setup = |model: &VehicleModel, choice| FlightSetup {
            model: model.clone(),
            controller_model: None,
            choice,
            scenario: beginning(Scenario::test_sequence(), duration_s),
            seed,
        };
        let changed = is_changed.then(|| {
            let numbers = if controller == Controller::Cascade { cascade_numbers() } else { mpc_numbers() };
            let at = (seed / 2) as usize % numbers.len();
            change(&numbers[at], &mut flown.tuning, &setup(&model, modelled).tuning(), &mut draws)
        });
        let flight = setup(&model, flown).fly().expect("a flight");
        let mut csv = Vec::new();
        log::write(&flight_log(&flight.record, flown.rate_hz), &mut csv).expect("memory takes all");
        let log = log::parse("blind.csv", &String::from_utf8(csv).expect("a log is text"), None).expect("a whole log");
        Case { seed, modelled, changed, plant, log }
    }

    /// What the diagnosis makes of it.
    ///
    /// # Panics
    /// If the nominal controller can't fly.
    pub fn examine(&self) -> Examination {
        examine(&self.log, &VehicleModel::nominal(Rig::Gimbal), self.modelled).expect("a controller that can fly")
    }
}

fn beginning(mut scenario: Scenario, duration_s: f64) -> Scenario {
    scenario.duration_s = scenario.duration_s.min(duration_s);
    scenario.waypoints.retain(|waypoint| waypoint.start_s < duration_s);
    scenario
}

fn change(
    (parameter, field): &(&'static str, Field),
    tuning: &mut TuningChange,
    nominal: &shared_control::config::Tuning,
    draws: &mut RandomStream,
) -> Changed {
    let factor = CHANGE[0] * (CHANGE[1] / CHANGE[0]).powf(draws.uniform());
    let factor = if *parameter == "mpc_disturbance_bandwidth_rad_s" { SLOW * factor } else { factor };
    let factor = (if draws.uniform() < 0.5 { factor } else { 1.0 / factor }) as f32;
    let axis = usize::from(draws.uniform() < 0.5);
    let (value, was, axis) = match field {
        Field::Axes(of, nominal_of) => {
            let mut values = nominal_of(nominal);
            let was = values[axis];
            values[axis] *= factor;
            *of(tuning) = Some(values);
            (values[axis], was, Some(["roll", "pitch"][axis]))
        }
        Field::One(of, nominal_of) => {
            let was = nominal_of(nominal);
            *of(tuning) = Some(was * factor);
            (was * factor, was, None)
        }
    };
    Changed { parameter, axis, value: f64::from(value), nominal: f64::from(was) }
}

/// How the cases went.
#[derive(Clone, Debug, Default)]
pub struct Score {
    /// One line a case.
    pub table: String,
    /// Cases with a change.
    pub changed: usize,
    /// Of these, the right number and axis, and no other.
    pub named: usize,
    /// Of the named, the value within 10 % of the change.
    pub sized: usize,
    /// Of the named, the truth within 1.96 standard deviations.
    pub covered: usize,
    /// Cases without a change.
    pub nominal: usize,
    /// Of these, with no finding.
    pub silent: usize,
}

impl Score {
    /// Adds a case.
    pub fn add(&mut self, case: &Case, examination: &Examination) {
        let findings = &examination.findings;
        let plant = case.plant.unwrap_or("-");
        let controller = case.modelled.name();
        let Some(changed) = &case.changed else {
            self.nominal += 1;
            let is_silent = findings.is_empty() && examination.remainder.is_empty();
            self.silent += usize::from(is_silent);
            let found = if is_silent { "nothing" } else { "SOMETHING" };
            let _ = writeln!(self.table, "{:3} {controller} nothing changed; plant {plant}: {found}", case.seed);
            return;
        };
        self.changed += 1;
        let is_it = |finding: &sil_host::diagnosis::Finding| {
            finding.controller_parameter == Some(changed.parameter) && finding.axis == changed.axis
        };
        let estimate = match findings.as_slice() {
            [finding] if is_it(finding) => finding.parameters.get("logged"),
            _ => None,
        };
        let error = estimate.map(|estimate| (estimate.value - changed.value).abs());
        let std = estimate.map_or(f64::NAN, |estimate| estimate.std);
        self.named += usize::from(estimate.is_some());
        self.sized += usize::from(error.is_some_and(|error| error < 0.1 * (changed.value - changed.nominal).abs()));
        self.covered += usize::from(error.is_some_and(|error| error <= 1.96 * std));
        let statements: Vec<&str> = findings.iter().map(|finding| finding.statement.as_str()).collect();
        let _ = writeln!(
            self.table,
            "{:3} {controller} {} {} {:.4} (nominal {:.4}); plant {plant}: {} {:.4} +- {std:.4}{}",
            case.seed,
            changed.parameter,
            changed.axis.unwrap_or(""),
            changed.value,
            changed.nominal,
            if estimate.is_some() { "named" } else { "MISSED" },
            estimate.map_or(f64::NAN, |estimate| estimate.value),
            if estimate.is_some() { String::new() } else { format!(" {statements:?} {:?}", examination.rejected) },
        );
    }

    /// The sums in a line.
    pub fn line(&self) -> String {
        format!(
            "named {} of {}, within 10 % of the change {}, truth within 1.96 std {}; silent {} of {} nominal",
            self.named, self.changed, self.sized, self.covered, self.silent, self.nominal
        )
    }
}
