//! Which manoeuvre would separate effects that this log cannot separate.
//!
//! For a finding and its rival, an effect that this log cannot separate from it, each of the two models flies each
//! candidate in closed loop, without noise, under the cascade; the other one is fitted anew to that flight, so that it
//! gets every chance. Half of the sum of squares that it leaves, in units of this log's noise, is the difference of
//! log-likelihoods to be expected from such a flight if the first is true (Kullback and Leibler). The other may be on
//! another axis or motor than in this log: a flight is to settle the matter by itself. What counts is the mean of both
//! ways (Box and Hill, Technometrics 9, 1967): a rival of which the finding is a special case can never be less likely,
//! but it can turn out not to be needed. The plainest manoeuvre that is decisive is proposed, else the best one.

use rayon::prelude::*;
use shared_control::config::Controller;

use crate::controller_file::ControllerChoice;
use crate::diagnosis::evidence::manoeuvres::{Manoeuvre, manoeuvres};
use crate::diagnosis::extension::model_with_terms;
use crate::diagnosis::fitted::Fitted;
use crate::diagnosis::fitting::fit::{Term, fit_to_reach, model_of};
use crate::diagnosis::found::Found;
use crate::diagnosis::progress::Progress;
use crate::diagnosis::search::{SEPARABLE, Search};
use crate::diagnosis::verdict::{Finding, full_name, name_beside};
use crate::flight::FlightSetup;
use crate::flight_log::flight_log;
use crate::log::{Column, Log};
use crate::model::{self, VehicleModel};
use crate::prediction::{MeasuredNoise, Subject};
use crate::scenario::Scenario;

/// Steps of the controller and rows of a flight per second: each command has its row.
const RATE_HZ: u32 = 200;
/// A difference of log-likelihoods that leaves no doubt, noise and all: odds of e^10, 22000 to 1.
const DECISIVE: f64 = 10.0;
/// One that tells nothing, however often the manoeuvre is repeated: its 64 times are not enough.
const NOTHING: f64 = SEPARABLE / 64.0;

/// A proposed flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// For a person.
    pub sentence: String,
    /// What to fly; none where no manoeuvre would help.
    pub scenario: Option<Scenario>,
}

/// A finding and an effect that might stand in its place.
struct Pair<'e> {
    /// "torque_bias (pitch) from cg_offset".
    names: String,
    finding: Family<'e>,
    rival: Family<'e>,
}

/// The model with one of the two in, then, unless the two differ in just that, the same with the effect on each other
/// axis or motor.
type Family<'e> = Vec<Vec<Term<'e>>>;

/// A manoeuvre and the differences of log-likelihoods to be expected from it, pair by pair.
struct Tried {
    manoeuvre: Manoeuvre,
    separated_by: Vec<f64>,
}

/// The flight that would separate the findings from what they are confounded with; `None` where nothing is.
pub(in crate::diagnosis) fn separating(
    log: &Log,
    subject: &Subject<'_>,
    search: &Search<'_>,
    found: &Found<'_>,
    findings: &[Finding],
    places: &[usize],
) -> Option<Experiment> {
    let pairs = pairs(search, found, findings, places);
    if pairs.is_empty() {
        return None;
    }
    let Subject::Vehicle(model) = subject else {
        let names = listed(pairs.iter().map(|pair| pair.names.as_str()));
        let sentence =
            format!("No flight that separates {names} can be simulated: the vehicle on these axes is not known.");
        return Some(Experiment { sentence, scenario: None });
    };
    let noise = noise_per_row(log, subject);
    let judge = Judge { log, model, search, noise, chosen: &found.refitted.chosen.terms, pairs: &pairs };
    let mut tried: Vec<Tried> = Vec::new();
    let candidates = manoeuvres();
    let total = candidates.len();
    for (done, manoeuvre) in candidates.into_iter().enumerate() {
        (search.observer)(Progress::Separating { done, total });
        let tells = |once: &Tried| once.separated_by.iter().any(|by| *by > NOTHING);
        if manoeuvre.repeats.is_some_and(|shorter| !tells(&tried[shorter])) {
            continue;
        }
        tried.push(Tried { separated_by: judge.separated(&manoeuvre.scenario), manoeuvre });
        if tried[tried.len() - 1].separated_by.iter().all(|by| *by >= DECISIVE) {
            break;
        }
    }
    // of equals the first, which is the plainest
    let best = tried.into_iter().reduce(|best, other| if other.worth() > best.worth() { other } else { best });
    best.map(|best| best.proposed(&pairs))
}

