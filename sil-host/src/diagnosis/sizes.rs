//! Sizes of effects that the caller names, whether a search would add them or not: they show how closely a log confirms
//! a model that is right already.

use std::collections::BTreeMap;

use super::base;
use super::estimate::Estimate;
use super::fitted::Fitted;
use super::kinematics::Kinematics;
use super::lateness::of_rows_std_s;
use super::noise::noise_beyond_sensors;
use super::search::Search;
use super::verdict::{MODEL_ERROR, estimates};
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, Nominal, Term, as_terms, fit, model_of};
use crate::diagnosis::fitting::process_noise::Disturbance;
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
    let nominal = || subject.model(log);
    let catalogue = Kinematics::of(log).informed(Fitted::hypotheses(&subject.scope(log)));
    let shooting = subject.shooting(log, &subject.noise(log))?;
    let along = subject.fitted_along(log)?;
    let terms = with_asked(as_terms(&along), &catalogue, asked);
    let search = Search::new(&shooting, &nominal, &catalogue, as_terms(&along), &|_| ());
    let under_sensors = fitted_to_all(&shooting, &nominal, terms);
    let all = shooting.log.in_use();
    let (moments, forces) = noise_beyond_sensors(&search, &all, &under_sensors, Disturbance::White);
    let shooting = subject.shooting(log, &subject.noise(log))?.with_noise(moments, forces);
    Ok(fitted_to_all(&shooting, &nominal, under_sensors.terms).sizes(asked))
}

/// The same beside the base model: what that has of them is what the log shows.
///
/// # Errors
/// As [`super::diagnose`].
pub fn sizes_beside_base(
    log: &Log,
    subject: &Subject<'_>,
    asked: &[Asked],
) -> Result<Vec<Option<Size>>, NotPredictable> {
    let thinned = log.thinned();
    let log = thinned.as_ref().unwrap_or(log);
    let (nominal, scope) = (|| subject.model(log), subject.scope(log));
    let (along, shooting) = (subject.fitted_along(log)?, subject.shooting(log, &subject.noise(log))?);
    let search = Search::new(&shooting, &nominal, &[], as_terms(&along), &|_| ());
    let sensors = Kinematics::of(log);
    let ordinary = base::ordinary_with_sensors(&scope, &sensors);
    let (shooting, in_sensors) = base::disturbed(log, subject, &search, &ordinary)?;
    let search = Search::new(&shooting, &nominal, &[], as_terms(&along), &|_| ());
    let base = base::fitted(&search, &ordinary, Some(&in_sensors)).fit;
    let beside = sensors.informed(Fitted::beside(&scope, |axis| base::is_trimmed(&base.terms, axis)));
    let terms = with_asked(base.terms, &beside, asked);
    let fit = fitted_to_all(&shooting, &nominal, terms);
    let mut sizes = fit.with_parts_left_out(&shooting, &nominal, &shooting.log.in_use()).sizes(asked);
    let of_rows_s = of_rows_std_s(&shooting.log.commands);
    let delays = asked.iter().zip(&mut sizes).filter(|((name, _), _)| *name == "actuation_delay");
    for delay in delays.filter_map(|(_, size)| size.as_mut()?.get_mut("delay_s")) {
        delay.std = delay.std.hypot(of_rows_s);
    }
    Ok(sizes)
}

/// Some terms, and what is asked for beside them.
fn with_asked<'e>(mut terms: Vec<Term<'e>>, catalogue: &'e [Fitted], asked: &[Asked]) -> Vec<Term<'e>> {
    for of in asked {
        let effect = catalogue.iter().find(|effect| is_asked(effect, of));
        let start = |effect: &Fitted| effect.starts(&Hints::default()).into_iter().next();
        let is_new = !terms.iter().any(|term| is_asked(term.effect, of));
        let new = effect.filter(|_| is_new).and_then(|effect| Some(Term { effect, values: start(effect)? }));
        terms.extend(new);
    }
    terms
}

fn is_asked(effect: &Fitted, (name, axis): &Asked) -> bool {
    effect.name() == *name && effect.axis() == *axis
}

impl Fit<'_> {
    fn sizes(&self, asked: &[Asked]) -> Vec<Option<Size>> {
        let place = |of: &Asked| self.terms.iter().position(|term| is_asked(term.effect, of));
        asked.iter().map(|of| Some(estimates(self, place(of)?, MODEL_ERROR))).collect()
    }
}

/// The terms fitted to every window, from their values on.
fn fitted_to_all<'e>(shooting: &Shooting<'_>, nominal: Nominal<'_>, terms: Vec<Term<'e>>) -> Fit<'e> {
    let all = shooting.log.in_use();
    let driven = shooting.log.drive(model_of(nominal, &terms));
    let mut starts = shooting.log.measured_starts(&driven.model);
    shooting.settle(&driven, &all, &mut starts);
    fit(shooting, nominal, terms, &starts, &all)
}
