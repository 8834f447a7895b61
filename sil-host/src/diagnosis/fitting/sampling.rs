//! Whether commands were lost between the rows of a log (`prediction::lost_commands`). Two hypotheses are tested: its
//! commands were held from row to row, or they are every n-th of a controller at the usual 400 Hz.
//!
//! Which of both is true shows in time: held commands are late by half a row. The likelihood decides, with what was
//! found under held commands, and with as much unknown acceleration under either as suits it; a delay that only undoes
//! the faster controller is evidence for held ones. Beside a true delay or lag the likelihood may not decide: then
//! commands that were held leave white residuals, and lost ones do not.

use crate::diagnosis::fitting::fit::{Fit, Term, as_terms, fit, model_of};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::diagnosis::found::Found;
use crate::diagnosis::remainder::structure::{Whiteness, whiteness};
use crate::diagnosis::search::{Candidate, Search};
use crate::log::Log;
use crate::prediction::body::State;
use crate::prediction::lost_commands::{USUAL_CONTROL_RATE_HZ, are_lost, smooth, unknown_acceleration};
use crate::prediction::model::Model;
use crate::prediction::windowed_log::Driven;
use crate::prediction::{NotPredictable, Part, Subject};

/// Fall of twice the logarithm of the likelihood from which on a faster controller is taken to have flown.
const MARGIN: f64 = 6.0;
/// Shares of the unknown acceleration under which the two hypotheses are held against each other. The search takes the
/// whole: the likeliest share, about a half, is too small, for the noise in a row's command is that of the gyro in the
/// same row, and the likelihood does not see their common part; the correlation from row to row does.
const SHARES: [f64; 7] = [0.0, 0.25, 0.35, 0.5, 0.7, 1.0, 1.4];

/// A log under both hypotheses.
pub(in crate::diagnosis) struct Sampled<'l> {
    held: Shooting<'l>,
    /// None for logs as fast as their controllers are.
    alternatives: Option<Alternatives<'l>>,
    /// True where the controller's rate is known, and nothing has to be decided.
    is_known: bool,
}

/// What is held against each other, each with what commands lost between rows would leave unknown.
struct Alternatives<'l> {
    held: Shooting<'l>,
    faster: Shooting<'l>,
}