impl Tried {
    /// More than decisive is no better.
    fn worth(&self) -> f64 {
        self.separated_by.iter().map(|by| by.min(DECISIVE)).sum()
    }

    fn proposed(self, pairs: &[Pair<'_>]) -> Experiment {
        let which = |is_separated: bool| {
            pairs.iter().zip(&self.separated_by).filter(move |(_, by)| (**by >= SEPARABLE) == is_separated)
        };
        let names = |is_separated: bool| listed(which(is_separated).map(|(pair, _)| pair.names.as_str()));
        let mut sentences = Vec::new();
        let least = which(true).map(|(_, by)| *by).fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            sentences.push(format!(
                "To separate {}, fly {}: their log-likelihoods should then differ by {least:.0}, and {SEPARABLE} are \
                 enough.",
                names(true),
                self.manoeuvre.in_words
            ));
        }
        if which(false).next().is_some() {
            sentences.push(format!(
                "No manoeuvre tried in simulation separates {} on this rig: measure one of them by itself.",
                names(false)
            ));
        }
        Experiment { sentence: sentences.join(" "), scenario: least.is_finite().then_some(self.manoeuvre.scenario) }
    }
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(" and ")
}

fn pairs<'e>(search: &Search<'e>, found: &Found<'e>, findings: &[Finding], places: &[usize]) -> Vec<Pair<'e>> {
    let mut pairs = Vec::new();
    for (index, finding) in places.iter().zip(findings) {
        let alternatives = found.alternatives_of(search, *index);
        let axis = finding.axis.map(|axis| format!(" ({axis})")).unwrap_or_default();
        let chosen = &found.refitted.chosen.terms;
        for name in &finding.confounded_with {
            let own = chosen[*index].effect;
            let Some(rival) = alternatives.iter().find(|other| name_beside(own, other.last_effect()) == *name) else {
                continue;
            };
            let (effect, rival) = (rival.last_effect(), &rival.fit.terms);
            pairs.push(if effect.name() == own.name() {
                // the same effect elsewhere: which of its places it is, is the question
                let names = format!("{} from {name}", full_name(own));
                Pair { names, finding: vec![chosen.clone()], rival: vec![rival.clone()] }
            } else {
                Pair {
                    names: format!("{}{axis} from {name}", finding.effect),
                    finding: family(search, chosen, *index),
                    rival: family(search, rival, rival.len() - 1),
                }
            });
        }
    }
    pairs
}

/// The effect is that of one of the terms.
fn family<'e>(search: &Search<'e>, terms: &[Term<'e>], index: usize) -> Family<'e> {
    let effect = terms[index].effect;
    let others = search.catalogue.iter().filter(|other: &&Fitted| {
        other.name() == effect.name() && (other.axis(), other.motor()) != (effect.axis(), effect.motor())
    });
    let moved = others.map(|other| {
        let mut moved = terms.to_vec();
        moved[index] = Term { effect: other, values: terms[index].values.clone() };
        moved
    });
    std::iter::once(terms.to_vec()).chain(moved).collect()
}

/// A sensor's noise per row, were there as many rows as in the simulated flight.
fn noise_per_row(log: &Log, subject: &Subject<'_>) -> MeasuredNoise {
    subject.noise(log).scaled((f64::from(RATE_HZ) / log.rate_hz()).sqrt())
}

/// What a log's manoeuvres are judged with.
struct Judge<'a> {
    log: &'a Log,
    model: &'a VehicleModel,
    search: &'a Search<'a>,
    noise: MeasuredNoise,
    /// All findings together.
    chosen: &'a [Term<'a>],
    pairs: &'a [Pair<'a>],
}

