//! The fit of a free vehicle: which of the catalogue's effects are unknown, how sure one is of each before a log is
//! seen, and what of them becomes a number of the model itself.

use super::NotIdentified;
use super::numbers::{self, Identified};
use super::seen;
use super::start::YAW_SHARE;
use crate::axis::Axis;
use crate::diagnosis::base;
use crate::diagnosis::extension::model_with_terms;
use crate::diagnosis::fitted::{Fitted, LAG_AND_DELAY_S};
use crate::diagnosis::fitting::fit::Term;
use crate::diagnosis::fitting::sampling::Sampled;
use crate::diagnosis::progress::{Observer, Progress};
use crate::diagnosis::search::Search;
use crate::effects::{Prior, Scope};
use crate::log::Log;
use crate::model::{Mounting, VehicleModel};
use crate::prediction::Subject;
use crate::vehicle::propulsion::Propulsion;

/// What is unknown of every vehicle, and where it is expected: (effect, mean, standard deviation) of those that a log
/// may leave open. A start that a regression gave may be wrong by half; propellers differ by a fifth; the thrust of
/// most motors lies between the line (0) and the square (1) of the command.
const UNKNOWN: [(&str, Option<(f64, f64)>); 8] = [
    ("thrust_curve", Some((0.6, 0.4))),
    ("inertia_error", Some((1.0, 0.5))),
    ("mass_error", Some((1.0, 0.3))),
    ("weak_motor", Some((1.0, 0.2))),
    ("torque_bias", None),
    ("gyro_bias", None),
    ("motor_lag", Some((0.03, 0.05))),
    ("actuation_delay", Some((0.005, 0.03))),
];

/// Inertia about yaw over what is assumed of it: it shows where a vehicle turns about two axes at once.
const YAW_INERTIA: Prior = Prior { mean: 1.0, std: 0.08 };

fn is_inertia(effect: &Fitted, axis: Axis) -> bool {
    effect.name() == "inertia_error" && effect.axis() == Some(axis)
}

/// A vehicle's model and the numbers beside it that are not its own, in the order of [`unknowns`].
pub(super) struct Rough {
    model: VehicleModel,
    values: Vec<Vec<f64>>,
}

/// The effects that are fitted, the curve of thrust first.
fn unknowns(scope: &Scope, at_command: f64) -> Vec<Fitted> {
    // how lift grows with the command shows where the accelerometer or the velocity shows lift
    let offset = scope.pushed.then_some(Fitted::LiftOffset { at_command });
    let yaw = Fitted::hypotheses(scope).into_iter().find(|effect| is_inertia(effect, Axis::Yaw));
    let yaw = yaw.map(|effect| effect.expected(YAW_INERTIA)).into_iter().chain([Fitted::ReactionTorque]);
    let of_name = |(name, prior): &(&'static str, Option<(f64, f64)>)| -> Vec<Fitted> {
        let is_of_name = |effect: &Fitted| effect.name() == *name && !is_inertia(effect, Axis::Yaw);
        let all = Fitted::hypotheses(scope).into_iter().filter(is_of_name);
        match prior {
            Some((mean, std)) => all.map(|effect| effect.expected(Prior { mean: *mean, std: *std })).collect(),
            None => all.collect(),
        }
    };
    UNKNOWN.iter().flat_map(of_name).chain(offset).chain(yaw).collect()
}

/// Where a number was expected before the log was seen.
pub(super) fn expected(effect: &Fitted) -> Option<Prior> {
    effect.unknowns().first().and_then(|unknown| unknown.prior)
}

/// Fits of [`fine`]: the unknowns, the noise, the unknowns in that noise, the numbers with their intervals.
const FINE_FITS: usize = 4;

fn identifying(done: usize) -> Progress {
    Progress::Identifying { done, total: LAG_AND_DELAY_S.len() + FINE_FITS }
}

/// A first fit from several lags and delays, in the sensors' noise.
pub(super) fn rough(log: &Log, start: &VehicleModel, observer: Observer<'_>) -> Result<Rough, NotIdentified> {
    let observer = |progress| {
        if let Progress::Fitting { done, .. } = progress {
            observer(identifying(done));
        }
    };
    let subject = Subject::Vehicle(start);
    let unknowns = unknowns(&subject.scope(log), start.base_command);
    let (curve, others) = unknowns.split_at(unknowns.iter().take_while(|one| one.name() == "thrust_curve").count());
    let curve =
        curve.iter().map(|effect| Term { effect, values: expected(effect).map_or(vec![0.0], |p| vec![p.mean]) });
    let nominal = || subject.model(log);
    let shooting = subject.shooting(log, &subject.noise(log))?;
    let search = Search::new(&shooting, &nominal, &[], curve.collect(), &observer);
    let fit = base::fitted(&search, others).fit;
    let values = fit.terms.iter().map(|term| if is_own(term.effect) { vec![1.0] } else { term.values.clone() });
    Ok(Rough { model: with_assumed_yaw(folded(start, &fit.terms)), values: values.collect() })
}