impl<'l> Sampled<'l> {
    /// The controller's rate, Hz, where it is known; else it is the log's or the usual one, as the log shows.
    ///
    /// # Errors
    /// As [`Subject::windowed`].
    pub(in crate::diagnosis) fn new(
        log: &'l Log,
        subject: &Subject<'_>,
        control_rate_hz: Option<f64>,
    ) -> Result<Sampled<'l>, NotPredictable> {
        let noise = subject.noise(log);
        let windowed = || subject.windowed(log, &noise);
        let held = Shooting::new(windowed()?);
        let rate_hz = control_rate_hz.unwrap_or(USUAL_CONTROL_RATE_HZ);
        let alternatives = if are_lost(log, rate_hz) {
            // what a lost command leaves unknown goes with the gain that it acts by
            let model = model_fitted_to(log, &held, subject)?;
            let unknown = unknown_acceleration(&held.log, &model, rate_hz);
            let smooth = smooth(&held.log.commands, rate_hz);
            Some(Alternatives {
                held: Shooting::new(windowed()?.with_lost(unknown.clone())),
                faster: Shooting::new(windowed()?.commanded(smooth).with_lost(unknown)),
            })
        } else {
            None
        };
        Ok(Sampled { held, alternatives, is_known: control_rate_hz.is_some() })
    }

    /// Searches under held commands, and again where the faster controller explains the log better.
    pub(in crate::diagnosis) fn search<'e>(
        &'e self,
        of: impl Fn(&'e Shooting<'e>) -> Search<'e>,
    ) -> (Search<'e>, Found<'e>) {
        let (search, found) = self.commanded(&of);
        let found = found.unwrap_or_else(|| search.run());
        (search, found)
    }

    /// The same for a log of which nothing is to be found yet: under which commands it is, and the model as it stands,
    /// fitted to all windows but those of the report. It is searched only where that decides between the commands.
    pub(in crate::diagnosis) fn unsearched<'e>(
        &'e self,
        of: impl Fn(&'e Shooting<'e>) -> Search<'e>,
    ) -> (Search<'e>, Fit<'e>) {
        let (search, found) = match self.alternatives {
            Some(_) => self.commanded(&of),
            None => (of(&self.held), None),
        };
        let nominal = found.map_or_else(|| search.again(&search.nominal()), |found| found.refitted.nominal);
        (search, nominal)
    }

    /// The search under the commands that explain the log best, and what was found where these are held ones.
    fn commanded<'e>(&'e self, of: &impl Fn(&'e Shooting<'e>) -> Search<'e>) -> (Search<'e>, Option<Found<'e>>) {
        // under held commands nothing is taken for noise: what is there is seen sharply
        let search = of(&self.held);
        let found = search.run();
        match self.under_faster(of, &search, &found.chosen) {
            Some(faster) => (faster, None),
            None => (search, Some(found)),
        }
    }

    /// The model as it stands, what it leaves to each log fitted, under the commands that explain the log best with it.
    pub(in crate::diagnosis) fn nominal<'e>(
        &'e self,
        of: impl Fn(&'e Shooting<'e>) -> Search<'e>,
    ) -> (Search<'e>, Candidate<'e>) {
        let search = of(&self.held);
        let nominal = search.nominal();
        let Some(Alternatives { held, faster }) = &self.alternatives else { return (search, nominal) };
        let (held, faster) = (of(held), of(faster));
        let terms = &nominal.fit.terms;
        let unlikeliness = |of: &Search<'e>| unlikeliness_in_disturbances(of, terms);
        if self.is_known || unlikeliness(&faster) + MARGIN < unlikeliness(&held) {
            let nominal = faster.nominal();
            return (faster, nominal);
        }
        (search, nominal)
    }

    /// The search under the faster controller's commands, where these explain the log better than held ones, under
    /// which some effects were chosen.
    fn under_faster<'e>(
        &'e self,
        of: &impl Fn(&'e Shooting<'e>) -> Search<'e>,
        search: &Search<'e>,
        chosen: &Candidate<'e>,
    ) -> Option<Search<'e>> {
        let Alternatives { held, faster } = self.alternatives.as_ref()?;
        let (held, faster) = (of(held), of(faster));
        if self.is_known {
            return Some(faster);
        }
        let terms = &chosen.fit.terms;
        // late commands that were held look like a faster controller's: lateness has to be better than none
        let not_late: Vec<Term<'e>> = terms.iter().filter(|term| !term.effect.is_late()).cloned().collect();
        let as_found = unlikeliness(&held, terms);
        let without = if not_late.len() < terms.len() { unlikeliness(&held, &not_late) } else { as_found };
        let under_faster = unlikeliness(&faster, terms);
        let is_undecided = (as_found - under_faster).abs() < MARGIN;
        let is_faster = under_faster + MARGIN < as_found.min(without) || is_undecided && !is_white(search, chosen);
        is_faster.then_some(faster)
    }
}

/// The model as it stands, what it leaves to each log fitted under held commands.
fn model_fitted_to(log: &Log, held: &Shooting<'_>, subject: &Subject<'_>) -> Result<Model, NotPredictable> {
    let nominal = || subject.model(log);
    let fitted_along = subject.fitted_along(log)?;
    let starts = held.log.measured_starts(&nominal());
    let fit = fit(held, &nominal, as_terms(&fitted_along), &starts, &held.log.part(&[Part::Fit]));
    Ok(model_of(&nominal, &fit.terms))
}

/// Is what the chosen effects leave of the training windows white?
fn is_white<'e>(search: &Search<'e>, chosen: &Candidate<'e>) -> bool {
    let fit = &chosen.fit;
    let driven = search.shooting.log.drive(model_of(search.nominal, &fit.terms));
    whiteness(search.shooting, &driven, &search.training, &fit.starts).iter().all(Whiteness::is_white)
}

/// Twice the negative logarithm of the likelihood of what some effects leave of the training windows once they are
/// fitted.
fn unlikeliness<'e>(search: &Search<'e>, terms: &[Term<'e>]) -> f64 {
    let (driven, starts) = fitted(search, terms);
    search.shooting.unlikeliness(&driven, &search.training, &starts, &SHARES)
}

/// The same of a model that may lack much: what it lacks is taken for a disturbance, as strong as suits it, so that
/// only what is quick counts, as the time at which commands act.
fn unlikeliness_in_disturbances<'e>(search: &Search<'e>, terms: &[Term<'e>]) -> f64 {
    let (driven, starts) = fitted(search, terms);
    search.shooting.least_unlikeliness(&driven, &search.training, &starts, &SHARES)
}

fn fitted<'e>(search: &Search<'e>, terms: &[Term<'e>]) -> (Driven, Vec<State>) {
    let starts = search.settled_starts(terms);
    let fit = fit(search.shooting, search.nominal, terms.to_vec(), &starts, &search.training);
    (search.shooting.log.drive(model_of(search.nominal, &fit.terms)), fit.starts)
}
