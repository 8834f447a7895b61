//! What a simulation gets wrong, and why: given a measured log, show the error, name its cause, extend the model, measure the gain.
//!
//! ```text
//! log -> subject: commands, channels, windows -> noise
//!                       |
//!  effects (hypotheses) -> search: score -> fit (shooting: residuals, slopes, normal equations) -> held-out windows
//!                       |                          '-- prediction: actuation -> body -> sensor
//!                       v
//!        findings, rejected <- verdict <- structure: is anything left? <- accuracy: against an exact model
//! ```
//!
//! The model of the vehicle is the diagnosis' own (`prediction`, with another integrator than the plant's and the effects written
//! a second time), so that a mistake in either shows as a disagreement.

mod accuracy;
mod actuation;
mod body;
pub mod controller;
pub mod effects;
mod extension;
mod finding_json;
mod fit;
mod flown_by;
mod hints;
mod linear;
mod prediction;
mod residuals;
mod search;
mod sensor;
mod shooting;
mod structure;
mod subject;
mod verdict;

#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::fidelity::{ChannelErrors, FidelityError, SensorNoise, WINDOW_S};
use crate::log::Log;
pub use effects::Place;
use fit::{Term, model_of};
pub use flown_by::{ClosedLoops, diagnose_flown_by};
pub use residuals::ChannelResiduals;
use search::{Candidate, Found, Search};
use shooting::Shooting;
pub use subject::Subject;
pub use verdict::{Estimate, Finding, Rejected, Verdict};

/// Above this multiple of the noise floor an error is not explained.
const FLOOR_FACTOR_MAX: f64 = 1.3;

/// The answer to a log (CLI.md, "JSON of `sil diagnose`").
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagnosis {
    /// What was looked at.
    pub log: LogSummary,
    /// In one word.
    pub verdict: Verdict,
    /// Most important first.
    pub findings: Vec<Finding>,
    /// What was asked and denied.
    pub rejected: Vec<Rejected>,
    /// Over the held-out windows.
    pub prediction_error: PredictionErrors,
    /// The simulated closed loop against the log, before and after; none without a controller or references.
    pub closed_loop: Option<ClosedLoops>,
    /// What is left.
    pub unexplained: Unexplained,
    /// Which manoeuvre would tell apart what this log does not; empty where nothing is confounded.
    pub separating_experiment: String,
    /// What the models miss, row by row: the picture behind the numbers.
    #[serde(skip)]
    pub residuals: Vec<ChannelResiduals>,
}

/// The log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogSummary {
    /// As the caller named it.
    pub path: String,
    /// Rows.
    pub rows: usize,
    /// Time from first to last, s.
    pub duration_s: f64,
    /// Rows per second.
    pub rate_hz: f64,
}

/// Root mean square errors of the open-loop replay over the held-out windows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PredictionErrors {
    /// Length of a window, s.
    pub window_s: f64,
    /// Without any effect.
    pub nominal: ChannelErrors,
    /// With the findings.
    pub extended: ChannelErrors,
    /// Of an exact model.
    pub noise_floor: ChannelErrors,
}

/// What the findings leave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unexplained {
    /// Share of the nominal model's held-out squared error beyond the noise, %.
    pub variance_pct: f64,
    /// True if the residuals are white.
    pub white: bool,
    /// In words; empty where they are.
    pub signature: String,
}

/// Diagnoses a log.
///
/// # Errors
/// The log has no window, or no commands for its rig.
pub fn diagnose(log: &Log, subject: &Subject<'_>) -> Result<Diagnosis, FidelityError> {
    let noise = SensorNoise::of(log);
    let shooting = subject.shooting(log, &noise)?;
    let nominal = || subject.model();
    let catalogue = effects::catalogue(&subject.scope(log));
    let (training, held_out) = (shooting.part(false), shooting.part(true));
    let fitted_along = subject.fitted_along(log)?;
    let always = fitted_along.iter().map(|(gain, start)| Term { effect: gain, values: vec![*start] }).collect();
    let search = Search { shooting: &shooting, nominal: &nominal, catalogue: &catalogue, always, training, held_out };
    let found = search.run();
    Ok(answer(log, &shooting, &search, &found))
}

fn answer(log: &Log, shooting: &Shooting<'_>, search: &Search<'_>, found: &Found<'_>) -> Diagnosis {
    let driven = [&found.nominal, &found.chosen]
        .map(|candidate| shooting.drive(model_of(search.nominal, &candidate.fit.terms), None));
    let [nominal, extended] =
        driven.each_ref().map(|driven| accuracy::prediction_errors(shooting, driven, &search.held_out));
    let [nominal_errors, _] = verdict::channel_errors(&nominal);
    let [extended_errors, noise_floor] = verdict::channel_errors(&extended);
    let findings = verdict::findings(search, found);
    let unexplained = unexplained(search, found);
    let at_the_floor = accuracy::worst_ratio(&extended) <= FLOOR_FACTOR_MAX;
    let mut rejected = verdict::rejected(search, found);
    rejected.push(Rejected {
        effect: "controller_mismatch",
        axis: String::new(),
        reason: "no controller given".to_owned(),
    });
    let verdict = match (findings.is_empty(), unexplained.white && at_the_floor) {
        (true, true) => Verdict::NoDiscrepancy,
        (true, false) => Verdict::UnknownEffect,
        (false, true) => Verdict::Explained,
        (false, false) => Verdict::PartlyExplained,
    };
    Diagnosis {
        log: LogSummary {
            path: log.path.clone(),
            rows: log.rows(),
            duration_s: log.duration_s(),
            rate_hz: log.rate_hz(),
        },
        verdict,
        findings,
        rejected,
        prediction_error: PredictionErrors {
            window_s: WINDOW_S,
            nominal: nominal_errors,
            extended: extended_errors,
            noise_floor,
        },
        closed_loop: None,
        unexplained,
        separating_experiment: String::new(),
        residuals: residuals::of_models(shooting, &driven),
    }
}

fn unexplained(search: &Search<'_>, found: &Found<'_>) -> Unexplained {
    let shooting = search.shooting;
    let driven = shooting.drive(model_of(search.nominal, &found.chosen.fit.terms), None);
    let mut all: Vec<usize> = search.training.clone();
    all.extend(&search.held_out);
    let whiteness = structure::whiteness(shooting, &driven, &all, &found.chosen.fit.starts);
    let white = whiteness.iter().all(structure::Whiteness::is_white);
    let expected = shooting.degrees_of_freedom(&search.held_out);
    let beyond = |candidate: &Candidate<'_>| (candidate.held_out - expected).max(0.0);
    let nominal = beyond(&found.nominal);
    let variance_pct = if nominal > 0.0 { 100.0 * (beyond(&found.chosen) / nominal).min(1.0) } else { 0.0 };
    let worst = whiteness.iter().max_by(|a, b| a.deviation.total_cmp(&b.deviation));
    let signature = match worst {
        Some(worst) if !white => {
            let name = residuals::NAMES[worst.place];
            format!(
                "{name} misses its prediction by something that goes on from row to row ({:.0} sigma)",
                worst.deviation
            )
        }
        _ => String::new(),
    };
    Unexplained { variance_pct, white, signature }
}
