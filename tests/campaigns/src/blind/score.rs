//! What the diagnosis made of all cases of a campaign, in tables.

use std::collections::BTreeMap;
use std::fmt::Write;

use sil_host::diagnosis::Verdict;

use super::behaviour::Figure;
use super::beside_reality::BesideReality;
use super::outcome::{Gain, Outcome};

/// Standard deviations that 95 % lie within.
const INTERVAL: f64 = 1.96;
/// Ends of the classes of held-out error over noise floor.
const CLASSES: [f64; 6] = [0.0, 2.0, 3.0, 5.0, 7.0, f64::INFINITY];

/// Ends of the classes of the share of the held-out error that hangs on a cause, %.
const SHARES_PCT: [f64; 6] = [f64::NEG_INFINITY, 2.0, 5.0, 10.0, 30.0, f64::INFINITY];

/// One number of a gain.
type GainFigure = fn(Gain) -> f64;

/// The outcomes of a campaign.
#[derive(Clone, Debug, Default)]
pub struct Score {
    /// In order of the seeds.
    pub outcomes: Vec<Outcome>,
}

impl Score {
    fn share(&self, of: impl Fn(&Outcome) -> bool) -> f64 {
        share(self.outcomes.iter().map(of))
    }

    /// Number of right answers.
    pub fn right(&self) -> usize {
        self.outcomes.iter().filter(|outcome| outcome.is_right()).count()
    }

    /// Share of cases whose first finding is right.
    pub fn first_is_right(&self) -> f64 {
        self.share(|outcome| outcome.first_is_right)
    }

    /// Share of cases in which everything hidden is named.
    pub fn all_named(&self) -> f64 {
        self.share(Outcome::all_named)
    }

    /// Share of cases with a finding that is not there.
    pub fn false_findings(&self) -> f64 {
        self.share(|outcome| outcome.false_findings > 0)
    }

    /// Share of cases without any finding.
    pub fn without_finding(&self) -> f64 {
        self.share(|outcome| outcome.found.is_empty())
    }

    /// Share of named effects whose size is within 10 %.
    pub fn sized(&self) -> f64 {
        share(self.outcomes.iter().flat_map(|outcome| &outcome.sizes).map(|size| size.error <= 0.1))
    }

    /// Share of named effects whose interval holds the truth.
    pub fn covered(&self) -> f64 {
        share(self.outcomes.iter().flat_map(|outcome| &outcome.sizes).map(|size| size.deviations.abs() <= INTERVAL))
    }

    /// Share of cases in which it is said that something is left that no effect explains.
    pub fn unknown_admitted(&self) -> f64 {
        self.share(|outcome| matches!(outcome.verdict, Verdict::UnknownEffect | Verdict::PartlyExplained))
    }

    /// Share of cases with `explained` as the verdict.
    pub fn explained(&self) -> f64 {
        self.share(|outcome| outcome.verdict == Verdict::Explained)
    }

    /// Share of cases whose signature says where something acts and what it depends on.
    pub fn signed(&self) -> f64 {
        self.share(|outcome| outcome.signature_is_right)
    }

    /// Share of cases whose hold-out errors are as near to the true model's as the issue asks.
    pub fn gained(&self) -> [f64; 3] {
        let gains = || self.outcomes.iter().filter_map(|outcome| outcome.gain);
        let limits: [fn(Gain) -> bool; 3] = [
            |gain| gain.extended_to_true <= 1.1,
            |gain| gain.extended_to_floor <= 1.3,
            |gain| gain.floor_to_true <= 1.15,
        ];
        limits.map(|limit| share(gains().map(limit)))
    }

    /// Share of the causes that show in vehicles that imitate real ones which are named.
    pub fn shown_is_named(&self) -> f64 {
        let is_shown = |outcome: &&Outcome| outcome.beside_reality.as_ref().is_some_and(|beside| beside.is_shown());
        share(self.outcomes.iter().filter(is_shown).map(Outcome::all_named))
    }

    /// The naming rate of their causes over the share of the held-out error that hangs on them.
    fn by_share_shown(&self) -> String {
        let shown_pct = |outcome: &Outcome| Some(100.0 * outcome.beside_reality.as_ref()?.shown?);
        let head = "| share of the error that hangs on the cause, % | cases | named |\n|---|---|---|\n";
        head.to_owned() + &self.classes(&SHARES_PCT, shown_pct, Outcome::all_named)
    }

    /// A line for each class of some figure: its ends, its cases, and how many of these are right.
    fn classes(
        &self,
        ends: &[f64],
        figure: impl Fn(&Outcome) -> Option<f64>,
        is_right: impl Fn(&Outcome) -> bool,
    ) -> String {
        let mut text = String::new();
        for ends in ends.windows(2) {
            let is_in = |outcome: &&Outcome| figure(outcome).is_some_and(|value| (ends[0]..ends[1]).contains(&value));
            let class: Vec<&Outcome> = self.outcomes.iter().filter(is_in).collect();
            let right = class.iter().filter(|outcome| is_right(outcome)).count();
            let name = match (ends[0].is_finite(), ends[1].is_finite()) {
                (false, _) => format!("up to {}", ends[1]),
                (_, false) => format!("{} up", ends[0]),
                _ => format!("{} to {}", ends[0], ends[1]),
            };
            let _ = writeln!(text, "| {name} | {} | {right} |", class.len());
        }
        text
    }

    /// Share of vehicles that imitate real ones of which nothing false is told as certain.
    pub fn nothing_false(&self) -> f64 {
        self.share(|outcome| outcome.beside_reality.as_ref().is_some_and(|beside| beside.false_names.is_empty()))
    }

