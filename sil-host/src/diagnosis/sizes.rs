//! Sizes of effects that the caller names, whether a search would add them or not: they show how closely a log confirms
//! a model that is right already.

use std::collections::BTreeMap;

use super::fitted::Fitted;
use super::verdict::{Estimate, MODEL_ERROR, estimates};
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, Nominal, Term, fit, model_of};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::effects::Hints;
use crate::log::Log;
use crate::prediction::{NotPredictable, Subject};

/// An effect of the catalogue: its name, and its axis if it has one.
pub type Asked = (&'static str, Option<Axis>);

/// Its parameters by name.
pub type Size = BTreeMap<&'static str, Estimate>;

/// Fits some effects together to all windows of a log, under the noise that is most likely with them: one size for each
/// that the log shows, none for the others.
///
/// # Errors
/// As [`super::diagnose`].
pub fn sizes(log: &Log, subject: &Subject<'_>, asked: &[Asked]) -> Result<Vec<Option<Size>>, NotPredictable> {
    let thinned = log.thinned();
    let log = thinned.as_ref().unwrap_or(log);
    let nominal = || subject.model();
    let table = Fitted::hypotheses(&subject.scope(log));
    let shooting = subject.shooting(log, &subject.noise(log))?;
    let fitted_along = subject.fitted_along(&shooting.log)?;
    let mut terms: Vec<Term<'_>> = fitted_along.iter().map(|gain| Term { effect: gain, values: vec![0.0] }).collect();
    let mut places = Vec::new();
    for (name, axis) in asked {
        let effect = table.iter().find(|effect| effect.name() == *name && effect.axis() == *axis);
        places.push(effect.map(|_| terms.len()));
        terms
            .extend(effect.and_then(|effect| {
                Some(Term { effect, values: effect.starts(&Hints::default()).into_iter().next()? })
            }));
    }
    let under_sensors = fitted_to_all(&shooting, &nominal, terms);
    let all: Vec<usize> = (0..shooting.log.windows.len()).collect();
    let driven = shooting.log.drive(model_of(&nominal, &under_sensors.terms));
    let noise = shooting.most_likely_noise(&driven, &all, &under_sensors.starts);
    let carried = shooting.carried_noise(&driven, &all, &under_sensors.starts);
    let shooting = shooting.with_noise(noise, carried);
    let fit = fitted_to_all(&shooting, &nominal, under_sensors.terms);
    Ok(places.into_iter().map(|place| Some(estimates(&fit, place?, MODEL_ERROR))).collect())
}

/// The effects fitted to every window, from their values on.
fn fitted_to_all<'e>(shooting: &Shooting<'_>, nominal: Nominal<'_>, terms: Vec<Term<'e>>) -> Fit<'e> {
    let all: Vec<usize> = (0..shooting.log.windows.len()).collect();
    let driven = shooting.log.drive(model_of(nominal, &terms));
    let mut starts = shooting.log.measured_starts(&driven.model);
    shooting.settle(&driven, &all, &mut starts);
    fit(shooting, nominal, terms, &starts, &all)
}
