//! An answer about a vehicle that imitates reality, beside the truth: the figures of what it does, the names, and what
//! of the numbers is wrong.

use sil_host::diagnosis::{Diagnosis, Estimate};
use sil_host::log::Log;
use sil_host::model::VehicleModel;

use super::behaviour::{Figure, Named, inertia};
use super::case::Case;
use super::reality::Reality;
use super::shown::shown;

/// Standard deviations that 95 % lie within.
const INTERVAL: f64 = 1.96;
/// A number is wrong beyond so many standard deviations and this share of itself.
const WRONG: (f64, f64) = (3.0, 0.25);

/// Share of the error from which on a cause has to be named: a finding must gain 2 %, and near that it is chance.
const NAMED_FROM: f64 = 0.05;

/// What the wrong constants of the file are called, where they are found.
const OF_THE_FILE: [&str; 2] = ["thrust_scale", "inertia_error"];

/// An answer beside what was drawn.
#[derive(Clone, Debug)]
pub struct BesideReality {
    /// Share of the held-out error that hangs on the cause, as `blind::shown` measures it; none where there is none.
    pub shown: Option<f64>,
    /// Each figure: truth, and what follows from the answer.
    pub figures: Vec<(Figure, f64, Estimate)>,
    /// Findings that are told as certain and are not there.
    pub false_names: Vec<String>,
    /// Findings of what is there, in another size than said: name, truth and value, moments over the inertia.
    pub wrong_sizes: Vec<(String, f64, Estimate)>,
}

impl BesideReality {
    pub(super) fn of(case: &Case, reality: &Reality, log: &Log, answer: &Diagnosis) -> BesideReality {
        let truth: Vec<Named> = case.vehicle.effects.iter().map(|effect| Named::of_short(&effect.to_short())).collect();
        let named = Named::of_answer(answer);
        let half_s = 0.5 * case.conditions.duration_s;
        let figure = |figure: Figure| {
            let told = figure.estimated(&reality.given, &named, half_s);
            let truth_at = |at_s| figure.of(&case.vehicle, &truth, at_s);
            let truth = match figure {
                // thrust is lost along the log, and what is told is its mean over wherever the axis was moved
                Figure::Effectiveness(_) => told.value.clamp(truth_at(2.0 * half_s), truth_at(0.0)),
                Figure::Late | Figure::Trim(_) => truth_at(half_s),
            };
            (figure, truth, told)
        };
        let (mut false_names, mut wrong_sizes) = (Vec::new(), Vec::new());
        for finding in &answer.findings {
            let own = Named::of_finding(finding);
            let is_called = |other: &Named, name: &str| other.effect == name || other.label() == name;
            let is_there = |name: &str| truth.iter().any(|other| is_called(other, name)) || OF_THE_FILE.contains(&name);
            // of an effect that may as well be elsewhere the size is none
            let is_elsewhere = |name: &String| *name != own.effect && name.starts_with(&own.effect);
            match truth.iter().find(|other| other.is_at(&own)) {
                Some(_) if finding.confounded_with.iter().any(is_elsewhere) => {}
                Some(other) => {
                    wrong_sizes.extend(sizes_beside((&case.vehicle, &truth, other), (&reality.given, &named, &own)));
                }
                None if OF_THE_FILE.contains(&own.effect.as_str()) => {}
                // one of several, or nothing
                None if !finding.one_of.is_empty() => {}
                None if finding.confounded_with.iter().any(|name| is_there(name)) => {}
                None => false_names.push(own.label()),
            }
        }
        let figures = Figure::ALL.map(figure).into();
        BesideReality { shown: shown(case, log), figures, false_names, wrong_sizes }
    }

    /// Does an interval hold the truth, or is the error nobody's concern?
    pub fn holds((figure, truth, told): &(Figure, f64, Estimate)) -> bool {
        let error = (told.value - truth).abs();
        error <= INTERVAL * told.std || error <= figure.negligible(*truth)
    }

    /// True if the log shows the cause well enough for it to be named.
    pub fn is_shown(&self) -> bool {
        self.shown.is_some_and(|share| share >= NAMED_FROM)
    }

    /// True if all figures are right.
    pub fn base_is_right(&self) -> bool {
        self.figures.iter().all(BesideReality::holds)
    }
}

/// A vehicle, all that is about it, and one of its effects.
type Owned<'a> = (&'a VehicleModel, &'a [Named], &'a Named);

/// The first number of an effect, where it is wrong. Moments are known over the inertia, which no log of a gimbal tells
/// apart; trims are in the figures.
fn sizes_beside(truth: Owned<'_>, told: Owned<'_>) -> Option<(String, f64, Estimate)> {
    let (_, _, named) = told;
    if ["torque_bias", "motor_lag", "actuation_delay"].contains(&named.effect.as_str()) {
        return None;
    }
    let (name, nominal) = match named.effect.as_str() {
        "weak_motor" | "gyro_scale" => ("scale", 1.0),
        "cg_offset" => ("cos_moment_nm", 0.0),
        "viscous_friction" => ("coefficient_nms", 0.0),
        "coulomb_friction" | "step_disturbance" => ("torque_nm", 0.0),
        "spring" => ("stiffness_nm_rad", 0.0),
        "periodic_disturbance" => ("amplitude_nm", 0.0),
        "battery_sag" => ("per_s", 0.0),
        "gyro_bias" => ("bias_rad_s", 0.0),
        "attitude_delay" => ("delay_s", 0.0),
        "imu_misalignment" => ("yaw_rad", 0.0),
        _ => return None,
    };
    let (truth, told) = (number(truth, name)?, number(told, name)?);
    let error = (told.value - truth.value).abs();
    let is_wrong = error > WRONG.0 * told.std && error > WRONG.1 * (truth.value - nominal).abs();
    is_wrong.then(|| (named.label(), truth.value, told))
}

fn number((vehicle, all, named): Owned<'_>, name: &str) -> Option<Estimate> {
    let estimate = named.values.get(name)?;
    let axis = ["roll", "pitch"].iter().position(|axis| named.axis.as_deref() == Some(axis));
    let per = match axis {
        Some(axis) if name.contains("_nm") => inertia(vehicle, all, axis),
        _ => 1.0,
    };
    Some(Estimate { value: estimate.value / per, std: estimate.std / per })
}
