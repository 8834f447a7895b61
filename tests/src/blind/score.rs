//! What the diagnosis made of the cases.

use std::collections::BTreeMap;

use sil_host::diagnosis::{Diagnosis, Verdict};

use super::Case;

/// One case and its answer.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What was hidden: name with axis or motor.
    pub hidden: String,
    /// What was found first, likewise; empty where nothing was.
    pub found: String,
    /// True if name, axis and motor are right, or an admissible confounded name is.
    pub right: bool,
    /// Further findings that are not there.
    pub false_findings: usize,
    /// Relative error of the size, of right names.
    pub size_error: Option<f64>,
    /// Is the truth within 1.96 standard deviations?
    pub covered: Option<bool>,
    /// Held-out error of the nominal model over the noise floor.
    pub ratio: f64,
    /// Its verdict.
    pub verdict: Verdict,
}

impl Outcome {
    /// Compares an answer with what was hidden.
    pub fn new(case: &Case, answer: &Diagnosis) -> Outcome {
        let hidden = &case.hidden;
        let label = |effect: &str, axis: Option<&str>, motor: Option<u8>| {
            let place = axis.map(str::to_owned).or_else(|| motor.map(|motor| motor.to_string()));
            place.map_or_else(|| effect.to_owned(), |place| format!("{effect} {place}"))
        };
        let first = answer.findings.first();
        let motor_of = |finding: &sil_host::diagnosis::Finding| {
            finding.parameters.get("motor").map(|estimate| estimate.value.round() as u8)
        };
        let same = first.is_some_and(|finding| {
            finding.effect == hidden.name && finding.axis == hidden.axis && motor_of(finding) == hidden.motor
        });
        let confounded = first.is_some_and(|finding| finding.confounded_with.contains(&hidden.name));
        let estimate = first.filter(|_| same).and_then(|finding| finding.parameters.get(hidden.parameter));
        let truth = case.value;
        Outcome {
            hidden: label(hidden.name, hidden.axis, hidden.motor),
            found: first.map_or(String::new(), |finding| label(finding.effect, finding.axis, motor_of(finding))),
            right: same || confounded,
            false_findings: answer.findings.len().saturating_sub(1),
            size_error: estimate.map(|estimate| ((estimate.value - truth) / (truth - hidden.nominal)).abs()),
            covered: estimate.map(|estimate| (estimate.value - truth).abs() <= 1.96 * estimate.std),
            ratio: case.ratio,
            verdict: answer.verdict,
        }
    }
}

/// All of them together.
#[derive(Clone, Debug, Default)]
pub struct Score {
    outcomes: Vec<Outcome>,
}

impl Score {
    /// One more.
    pub fn add(&mut self, outcome: Outcome) {
        self.outcomes.push(outcome);
    }

    /// Cases so far.
    pub fn cases(&self) -> usize {
        self.outcomes.len()
    }

    fn share(&self, of: impl Fn(&Outcome) -> Option<bool>) -> f64 {
        let known: Vec<bool> = self.outcomes.iter().filter_map(of).collect();
        known.iter().filter(|yes| **yes).count() as f64 / known.len().max(1) as f64
    }

    /// Share of right first findings.
    pub fn named(&self) -> f64 {
        self.share(|outcome| Some(outcome.right))
    }

    /// Share of cases with a further finding that is not there.
    pub fn false_findings(&self) -> f64 {
        self.share(|outcome| Some(outcome.false_findings > 0))
    }

    /// Share of right names whose size is within 10 %.
    pub fn sized(&self) -> f64 {
        self.share(|outcome| outcome.size_error.map(|error| error <= 0.1))
    }

    /// Share of right names whose interval holds the truth.
    pub fn covered(&self) -> f64 {
        self.share(|outcome| outcome.covered)
    }

    /// The figures, what was taken for what, and the naming rate over the effect's size.
    pub fn table(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let mut text = format!(
            "cases {}\nfirst finding right   {}\nfurther false finding {}\nsize within 10 %      {}\n1.96 std hold truth   {}\n",
            self.cases(),
            percent(self.named()),
            percent(self.false_findings()),
            percent(self.sized()),
            percent(self.covered()),
        );
        text += "\nerror / floor   cases  right\n";
        for (from, to) in [(0.0, 2.0), (2.0, 3.0), (3.0, 5.0), (5.0, 8.0), (8.0, 1e9)] {
            let of: Vec<&Outcome> = self.outcomes.iter().filter(|o| (from..to).contains(&o.ratio)).collect();
            let right = of.iter().filter(|outcome| outcome.right).count();
            text += &format!("{from:5.1} to {to:5.1}   {:5}  {right:5}\n", of.len());
        }
        let mut confusion: BTreeMap<(&str, &str), usize> = BTreeMap::new();
        for outcome in &self.outcomes {
            *confusion.entry((&outcome.hidden, &outcome.found)).or_default() += 1;
        }
        text += "\nhidden                        found                         cases\n";
        for ((hidden, found), cases) in confusion {
            let found = if found.is_empty() { "nothing" } else { found };
            let mark = if hidden == found { ' ' } else { '*' };
            text += &format!("{hidden:<28}{mark} {found:<28}  {cases:5}\n");
        }
        text
    }
}