impl Judge<'_> {
    /// Per pair, the mean of the expected differences of log-likelihoods if either of its models is true; 0 where
    /// neither can be flown.
    fn separated(&self, scenario: &Scenario) -> Vec<f64> {
        let rivals = self.pairs.iter().map(|pair| &pair.rival[0][..]);
        let truths: Vec<&[Term<'_>]> = std::iter::once(self.chosen).chain(rivals).collect();
        let flights: Vec<Option<Log>> = truths.par_iter().map(|truth| self.fly(scenario, truth)).collect();
        let by_findings = self.separated_if_true(flights[0].as_ref(), self.chosen, |pair| &pair.rival, self.pairs);
        let by_rivals = self.pairs.iter().zip(&flights[1..]).map(|(pair, flight)| {
            let alone = std::slice::from_ref(pair);
            self.separated_if_true(flight.as_ref(), &pair.rival[0], |pair| &pair.finding, alone).map(|by| by[0])
        });
        let mean = |(index, by_rival): (usize, Option<f64>)| {
            let by_finding = by_findings.as_ref().map(|by| by[index]);
            let both: Vec<f64> = [by_finding, by_rival].into_iter().flatten().collect();
            both.iter().sum::<f64>() / both.len().max(1) as f64
        };
        by_rivals.enumerate().map(mean).collect()
    }

    /// Per pair, the difference if one model is true, which flew, and the others are fitted anew.
    fn separated_if_true<'p>(
        &self,
        flight: Option<&Log>,
        truth: &[Term<'_>],
        other: impl Fn(&'p Pair<'p>) -> &'p Family<'p>,
        pairs: &'p [Pair<'p>],
    ) -> Option<Vec<f64>> {
        // what disturbed this log would disturb the flight too
        let shooting = Subject::Vehicle(self.model).shooting(flight?, &self.noise).ok()?;
        let shooting = shooting.with_noise(self.search.shooting.noise, Vec::new());
        let all = shooting.log.in_use();
        let flown = shooting.log.drive(model_of(self.search.nominal, truth));
        let mut starts = shooting.log.measured_starts(&flown.model);
        // what the two integrators and the rounding of the log differ by
        let own: f64 = shooting.settle(&flown, &all, &mut starts).iter().sum();
        let difference = |family: &Family<'_>| {
            let mut least = f64::INFINITY;
            for terms in family {
                let fit = fit_to_reach(&shooting, self.search.nominal, terms.clone(), &starts, &all, least);
                least = least.min(fit.training);
                if least - own < 2.0 * NOTHING {
                    break;
                }
            }
            0.5 * (least - own).max(0.0)
        };
        Some(pairs.iter().map(|pair| difference(other(pair))).collect())
    }

    /// A noiseless flight, logged as the log was: what is not in it is not in the flight's.
    fn fly(&self, scenario: &Scenario, terms: &[Term<'_>]) -> Option<Log> {
        // fitted values that no vehicle can have fly nothing
        let mut model = model_with_terms(self.model, terms).ok()?;
        model.noise = model::SensorNoise::NONE;
        let choice = ControllerChoice { rate_hz: RATE_HZ, ..ControllerChoice::nominal(Controller::Cascade) };
        let setup = FlightSetup { model, controller_model: None, choice, scenario: scenario.clone(), seed: 0 };
        let flight = setup.fly().ok().filter(|flight| !flight.record.ended_early)?;
        let mut log = flight_log(&flight.record, RATE_HZ);
        let or_none = |own: &mut Column, of_log: &Column| *own = own.take().filter(|_| of_log.is_some());
        for axis in 0..3 {
            or_none(&mut log.angle_rad[axis], &self.log.angle_rad[axis]);
            or_none(&mut log.rate_rad_s[axis], &self.log.rate_rad_s[axis]);
            or_none(&mut log.accel_body_m_s2[axis], &self.log.accel_body_m_s2[axis]);
            or_none(&mut log.velocity_ned_m_s[axis], &self.log.velocity_ned_m_s[axis]);
        }
        or_none(&mut log.height_m, &self.log.height_m);
        Some(log)
    }
}
