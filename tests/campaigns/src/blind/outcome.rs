//! One case and what the diagnosis made of it.

use sil_host::diagnosis::{
    Diagnosis, Finding, Subject, Verdict, channel_prediction_errors, diagnose, extended_model, nominal_prediction,
};
use sil_host::log::Log;
use sil_host::log::sanity::examine;
use sil_host::model::{Rig, VehicleModel};
use sil_host::prediction::ChannelErrors;

use super::beside_reality::BesideReality;
use super::case::Case;
use super::hidden::{Hidden, label};

/// An answer beside the truth.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The case's number.
    pub seed: u64,
    /// What is hidden in it, in words.
    pub label: String,
    /// True if something is in the log that no catalogue has.
    pub is_outside: bool,
    /// What was hidden.
    pub hidden: Vec<String>,
    /// What was found, most important first.
    pub found: Vec<String>,
    /// Effects that it is said may stand in the first finding's place.
    pub confounded: Vec<String>,
    /// Hidden effects that are named, with axis and motor or as an admissible confounded name.
    pub named: usize,
    /// True if the first finding is a hidden effect, likewise.
    pub first_is_right: bool,
    /// Findings that are not there.
    pub false_findings: usize,
    /// Of each hidden effect that is named by its own name.
    pub sizes: Vec<Size>,
    /// Held-out error of the nominal model over the noise floor.
    pub ratio: f64,
    /// Rows per second.
    pub log_rate_hz: u32,
    /// Its verdict.
    pub verdict: Verdict,
    /// What is left, in words.
    pub signature: String,
    /// True if that says where something outside the catalogue acts and what it depends on.
    pub signature_is_right: bool,
    /// How much the extended model gains, where the test knows the true one.
    pub gain: Option<Gain>,
    /// Of a vehicle that imitates a real one.
    pub beside_reality: Option<BesideReality>,
}

/// A parameter beside its true value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Error relative to the effect.
    pub error: f64,
    /// Error in standard deviations.
    pub deviations: f64,
}

/// Held-out errors: of four channels the worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Of the extended model over those of the true one, on the same windows and starts.
    pub extended_to_true: f64,
    /// Of the extended model over the noise floor.
    pub extended_to_floor: f64,
    /// Of noise floor and true model, the larger over the smaller.
    pub floor_to_true: f64,
}

impl Outcome {
    /// Has a case diagnosed: by its CSV alone, through the gate that `sil diagnose` has before it.
    ///
    /// # Panics
    /// If the gate refuses the log, or it can't be diagnosed.
    pub fn of(case: &Case) -> Outcome {
        let nominal = VehicleModel::nominal(case.conditions.rig);
        let given = case.reality.as_ref().map_or(&nominal, |reality| &reality.given);
        let log = case.log();
        let refused = examine(&log, None).contradictions;
        assert!(refused.is_empty(), "seed {}, {}: refused, {refused:?}", case.seed, case.label());
        let answer = diagnose(&log, &Subject::Vehicle(given)).expect("a whole log");
        // gusts make a true model's error as large as any
        let gain = (case.outside.is_none() && case.reality.is_none()).then(|| {
            if case.conditions.rig == Rig::Free {
                return Gain::in_free_flight(case, &log, &answer);
            }
            let truth = nominal_prediction(&log, &Subject::Vehicle(&case.vehicle), None).expect("a whole log");
            let [errors, _] = truth.predicted.channel_errors();
            Gain::of(&answer, &errors)
        });
        Outcome::beside_truth(case, &log, &answer, gain)
    }

