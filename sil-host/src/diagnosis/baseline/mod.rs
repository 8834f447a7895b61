//! One flight against normal flights of the same vehicle: only what is different is reported.
//!
//! ```text
//! each log -> numbers: what steady flight needs of the motors (steady), the base model's gains, lateness, biases
//!                      (base_numbers), what gyro, attitude and commands say of each other without a model
//!                      (log::sanity::figures)
//! normal flights -> as at this flight's battery voltage (battery) -> mean and spread between flights (normal)
//!                -> departures of the flight in question
//! causes: how each changes all numbers together -> choice: beyond chance? the likeliest, and what is about as likely
//! ```
//!
//! A model's own errors are in all flights alike and drop out, and so does what is ordinary about the airframe. What
//! remains is held against how much normal flights differ, for propellers that were seated anew change a vehicle too.

mod answer;
mod base_numbers;
mod battery;
mod causes;
mod choice;
mod flight_numbers;
mod normal;
mod numbers;
mod same_flight;
mod steady;
mod wording;

#[cfg(test)]
mod tests;

use super::known::Known;
use super::progress::{Observer, Progress};
use super::{Estimate, Subject, Verdict};
use crate::log::Log;
use crate::prediction::NotPredictable;
pub use answer::{Baseline, BaselineDiagnosis, Compared, Difference};
pub use battery::AtVoltage;
use causes::Departures;
pub use flight_numbers::FlightNumbers;
pub use normal::BetweenFlights;
use normal::{Normal, USUAL_FLIGHTS};
pub use numbers::NumberOf;
pub(super) use steady::steady_collective;
use wording::Wording;
pub use wording::motor_place;

/// Commands around which nothing but its proportion to lift is known, where no model says more.
const PROPORTIONAL: fn(f64) -> f64 = |command| command;

/// What is known beside the logs.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// Numbers that have not changed, or are held.
    pub known: &'a Known,
    /// What happened to the vehicle besides what is sought.
    pub between: BetweenFlights,
}

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

/// Compares a flight with normal flights of the same vehicle; where it is another record of one of them, with that.
///
/// # Errors
/// A log has no window or no commands for its rig; or there is nothing to compare.
pub fn diagnose_against(
    log: &Log,
    normal: &[Log],
    subject: &Subject<'_>,
    given: Given<'_>,
    observer: Observer<'_>,
) -> Result<BaselineDiagnosis, NotComparable> {
    if let Some((record, other)) = normal.iter().find_map(|normal| Some((same_flight::aligned(log, normal)?, normal))) {
        let of_record = |record: &Log, log: &Log| {
            FlightNumbers::of_record(record, subject)
                .map_err(|source| NotComparable::Log { path: log.path.clone(), source })
        };
        let given = Given { between: BetweenFlights::SameFlight, ..given };
        return compare_flights(&of_record(&record[0], log)?, &[of_record(&record[1], other)?], subject, given);
    }
    let total = normal.len() + 1;
    let numbers = |(done, log): (usize, &Log)| {
        observer(Progress::Comparing { done, total });
        FlightNumbers::of(log, subject).map_err(|source| NotComparable::Log { path: log.path.clone(), source })
    };
    let flights: Vec<FlightNumbers> = normal.iter().enumerate().map(numbers).collect::<Result<_, _>>()?;
    compare_flights(&numbers((normal.len(), log))?, &flights, subject, given)
}

/// The normal flights that serve: where the one in question is steady, those that are too, if there are any. And the
/// logs whose commands stray too much.
fn comparable<'f>(suspect: &FlightNumbers, flights: &'f [FlightNumbers]) -> (Vec<&'f FlightNumbers>, Vec<String>) {
    let steady: Vec<&FlightNumbers> = flights.iter().filter(|flight| flight.is_steady).collect();
    let not_steady = std::iter::once(suspect).chain(flights).filter(|flight| !flight.is_steady);
    let not_steady = not_steady.map(|flight| flight.log.path.clone()).collect();
    let serve = if suspect.is_steady && !steady.is_empty() { steady } else { flights.iter().collect() };
    (serve, not_steady)
}

/// The same of flights whose numbers are there.
///
/// # Errors
/// There is nothing to compare.
pub fn compare_flights(
    suspect: &FlightNumbers,
    flights: &[FlightNumbers],
    subject: &Subject<'_>,
    given: Given<'_>,
) -> Result<BaselineDiagnosis, NotComparable> {
    if flights.is_empty() {
        return Err(NotComparable::NoBaseline);
    }
    let (flights, not_steady) = comparable(suspect, flights);
    let normal = Normal::of(&flights, suspect, given.between);
    if normal.numbers.is_empty() {
        return Err(NotComparable::NothingInCommon { path: suspect.log.path.clone() });
    }
    let by = |mean: f64, of: NumberOf| suspect.get(of).map_or(0.0, |number| of.difference(number.own.value, mean));
    let of_model = |command: f64| match subject {
        Subject::Vehicle(model) => model.propulsion.lift_n(command.min(1.0)),
        Subject::Axes | Subject::Bench(_) => PROPORTIONAL(command),
    };
    let collective = |flight: &&FlightNumbers| {
        let own = Estimate { value: flight.collective?, std: 0.0 };
        Some(flight.held(NumberOf::Collective, own, normal.at_voltage).value)
    };
    let collectives: Option<Vec<f64>> = flights.iter().map(collective).collect();
    let departures = Departures {
        normal: &normal,
        by: normal.numbers.iter().map(|number| by(number.mean, number.of)).collect(),
        collective: collectives.map(|all| all.iter().sum::<f64>() / all.len() as f64).filter(|mean| *mean > 0.0),
        is_held: subject.is_held(),
        knows_motors: suspect.knows_motors && flights.iter().all(|flight| flight.knows_motors),
        lift: &of_model,
    };
    let choice = choice::choose(&departures, given.known);
    let wording = Wording { departures: &departures };
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
        logs: flights.iter().map(|flight| flight.log.path.clone()).collect(),
        between: given.between,
        usual_spread_as_flights: USUAL_FLIGHTS,
        degrees_of_freedom: normal.freedom,
        at_voltage: normal.at_voltage,
        not_steady,
        numbers: compared.collect(),
        looks: choice.looks,
        chance: choice.chance,
    };
    let nearest = choice.nearest.as_ref().map(|chosen| wording.difference(chosen));
    let log = suspect.log.clone();
    Ok(BaselineDiagnosis { log, verdict, known: given.known.facts().to_vec(), baseline, findings, nearest })
}