/// The fit in the noise of all that the model does not know, the commands between rows as the log shows them; the model
/// with everything in it, and its numbers.
pub(super) fn fine(
    log: &Log,
    rough: &Rough,
    observer: Observer<'_>,
) -> Result<(VehicleModel, Vec<Identified>), NotIdentified> {
    let are_done = |fits: usize| observer(identifying(LAG_AND_DELAY_S.len() + fits));
    are_done(0);
    let subject = Subject::Vehicle(&rough.model);
    let unknowns = unknowns(&subject.scope(log), rough.model.base_command);
    let terms = || -> Vec<Term<'_>> {
        let pairs = unknowns.iter().zip(&rough.values);
        pairs.map(|(effect, values)| Term { effect, values: values.clone() }).collect()
    };
    let nominal = || subject.model(log);
    let sampled = Sampled::new(log, &subject, None)?;
    let (search, found) = sampled.nominal(|shooting| Search::new(shooting, &nominal, &[], terms(), &|_| ()));
    are_done(1);
    let shooting = base::in_noise_of(log, &subject, &search, &found.fit)?;
    are_done(2);
    let search = Search::new(&shooting, &nominal, &[], terms(), &|_| ());
    let fit = search.refitted(found.fit.terms, &found.fit.starts);
    are_done(3);
    let seen = seen::axes(&search, &fit);
    if seen == [false; 3] || base::acts_at_once(&fit.terms) {
        return Err(NotIdentified::Quiet);
    }
    let numbers = numbers::of(&fit, &shooting, &nominal, rough.model.base_command, seen);
    let others: Vec<Term<'_>> =
        fit.terms.iter().filter(|term| !is_own(term.effect)).map(|term| even(term, &fit.terms)).collect();
    let model = folded(&rough.model, &fit.terms);
    let model = model_with_terms(&model, &in_unit_of(model_mass(&fit.terms), others))
        .map_err(|problem| NotIdentified::Impossible(problem.to_string()))?;
    Ok((model, numbers))
}

/// Is an effect nothing but another value of one of the model's numbers?
fn is_own(effect: &Fitted) -> bool {
    matches!(effect.name(), "inertia_error" | "mass_error" | "reaction_torque")
}

fn value_of(terms: &[Term<'_>], name: &str, axis: Option<Axis>) -> Option<f64> {
    let term = terms.iter().find(|term| term.effect.name() == name && term.effect.axis() == axis);
    term.and_then(|term| term.values.first().copied())
}

/// True mass over the model's: with the mass held, forces and moments are that much smaller.
fn model_mass(terms: &[Term<'_>]) -> f64 {
    value_of(terms, "mass_error", None).unwrap_or(1.0)
}

/// Mean lift of the motors over the model's.
pub(super) fn mean_lift(terms: &[Term<'_>]) -> f64 {
    let motors: Vec<f64> =
        terms.iter().filter(|term| term.effect.name() == "weak_motor").map(|t| t.values[0]).collect();
    if motors.is_empty() { 1.0 } else { motors.iter().sum::<f64>() / motors.len() as f64 }
}

/// A term as it is once the motors' mean lift is the model's.
fn even<'e>(term: &Term<'e>, all: &[Term<'e>]) -> Term<'e> {
    let mut even = term.clone();
    if term.effect.name() == "weak_motor" {
        even.values[0] /= mean_lift(all);
    }
    even
}

/// Moments beside a mass that is held where it was.
fn in_unit_of<'e>(mass: f64, mut terms: Vec<Term<'e>>) -> Vec<Term<'e>> {
    for term in terms.iter_mut().filter(|term| term.effect.name() == "torque_bias") {
        term.values[0] /= mass;
    }
    terms
}

/// The model with inertias, lift and reaction torque as fitted: it then moves as the fitted one does, its mass as
/// before.
fn folded(model: &VehicleModel, terms: &[Term<'_>]) -> VehicleModel {
    let inertia = |axis: Axis| value_of(terms, "inertia_error", Some(axis)).unwrap_or(1.0);
    let (mass, lift) = (model_mass(terms), mean_lift(terms));
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    let (new_ixx, new_iyy) = (ixx * inertia(Axis::Roll) / mass, iyy * inertia(Axis::Pitch) / mass);
    // a flat plate has the most inertia about yaw, a rod along one axis the least
    let fitted_izz = izz * inertia(Axis::Yaw) / mass;
    let new_izz = fitted_izz.clamp((new_ixx - new_iyy).abs(), new_ixx + new_iyy);
    let mut folded = VehicleModel { inertia_kg_m2: [new_ixx, new_iyy, new_izz], ..model.clone() };
    if let (Propulsion::Box(motor), Mounting::Free { .. }) = (&mut folded.propulsion, model.mounting) {
        *motor = motor.with_offset(value_of(terms, "lift_offset", None).unwrap_or_default(), model.base_command);
        motor.lift_offset_n *= lift / mass;
        motor.lift_slope_n *= lift / mass;
        motor.reaction_torque_per_lift_m *=
            value_of(terms, "reaction_torque", None).unwrap_or(1.0) * new_izz / fitted_izz;
    }
    folded
}

/// The same with the assumed inertia about yaw, and as quick about it.
fn with_assumed_yaw(mut model: VehicleModel) -> VehicleModel {
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    let assumed = YAW_SHARE * (ixx + iyy);
    model.inertia_kg_m2[2] = assumed;
    if let Propulsion::Box(motor) = &mut model.propulsion {
        motor.reaction_torque_per_lift_m *= assumed / izz;
    }
    model
}
