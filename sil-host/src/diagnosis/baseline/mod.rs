//! One flight against normal flights of the same vehicle: only what is different is reported.
//!
//! ```text
//! each log -> numbers: what steady flight needs of the motors (steady), the base model's gains, lateness, biases
//!                      (base_numbers)
//! normal flights -> mean and spread between flights (normal) -> departures of the flight in question
//! causes: how each changes all numbers together -> choice: beyond chance? the likeliest, and what is about as likely
//! ```
//!
//! A model's own errors are in all flights alike and drop out, and so does what is ordinary about the airframe. What
//! remains is held against how much normal flights differ, for propellers that were seated anew change a vehicle too.

mod answer;
mod base_numbers;
mod causes;
mod choice;
mod normal;
mod numbers;
mod steady;
mod wording;

#[cfg(test)]
mod tests;

use super::known::Known;
use super::progress::{Observer, Progress};
use super::{LogSummary, Subject, Verdict};
use crate::log::Log;
use crate::prediction::NotPredictable;
pub use answer::{Baseline, BaselineDiagnosis, Compared, Difference};
use causes::Departures;
use normal::{Normal, USUAL_FLIGHTS};
use numbers::Flight;
pub use numbers::NumberOf;
use wording::Wording;

/// Commands around which nothing but its proportion to lift is known, where no model says more.
const PROPORTIONAL: fn(f64) -> f64 = |command| command;

/// Why flights can't be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotComparable {
    /// One of the logs can't be used.
    #[error("{path}: {source}")]
    Log {
        /// As the caller named it.
        path: String,
        /// What is wrong with it.
        source: NotPredictable,
    },
    /// No log of a normal flight.
    #[error("no log of a normal flight to compare with")]
    NoBaseline,
    /// The logs have nothing in common.
    #[error("{path} has no number in common with all logs of normal flights")]
    NothingInCommon {
        /// The log in question.
        path: String,
    },
}

/// Compares a flight with normal flights of the same vehicle.
///
/// # Errors
/// A log has no window or no commands for its rig; or there is nothing to compare.
pub fn diagnose_against(
    log: &Log,
    normal: &[Log],
    subject: &Subject<'_>,
    known: &Known,
    observer: Observer<'_>,
) -> Result<BaselineDiagnosis, NotComparable> {
    let total = normal.len() + 1;
    let flight = |(done, log): (usize, &Log)| {
        observer(Progress::Comparing { done, total });
        Flight::of(log, subject).map_err(|source| NotComparable::Log { path: log.path.clone(), source })
    };
    let flights: Vec<Flight> = normal.iter().enumerate().map(flight).collect::<Result<_, _>>()?;
    if flights.is_empty() {
        return Err(NotComparable::NoBaseline);
    }
    let suspect = flight((normal.len(), log))?;
    compare(LogSummary::of(log), &suspect, &flights, subject, known)
}

fn compare(
    log: LogSummary,
    suspect: &Flight,
    flights: &[Flight],
    subject: &Subject<'_>,
    known: &Known,
) -> Result<BaselineDiagnosis, NotComparable> {
    let normal = Normal::of(flights, suspect);
    if normal.numbers.is_empty() {
        return Err(NotComparable::NothingInCommon { path: suspect.path.clone() });
    }
    let by = |mean: f64, of: NumberOf| suspect.get(of).map_or(0.0, |own| own.value - mean);
    let collectives: Option<Vec<f64>> = flights.iter().map(|flight| flight.collective).collect();
    let departures = Departures {
        normal: &normal,
        by: normal.numbers.iter().map(|number| by(number.mean, number.of)).collect(),
        collective: collectives.map(|all| all.iter().sum::<f64>() / all.len() as f64).filter(|mean| *mean > 0.0),
        knows_motors: suspect.knows_motors && flights.iter().all(|flight| flight.knows_motors),
    };
    let choice = choice::choose(&departures, known);
    let of_model = |command: f64| match subject {
        Subject::Vehicle(model) => model.propulsion.lift_n(command.min(1.0)),
        Subject::Axes => PROPORTIONAL(command),
    };
    let wording = Wording { departures: &departures, lift: &of_model };
    let findings: Vec<Difference> = choice.found.iter().map(|chosen| wording.difference(chosen)).collect();
    let verdict = match (findings.is_empty(), choice.leaves_something()) {
        (true, false) => Verdict::NoDiscrepancy,
        (true, true) => Verdict::UnknownEffect,
        (false, false) => Verdict::Explained,
        (false, true) => Verdict::PartlyExplained,
    };
    let compared = normal.numbers.iter().zip(&departures.by).map(|(number, by)| Compared {
        of: number.of,
        normal: number.mean,
        spread: number.spread,
        value: number.mean + by,
        z: by / number.std,
    });
    let baseline = Baseline {
        logs: flights.iter().map(|flight| flight.path.clone()).collect(),
        usual_spread_as_flights: USUAL_FLIGHTS,
        degrees_of_freedom: normal.freedom,
        numbers: compared.collect(),
        looks: choice.looks,
        chance: choice.chance,
    };
    let nearest = choice.nearest.as_ref().map(|chosen| wording.difference(chosen));
    Ok(BaselineDiagnosis { log, verdict, known: known.facts().to_vec(), baseline, findings, nearest })
}
