//! A log whose controller is known: what of the disagreement is the controller's, and the closed loop before and after.

use serde::Serialize;

use super::controller::{self, Examination};
use super::progress::Observer;
use super::{Diagnosis, Effort, Known, Subject, Verdict, diagnose_observed, extended_model};
use crate::closed_loop::{ClosedLoopDeviation, LogRefused, closed_loop};
use crate::controller_file::ControllerChoice;
use crate::log::Log;
use crate::model::VehicleModel;

/// The thesis' table 5.1 before and after.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClosedLoops {
    /// The nominal model flown by the modelled controller.
    pub nominal: ClosedLoopDeviation,
    /// The model with the findings, flown by the controller with its own.
    pub extended: ClosedLoopDeviation,
}

/// Diagnoses the log of a vehicle that a known controller flew; what else is known is in the model already.
///
/// # Errors
/// As [`diagnose_observed`] and [`crate::comparison::compare`].
pub fn diagnose_flown_by(
    log: &Log,
    model: &VehicleModel,
    choice: ControllerChoice,
    known: &Known,
    effort: Effort,
    observer: Observer<'_>,
) -> Result<Diagnosis, LogRefused> {
    let mut answer = diagnose_observed(log, &Subject::Vehicle(model), known, effort, observer)?;
    let examination = controller::examine(log, model, choice)?;
    answer.closed_loop = closed_loops(log, model, &answer, choice, examination.corrected)?;
    add(&mut answer, examination);
    Ok(answer)
}

fn closed_loops(
    log: &Log,
    model: &VehicleModel,
    answer: &Diagnosis,
    choice: ControllerChoice,
    corrected: ControllerChoice,
) -> Result<Option<ClosedLoops>, LogRefused> {
    let deviation = |model: &VehicleModel, choice| {
        Ok::<_, LogRefused>(closed_loop(log, model, choice)?.map(|closed_loop| closed_loop.deviation))
    };
    let Ok(extended) = extended_model(model, answer) else { return Ok(None) };
    let both = (deviation(model, choice)?, deviation(&extended, corrected)?);
    Ok(match both {
        (Some(nominal), Some(extended)) => Some(ClosedLoops { nominal, extended }),
        _ => None,
    })
}

/// Adds what the controller has to do with it.
fn add(answer: &mut Diagnosis, examination: Examination) {
    answer.rejected.retain(|rejected| rejected.effect != "controller_mismatch");
    answer.rejected.extend(examination.rejected);
    let found = !examination.findings.is_empty();
    // held-out windows hold no information about the controller
    answer.gain.findings_interval_pct.extend(examination.findings.iter().map(|_| None));
    answer.findings.extend(examination.findings);
    let is_whole = examination.remainder.is_empty();
    answer.verdict = match (answer.verdict, found, is_whole) {
        (none @ (Verdict::NotAModel | Verdict::NotShown), ..) => none,
        (Verdict::NoDiscrepancy, false, true) => Verdict::NoDiscrepancy,
        (Verdict::NoDiscrepancy | Verdict::Explained, true, true) => Verdict::Explained,
        (Verdict::Explained, false, true) => Verdict::Explained,
        (Verdict::NoDiscrepancy | Verdict::UnknownEffect, false, _) => Verdict::UnknownEffect,
        _ => Verdict::PartlyExplained,
    };
    let signature = &mut answer.unexplained.signature;
    if !is_whole {
        let between = if signature.is_empty() { "" } else { "; " };
        signature.push_str(&format!("{between}{}", examination.remainder));
    }
}