    fn beside_truth(case: &Case, log: &Log, answer: &Diagnosis, gain: Option<Gain>) -> Outcome {
        let mut left: Vec<&Finding> = answer.findings.iter().collect();
        let (mut named, mut sizes) = (0, Vec::new());
        // those named by their own names first, then those that another may stand for
        let own = |finding: &Finding, effect: &Hidden| {
            finding.effect == effect.name && finding.axis == effect.axis && motor_of(finding) == effect.motor
        };
        let admitted = |finding: &Finding, effect: &Hidden| {
            finding.confounded_with.iter().any(|name| *name == effect.name || *name == effect.label())
        };
        let mut unnamed = Vec::new();
        for (effect, value) in &case.hidden {
            match left.iter().position(|finding| own(finding, effect)) {
                Some(place) => {
                    named += 1;
                    sizes.extend(size(left.remove(place), effect, *value));
                }
                None => unnamed.push(effect),
            }
        }
        for effect in unnamed {
            if let Some(place) = left.iter().position(|finding| admitted(finding, effect)) {
                named += 1;
                left.remove(place);
            }
        }
        let first = answer.findings.first();
        let right = |finding: &Finding| case.hidden.iter().any(|(e, _)| own(finding, e) || admitted(finding, e));
        Outcome {
            seed: case.seed,
            label: case.label(),
            is_outside: case.outside.is_some(),
            hidden: case.hidden.iter().map(|(effect, _)| effect.label()).collect(),
            found: answer.findings.iter().map(|f| label(f.effect, f.axis, motor_of(f))).collect(),
            confounded: first.map_or_else(Vec::new, |first| first.confounded_with.clone()),
            named,
            first_is_right: first.is_some_and(right),
            false_findings: left.len(),
            sizes,
            ratio: case.ratio,
            log_rate_hz: case.conditions.log_rate_hz,
            verdict: answer.verdict,
            signature: answer.unexplained.signature.clone(),
            signature_is_right: case.outside.is_some_and(|it| it.is_named_by(&answer.unexplained.signature)),
            gain,
            beside_reality: case.reality.as_ref().map(|reality| BesideReality::of(case, reality, log, answer)),
        }
    }

    /// True if all that is hidden is named and nothing else (of a vehicle that imitates a real one: if the log shows
    /// it, nothing else as certain, and the base right), and if something from outside the catalogue is not taken for
    /// explained.
    pub fn is_right(&self) -> bool {
        if self.is_outside {
            return matches!(self.verdict, Verdict::UnknownEffect | Verdict::PartlyExplained);
        }
        if let Some(beside) = &self.beside_reality {
            let is_named = self.all_named() || !beside.is_shown();
            return is_named && beside.false_names.is_empty() && beside.base_is_right();
        }
        self.all_named() && self.false_findings == 0 && self.first_is_right != self.hidden.is_empty()
    }

    /// True if every hidden effect is named.
    pub fn all_named(&self) -> bool {
        self.named == self.hidden.len()
    }
}

fn motor_of(finding: &Finding) -> Option<u8> {
    finding.parameters.get("motor").map(|estimate| estimate.value.round() as u8)
}

fn size(finding: &Finding, effect: &Hidden, truth: f64) -> Option<Size> {
    let estimate = finding.parameters.get(effect.parameter)?;
    let error = estimate.value - truth;
    Some(Size { error: (error / (truth - effect.nominal)).abs(), deviations: error / estimate.std })
}

impl Gain {
    /// Over all channels that the diagnosis compares.
    fn in_free_flight(case: &Case, log: &Log, answer: &Diagnosis) -> Gain {
        let errors =
            |model: &VehicleModel| channel_prediction_errors(log, &Subject::Vehicle(model), None).expect("a whole log");
        let nominal = VehicleModel::nominal(Rig::Free);
        let extended = extended_model(&nominal, answer).map_or_else(|_| errors(&nominal), |it| errors(&it));
        let mut gain = Gain { extended_to_true: 0.0, extended_to_floor: 0.0, floor_to_true: 0.0 };
        for ((_, extended), (_, truth)) in extended.iter().zip(&errors(&case.vehicle)) {
            let (floor, truth) = (extended.noise_floor, truth.error);
            gain.extended_to_true = gain.extended_to_true.max(extended.error / truth);
            gain.extended_to_floor = gain.extended_to_floor.max(extended.ratio());
            gain.floor_to_true = gain.floor_to_true.max(floor / truth).max(truth / floor);
        }
        gain
    }

    fn of(answer: &Diagnosis, truth: &ChannelErrors) -> Gain {
        let channels = |errors: &ChannelErrors| [errors.roll_deg, errors.pitch_deg, errors.p_deg_s, errors.q_deg_s];
        let truth = channels(truth);
        let [extended, floor] = [&answer.prediction_error.extended, &answer.prediction_error.noise_floor].map(channels);
        let worst = |above: &[Option<f64>; 4], below: &[Option<f64>; 4]| {
            above.iter().zip(below).filter_map(|(above, below)| Some((*above)? / (*below)?)).fold(0.0, f64::max)
        };
        Gain {
            extended_to_true: worst(&extended, &truth),
            extended_to_floor: worst(&extended, &floor),
            floor_to_true: worst(&floor, &truth).max(worst(&truth, &floor)),
        }
    }
}
