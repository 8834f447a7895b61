//! A bench whose pitch is free (ANT-X): what the diagnosis adds to a rigid body with one input gain.

use std::fmt;
use std::path::Path;

use sil_host::diagnosis::{Diagnosis, Subject, diagnose};

use super::{load, name_of};

/// A run and the answer to it.
pub struct Run {
    /// Its log's name.
    pub name: String,
    /// What `sil diagnose` says.
    pub answer: Diagnosis,
}

impl Run {
    /// Diagnoses one log.
    ///
    /// # Panics
    /// It can't be read.
    pub fn of(path: &Path) -> Run {
        let answer = diagnose(&load(path, "antx"), &Subject::Axes).expect("a log with windows");
        Run { name: name_of(path), answer }
    }
}

impl fmt::Display for Run {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let errors = self.answer.prediction_error;
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let (pitch, q) = (
            [errors.nominal.pitch_deg, errors.extended.pitch_deg].map(number),
            [errors.nominal.q_deg_s, errors.extended.q_deg_s].map(number),
        );
        let findings: Vec<String> = self.answer.findings.iter().map(told).collect();
        let findings = findings.join("; ");
        writeln!(out, "| {} | {:.2}, {:.2} | {:.1}, {:.1} | {findings} |", self.name, pitch[0], pitch[1], q[0], q[1])
    }
}

/// A finding as name and numbers.
fn told(finding: &sil_host::diagnosis::Finding) -> String {
    let parameters = finding.parameters.iter().map(|(name, estimate)| {
        let digits = estimate.decimals().unwrap_or(4);
        format!("{name} {:.digits$} +- {:.digits$}", estimate.value, estimate.std)
    });
    let parameters: Vec<String> = parameters.collect();
    format!("{}: {}", finding.effect, parameters.join(", "))
}