    /// Share of them of which lag and delay, lift and trims are right.
    pub fn base_is_right(&self) -> f64 {
        self.share(|outcome| outcome.beside_reality.as_ref().is_some_and(BesideReality::base_is_right))
    }

    /// The figures of vehicles that imitate real ones, the false names and the wrong sizes.
    pub fn beside_reality(&self) -> String {
        let all = || self.outcomes.iter().filter_map(|outcome| outcome.beside_reality.as_ref());
        let mut text = "| figure | interval holds the truth, or the error is negligible | median error | 90 % |\n\
                        |---|---|---|---|\n"
            .to_owned();
        for (place, figure) in Figure::ALL.into_iter().enumerate() {
            let told: Vec<_> = all().map(|beside| beside.figures[place]).collect();
            // times in s, accelerations in rad/s^2, effectiveness relative
            let unit = |truth: f64| if matches!(figure, Figure::Effectiveness(_)) { truth.abs() } else { 1.0 };
            let mut errors: Vec<f64> =
                told.iter().map(|(_, truth, told)| (told.value - truth).abs() / unit(*truth)).collect();
            errors.sort_by(f64::total_cmp);
            let at = |share: f64| errors.get((share * errors.len().saturating_sub(1) as f64) as usize).copied();
            let [median, most] = [0.5, 0.9].map(|share| at(share).unwrap_or_default());
            let holds = percent(share(told.iter().map(BesideReality::holds)));
            let _ = writeln!(text, "| {figure:?} | {holds} | {median:.4} | {most:.4} |");
        }
        let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
        for beside in all() {
            for name in &beside.false_names {
                *counts.entry(("not there", bare(name))).or_default() += 1;
            }
            for (name, ..) in &beside.wrong_sizes {
                *counts.entry(("wrong size", bare(name))).or_default() += 1;
            }
        }
        text += "\n| told as certain | | cases |\n|---|---|---|\n";
        for ((what, name), cases) in counts {
            let _ = writeln!(text, "| {name} | {what} | {cases} |");
        }
        text + "\n" + &self.by_share_shown() + "\n" + &self.confusion()
    }

    /// How held-out errors lie: median, 95 % and largest of each figure.
    pub fn gains(&self) -> String {
        let figures: [(&str, GainFigure); 3] = [
            ("extended / true model, at most 1.1", |gain| gain.extended_to_true),
            ("extended / noise floor, at most 1.3", |gain| gain.extended_to_floor),
            ("noise floor and true model, the larger / the smaller, at most 1.15", |gain| gain.floor_to_true),
        ];
        let mut text =
            "| held-out error, worst channel | within | median | 95 % | largest |\n|---|---|---|---|---|\n".to_owned();
        for ((name, figure), within) in figures.into_iter().zip(self.gained()) {
            let mut sorted: Vec<f64> = self.outcomes.iter().filter_map(|outcome| outcome.gain).map(figure).collect();
            sorted.sort_by(f64::total_cmp);
            let at = |share: f64| sorted.get((share * (sorted.len().saturating_sub(1)) as f64).round() as usize);
            let cell = |share: f64| at(share).map_or_else(String::new, |value| format!("{value:.3}"));
            let within = percent(within);
            let _ = writeln!(text, "| {name} | {within} | {} | {} | {} |", cell(0.5), cell(0.95), cell(1.0));
        }
        text
    }

    /// The naming rate over the effects' size.
    pub fn by_size(&self) -> String {
        let head = "| error / floor | cases | right |\n|---|---|---|\n";
        head.to_owned() + &self.classes(&CLASSES, |outcome| Some(outcome.ratio), |outcome| outcome.first_is_right)
    }

    /// What was taken for what: hidden effects without axis and motor, and the first findings.
    pub fn confusion(&self) -> String {
        let mut cells: BTreeMap<(String, String), usize> = BTreeMap::new();
        for outcome in &self.outcomes {
            let hidden = outcome.hidden.first().map_or("nothing", |hidden| bare(hidden));
            let found = match outcome.found.first() {
                _ if outcome.first_is_right && outcome.hidden.first() != outcome.found.first() => {
                    format!("{} or {hidden}", bare(&outcome.found[0]))
                }
                Some(found) if outcome.first_is_right => bare(found).to_owned(),
                Some(found) => format!("**{found}**"),
                None => "**nothing**".to_owned(),
            };
            *cells.entry((hidden.to_owned(), found)).or_default() += 1;
        }
        let mut text = "| hidden | found first | cases |\n|---|---|---|\n".to_owned();
        for ((hidden, found), cases) in cells {
            let _ = writeln!(text, "| {hidden} | {found} | {cases} |");
        }
        text
    }

    /// Verdicts.
    pub fn verdicts(&self) -> String {
        let all = [Verdict::NoDiscrepancy, Verdict::Explained, Verdict::PartlyExplained, Verdict::UnknownEffect];
        let count = |verdict| self.outcomes.iter().filter(|outcome| outcome.verdict == verdict).count();
        let cells: Vec<String> = all.iter().map(|verdict| format!("{verdict:?} {}", count(*verdict))).collect();
        cells.join(", ")
    }
}

/// A share as people read it.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn bare(label: &str) -> &str {
    label.split(' ').next().unwrap_or(label)
}

fn share(of: impl Iterator<Item = bool>) -> f64 {
    let all: Vec<bool> = of.collect();
    all.iter().filter(|yes| **yes).count() as f64 / all.len().max(1) as f64
}
