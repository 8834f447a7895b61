//! What a log excites: the information that it holds on the basic parameters of each axis and on those of the findings.
//!
//! The information matrix J' J (J: whitened sensitivities of all windows at the fit, what the windows' start states
//! take eliminated) says how well parameters can be determined: its inverse is the covariance of the best estimate
//! (Cramer and Rao). Parameters have different units, so each is scaled to have an information of one when all others
//! are known; the result is the matrix of correlations between sensitivities, and its condition number, the ratio of
//! its largest to its least eigenvalue, is 1 where each parameter leaves a trace of its own, and large where some leave
//! traces that look alike. How strong the traces are is separate from that, as standard deviations.

use serde::Serialize;

use crate::diagnosis::fitted::{Fitted, per_unit_inertia};
use crate::diagnosis::fitting::eigen;
use crate::diagnosis::fitting::fit::{Term, model_of, regular};
use crate::diagnosis::fitting::shifted::shifted_models;
use crate::diagnosis::found::Found;
use crate::diagnosis::search::Search;
use crate::statistics::Cholesky;

/// Effects whose parameters make up the motion of any axis: moment and stiffness, damping, inertia; and the way from
/// command to force.
const BASIC: [&str; 4] = ["spring", "viscous_friction", "inertia_error", "actuation_delay"];
/// Above this condition number two traces look alike: a correlation of 0.998.
const ALIKE: f64 = 1000.0;
/// An axis whose inertia (or input gain, relative) could not be determined more closely than this was hardly moved by
/// its command.
const UNMOVED: f64 = 0.05;
/// Share of a vector that makes a parameter a part of it.
const PART_MIN: f64 = 0.3;

/// The information of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Excitation {
    /// Of the basic parameters' scaled information matrix; none where the log holds no information on any.
    pub condition_number: Option<f64>,
    /// Of the findings' parameters alone; none without findings.
    pub findings_condition_number: Option<f64>,
    /// How closely each basic parameter could be determined.
    pub parameters: Vec<Excited>,
    /// What that means, for a person: what the log does not excite or cannot separate; empty where nothing is amiss.
    pub weaknesses: Vec<String>,
}

/// One basic parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Excited {
    /// Its effect's name in docs/effects.md.
    pub effect: &'static str,
    /// Its axis.
    pub axis: Option<&'static str>,
    /// Its name.
    pub parameter: &'static str,
    /// Standard deviation that this log allows if all others are known; none where it leaves no trace.
    pub std_alone: Option<f64>,
    /// The same if all are fitted together.
    pub std_together: Option<f64>,
    /// Its value in the fit.
    #[serde(skip)]
    value: f64,
}

/// Looks at all windows of a log, at the fit.
pub(in crate::diagnosis) fn excitation(search: &Search<'_>, found: &Found<'_>) -> Excitation {
    let chosen = &found.refitted.chosen;
    let findings = chosen.terms[search.always.len()..].to_vec();
    let is_found = |effect: &Fitted| findings.iter().any(|term| term.effect.is_the_same(effect));
    let mut basic: Vec<Term<'_>> = search.always.clone();
    let is_along = |effect: &Fitted| search.always.iter().any(|term| term.effect.is_the_same(effect));
    let basics = search.catalogue.iter().filter(|effect| BASIC.contains(&effect.name()) && !is_along(effect));
    for effect in basics {
        if is_found(effect) {
            basic.extend(findings.iter().find(|term| term.effect.is_the_same(effect)).cloned());
        } else {
            let values = effect.unknowns().iter().map(|parameter| parameter.nominal).collect();
            basic.push(Term { effect, values });
        }
    }
    let others: Vec<Term<'_>> = findings.iter().filter(|term| !BASIC.contains(&term.effect.name())).cloned().collect();
    let information = information(search, found, &others, &basic);
    let is_vehicle = search.shooting.log.is_vehicle();
    let parameters = excited(&basic, &information, is_vehicle);
    let (condition_number, alike) = condition(&information);
    let findings_condition_number = (!findings.is_empty())
        .then(|| condition(&self::information(search, found, &search.always, &findings)).0)
        .flatten();
    let weaknesses = weaknesses(&parameters, condition_number, &alike);
    Excitation { condition_number, findings_condition_number, parameters, weaknesses }
}

/// The information matrix of some terms' parameters, `known` ones in the model beside them; rows one behind the other.
fn information(search: &Search<'_>, found: &Found<'_>, known: &[Term<'_>], asked: &[Term<'_>]) -> Vec<f64> {
    let shooting = search.shooting;
    let terms: Vec<Term<'_>> = known.iter().chain(asked).cloned().collect();
    let driven = shooting.log.drive(model_of(search.nominal, &terms));
    let shifted = shifted_models(shooting, search.nominal, &terms, known.len());
    let all = shooting.log.in_use();
    let linear = shooting.linearise(&driven, &shifted, &all, &found.refitted.chosen.starts, None);
    linear.normal().matrix
}

