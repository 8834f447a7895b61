//! The fit of a free vehicle: which of the catalogue's effects are unknown, and how sure one is of each before a log is
//! seen.

use super::NotIdentified;
use super::folding::{even, folded, in_unit_of, is_own, model_mass, with_assumed_yaw};
use super::numbers::{self, Identified};
use super::seen;
use crate::axis::Axis;
use crate::diagnosis::base;
use crate::diagnosis::effectiveness;
use crate::diagnosis::estimate::Estimate;
use crate::diagnosis::extension::model_with_terms;
use crate::diagnosis::fitted::{Fitted, LAG_AND_DELAY_S};
use crate::diagnosis::fitting::fit::Term;
use crate::diagnosis::fitting::process_noise::Disturbance;
use crate::diagnosis::fitting::sampling::Sampled;
use crate::diagnosis::progress::{Observer, Progress};
use crate::diagnosis::search::Search;
use crate::effects::{Prior, Scope};
use crate::log::Log;
use crate::model::VehicleModel;
use crate::prediction::Subject;

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

impl Rough {
    /// The first of the unknowns, or all, with their values.
    fn terms<'e>(&self, unknowns: &'e [Fitted]) -> Vec<Term<'e>> {
        let pairs = unknowns.iter().zip(&self.values);
        pairs.map(|(effect, values)| Term { effect, values: values.clone() }).collect()
    }
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
    UNKNOWN.iter().flat_map(of_name).chain(base::by_speed(scope)).chain(offset).chain(yaw).collect()
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
    let curve = curve.iter().map(|effect| Term { effect, values: effect.prior().map_or(vec![0.0], |p| vec![p.mean]) });
    let nominal = || subject.model(log);
    let shooting = subject.shooting(log, &subject.noise(log))?;
    let search = Search::new(&shooting, &nominal, &[], curve.collect(), &observer);
    let fit = base::fitted(&search, others, None).fit;
    let values = fit.terms.iter().map(|term| if is_own(term.effect) { vec![1.0] } else { term.values.clone() });
    Ok(Rough { model: with_assumed_yaw(folded(start, &fit.terms)), values: values.collect() })
}

/// An identified vehicle.
pub(super) struct Fine {
    /// With everything in it.
    pub(super) model: VehicleModel,
    pub(super) numbers: Vec<Identified>,
    /// Angular acceleration per unit of each axis' command, rad/s^2.
    pub(super) gains: [Option<Estimate>; 3],
}

/// The fit in the noise of all that the model does not know, the commands between rows as the log shows them.
pub(super) fn fine(log: &Log, rough: &Rough, observer: Observer<'_>) -> Result<Fine, NotIdentified> {
    let are_done = |fits: usize| observer(identifying(LAG_AND_DELAY_S.len() + fits));
    are_done(0);
    let subject = Subject::Vehicle(&rough.model);
    let unknowns = unknowns(&subject.scope(log), rough.model.base_command);
    let nominal = || subject.model(log);
    let sampled = Sampled::new(log, &subject, None)?;
    let (search, found) =
        sampled.nominal(|shooting| Search::new(shooting, &nominal, &[], rough.terms(&unknowns), &|_| ()));
    are_done(1);
    let shooting = base::in_noise_of(log, &subject, &search, &found.fit, Disturbance::White)?;
    are_done(2);
    let search = Search::new(&shooting, &nominal, &[], rough.terms(&unknowns), &|_| ());
    let fit = search.refitted(found.fit.terms, &found.fit.starts);
    are_done(3);
    let seen = seen::axes(&search, &fit);
    if base::acts_at_once(&fit.terms) {
        return Err(NotIdentified::AtOnce(Box::new(super::ShownFlight::of(log))));
    }
    if seen == [false; 3] {
        return Err(NotIdentified::Quiet(Box::new(super::ShownFlight::of(log))));
    }
    let numbers = numbers::of(&fit, &shooting, &nominal, rough.model.base_command, seen);
    let gains = effectiveness::of(&fit, &nominal, &subject);
    let others: Vec<Term<'_>> =
        fit.terms.iter().filter(|term| !is_own(term.effect)).map(|term| even(term, &fit.terms)).collect();
    let model = folded(&rough.model, &fit.terms);
    let model = model_with_terms(&model, &in_unit_of(model_mass(&fit.terms), others))
        .map_err(|problem| NotIdentified::Impossible(problem.to_string()))?;
    Ok(Fine { model, numbers, gains })
}