fn side(matrix: &[f64]) -> usize {
    (0..).find(|size: &usize| size * size >= matrix.len()).unwrap_or_default()
}

fn excited(terms: &[Term<'_>], information: &[f64], is_vehicle: bool) -> Vec<Excited> {
    let size = side(information);
    let factor = Cholesky::new(&regular(information, size, 0.0), size);
    let covariance = factor.map(|factor| factor.inverse());
    let parameters =
        terms.iter().flat_map(|term| term.effect.unknowns().iter().zip(&term.values).map(move |p| (term, p)));
    parameters
        .enumerate()
        .map(|(i, (term, (parameter, value)))| {
            let own = information[i * size + i];
            let together = covariance.as_ref().map(|covariance| covariance[i * size + i].max(0.0).sqrt());
            Excited {
                effect: term.effect.name(),
                axis: term.effect.axis().map(crate::axis::Axis::name),
                parameter: if is_vehicle { parameter.name } else { per_unit_inertia(parameter.name) },
                std_alone: (own > 0.0).then(|| 1.0 / own.sqrt()),
                std_together: together.filter(|_| own > 0.0),
                value: *value,
            }
        })
        .collect()
}

/// Condition number of the scaled matrix, and which parameters make up its least eigenvector; parameters without a
/// trace are left out.
fn condition(information: &[f64]) -> (Option<f64>, Vec<usize>) {
    let size = side(information);
    let kept: Vec<usize> = (0..size).filter(|i| information[i * size + i] > 0.0).collect();
    let scaled: Vec<f64> = kept
        .iter()
        .flat_map(|i| kept.iter().map(move |j| (*i, *j)))
        .map(|(i, j)| information[i * size + j] / (information[i * size + i] * information[j * size + j]).sqrt())
        .collect();
    let eigen = eigen::symmetric(&scaled, kept.len());
    let (Some((least, vector)), Some((largest, _))) = (eigen.first(), eigen.last()) else { return (None, Vec::new()) };
    let parts = kept.iter().zip(vector).filter(|(_, part)| part.abs() > PART_MIN).map(|(i, _)| *i).collect();
    // rounding leaves a least eigenvalue of about 1e-16
    (Some(largest / least.max(1e-16)), parts)
}

fn weaknesses(parameters: &[Excited], condition_number: Option<f64>, alike: &[usize]) -> Vec<String> {
    let mut sentences = Vec::new();
    for of in parameters.iter().filter(|of| ["inertia_error", "input_gain"].contains(&of.effect)) {
        let axis = of.axis.unwrap_or_default();
        let what = if of.effect == "input_gain" { "its input gain" } else { "its inertia" };
        match of.std_together.map(|std| std / of.value.abs()) {
            None => sentences
                .push(format!("In this log the {axis} command has no effect on {axis}: {what} cannot be determined.")),
            Some(relative) if relative > 1.0 => sentences
                .push(format!("In this log what the {axis} command moves is lost in the noise: {what} is unknown.")),
            Some(relative) if relative > UNMOVED => sentences.push(format!(
                "In this log the command hardly moves {axis}: {what} can be determined to {:.0} % at best (one \
                 standard deviation).",
                100.0 * relative
            )),
            Some(_) => {}
        }
    }
    if let Some(number) = condition_number.filter(|number| *number > ALIKE) {
        let names: Vec<String> = alike.iter().map(|i| parameters[*i].in_words()).collect();
        sentences.push(format!(
            "In this log {} have nearly the same effect (condition number {number:.0}): together they can be \
             determined, each alone hardly.",
            names.join(" and ")
        ));
    }
    sentences
}

impl Excited {
    /// "stiffness_nm_rad of roll".
    fn in_words(&self) -> String {
        match self.axis {
            Some(axis) => format!("{} of {axis}", self.parameter),
            None => self.parameter.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_condition_number_knows_collinear_parameters_and_no_units() {
        // correlation 0.8 between two parameters of very different units, a third of its own, a fourth without a trace
        let sizes = [1e-3, 1e4, 1.0, 0.0];
        let correlation = |i: usize, j: usize| match (i, j) {
            (0, 1) | (1, 0) => 0.8,
            _ => f64::from(u8::from(i == j)),
        };
        let matrix: Vec<f64> = (0..16).map(|k| sizes[k / 4] * sizes[k % 4] * correlation(k / 4, k % 4)).collect();
        let (number, alike) = condition(&matrix);
        // eigenvalues 1.8, 1 and 0.2
        assert!((number.unwrap() - 9.0).abs() < 1e-12);
        assert_eq!(alike, [0, 1]);
        assert_eq!(condition(&[]), (None, Vec::new()));
    }
}
