//! How far an answer hangs on where its log was cut. Eight other cuts of the log are diagnosed too, each as if
//! nothing else had been logged: an eighth of the time left out, another in each, and the windows' grid moved. A name
//! that most cuts give is an answer; one that the cuts do not agree on is one of several.

use rayon::prelude::*;

use super::fitted::Fitted;
use super::known::Known;
use super::progress::Progress;
use super::search::Search;
use super::{evidence, searched};
use crate::diagnosis::fitting::fit::Term;
use crate::log::Log;
use crate::prediction::{Cut, Subject};

/// Share of the cuts that must give a name for it to be certain.
const CERTAIN: f64 = 0.8;
/// Share of the cuts that must give a name, or what stands in its place, for it to be a finding at all.
const MOST: f64 = 0.5;
/// With fewer cuts that can be answered nothing is said of them.
const CUTS_MIN: usize = 4;
/// Names beside a finding that is one of several.
const RIVALS_MAX: usize = 3;

/// How thoroughly a log is diagnosed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// One search, over the whole log.
    #[default]
    Quick,
    /// Over eight other cuts of it too.
    Usual,
    /// Over twenty-four.
    Thorough,
}

impl Effort {
    /// Other cuts of the log that are searched.
    fn cuts(self) -> usize {
        match self {
            Effort::Quick => 0,
            Effort::Usual => 8,
            Effort::Thorough => 24,
        }
    }
}

/// What the other cuts of a log give.
pub(super) struct Stability<'e> {
    /// Per cut that could be answered, what was found in it.
    answers: Vec<Vec<Term<'e>>>,
}

impl<'e> Stability<'e> {
    /// Diagnoses the cuts, as many at once as there are threads.
    pub(super) fn of(
        log: &Log,
        subject: &Subject<'_>,
        known: &Known,
        search: &Search<'e>,
        effort: Effort,
    ) -> Stability<'e> {
        let effects: Vec<&Fitted> = search.always.iter().map(|term| term.effect).chain(search.catalogue).collect();
        let (total, mut answers) = (effort.cuts(), Vec::new());
        let numbers: Vec<usize> = (0..total).collect();
        for at_once in numbers.chunks(rayon::current_num_threads().max(1)) {
            (search.observer)(Progress::Cutting { done: at_once[0], total });
            let found =
                |number: &usize| found_in(&Cut { number: *number, of: total }.of(log)?, subject, known, &effects);
            answers.extend(at_once.par_iter().map(found).collect::<Vec<_>>().into_iter().flatten());
        }
        Stability { answers }
    }

    /// In how many of the cuts an effect is found, %; none where they say nothing.
    pub(super) fn pct(&self, effect: &Fitted) -> Option<f64> {
        (self.answers.len() >= CUTS_MIN).then(|| 100.0 * self.share(&[effect]))
    }

    /// What the answer chooses among where the cuts do not agree on an effect, that effect first and `None` for nothing
    /// at all; empty where they do.
    pub(super) fn one_of(&self, effect: &'e Fitted, found: &[&Fitted]) -> Vec<Option<&'e Fitted>> {
        if self.answers.len() < CUTS_MIN || self.share(&[effect]) >= CERTAIN {
            return Vec::new();
        }
        let rivals = self.rivals(effect, found);
        let mut names = vec![effect];
        names.extend(rivals.iter().map(|term| term.effect));
        let is_there_something = self.share(&names) >= CERTAIN;
        let mut one_of: Vec<Option<&'e Fitted>> = names.into_iter().map(Some).collect();
        if !is_there_something {
            one_of.push(None);
        }
        one_of
    }

    /// The terms that stay: those that most cuts give, or what most cuts give in their place.
    pub(super) fn consensus(&self, terms: &[Term<'e>]) -> Vec<Term<'e>> {
        if self.answers.len() < CUTS_MIN {
            return terms.to_vec();
        }
        let found: Vec<&Fitted> = terms.iter().map(|term| term.effect).collect();
        let mut kept: Vec<Term<'e>> = Vec::new();
        for term in terms {
            let (own, rivals) = (self.share(&[term.effect]), self.rivals(term.effect, &found));
            let names: Vec<&Fitted> = rivals.iter().map(|rival| rival.effect).chain([term.effect]).collect();
            let best = rivals.first().filter(|rival| self.share(&[rival.effect]) > own.max(MOST));
            let stays = (own >= MOST || self.share(&names) >= MOST).then_some(term);
            let stays = best.or(stays).cloned();
            kept.extend(stays.filter(|new| !kept.iter().any(|other| other.effect.is_the_same(new.effect))));
        }
        kept
    }

    /// Share of the cuts in which one of some effects is found.
    fn share(&self, effects: &[&Fitted]) -> f64 {
        let has = |answer: &&Vec<Term<'e>>| effects.iter().any(|effect| is_in(answer, effect));
        self.answers.iter().filter(has).count() as f64 / self.answers.len().max(1) as f64
    }

    /// What cuts that lack an effect have in its place, the most frequent first: nothing that the whole log shows
    /// besides, and nothing on another axis.
    fn rivals(&self, effect: &Fitted, found: &[&Fitted]) -> Vec<Term<'e>> {
        let mut rivals: Vec<(Term<'e>, usize)> = Vec::new();
        let lacking = self.answers.iter().filter(|answer| !is_in(answer, effect));
        for term in lacking.flatten() {
            let is_elsewhere = effect.axis().zip(term.effect.axis()).is_some_and(|(a, b)| a != b);
            if is_elsewhere || found.iter().any(|other| other.is_the_same(term.effect)) {
                continue;
            }
            match rivals.iter_mut().find(|(rival, _)| rival.effect.is_the_same(term.effect)) {
                Some((_, count)) => *count += 1,
                None => rivals.push((term.clone(), 1)),
            }
        }
        rivals.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        rivals.into_iter().take(RIVALS_MAX).map(|(term, _)| term).collect()
    }
}

fn is_in(answer: &[Term<'_>], effect: &Fitted) -> bool {
    answer.iter().any(|term| term.effect.is_the_same(effect))
}

/// What a cut gives, as if it were all of the log, in the effects of the whole one; none where it has no answer.
fn found_in<'e>(cut: &Log, subject: &Subject<'_>, known: &Known, effects: &[&'e Fitted]) -> Option<Vec<Term<'e>>> {
    let of_whole = |term: &Term<'_>| {
        let effect = effects.iter().find(|effect| effect.is_the_same(term.effect))?;
        Some(Term { effect, values: term.values.clone() })
    };
    let found = searched(cut, subject, known, &|_| (), |search, found| {
        let found = evidence::bootstrap::confirmed(search, found);
        found.findings(search).iter().filter_map(of_whole).collect()
    });
    found.ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;
    use crate::effects::Scope;

    fn catalogue() -> Vec<Fitted> {
        Fitted::hypotheses(&Scope::OF_AXES)
    }

    /// Answers by the names of their effects, all on pitch.
    fn stability<'e>(catalogue: &'e [Fitted], answers: &[&[&str]]) -> Stability<'e> {
        let terms = |names: &&[&str]| names.iter().map(|name| term(catalogue, name)).collect();
        Stability { answers: answers.iter().map(terms).collect() }
    }

    fn term<'e>(catalogue: &'e [Fitted], name: &str) -> Term<'e> {
        let on_pitch = |effect: &&Fitted| effect.name() == name && effect.axis().is_none_or(|axis| axis == Axis::Pitch);
        let effect = catalogue.iter().find(on_pitch).unwrap();
        Term { effect, values: effect.unknowns().iter().map(|unknown| unknown.nominal).collect() }
    }

    fn names(terms: &[Term<'_>]) -> Vec<&'static str> {
        terms.iter().map(|term| term.effect.name()).collect()
    }

    #[test]
    fn a_name_that_most_cuts_give_stays_and_one_that_few_give_goes() {
        let catalogue = catalogue();
        let found = [term(&catalogue, "spring"), term(&catalogue, "gyro_scale")];
        let mostly: [&[&str]; 8] = [&["spring"]; 8];
        let of_cuts = stability(&catalogue, &mostly);
        assert_eq!(names(&of_cuts.consensus(&found)), ["spring"]);
        assert_eq!(of_cuts.pct(found[0].effect), Some(100.0));
        assert!(of_cuts.one_of(found[0].effect, &[found[0].effect]).is_empty());
    }

    #[test]
    fn cuts_that_disagree_give_one_of_several_and_the_most_frequent_one() {
        let catalogue = catalogue();
        let found = [term(&catalogue, "cg_offset")];
        let answers: [&[&str]; 8] = [
            &["spring"],
            &["spring"],
            &["spring"],
            &["spring"],
            &["spring"],
            &["cg_offset"],
            &["cg_offset"],
            &["spring"],
        ];
        let of_cuts = stability(&catalogue, &answers);
        let agreed = of_cuts.consensus(&found);
        assert_eq!(names(&agreed), ["spring"]);
        let one_of = of_cuts.one_of(agreed[0].effect, &[agreed[0].effect]);
        let one_of: Vec<&str> = one_of.iter().map(|of| of.map_or("nothing", Fitted::name)).collect();
        assert_eq!(one_of, ["spring", "cg_offset"]);
        // where half of the cuts have neither, that is said too
        let halves: [&[&str]; 8] = [&["spring"], &[], &["spring"], &[], &["spring"], &[], &["cg_offset"], &[]];
        let of_cuts = stability(&catalogue, &halves);
        let spring = [term(&catalogue, "spring")];
        assert_eq!(names(&of_cuts.consensus(&spring)), ["spring"]);
        assert!(of_cuts.one_of(spring[0].effect, &[spring[0].effect]).iter().any(Option::is_none));
    }

    #[test]
    fn with_few_cuts_nothing_is_said_of_them() {
        let catalogue = catalogue();
        let found = [term(&catalogue, "spring")];
        let of_cuts = stability(&catalogue, &[&[], &[], &[]]);
        assert_eq!(of_cuts.pct(found[0].effect), None);
        assert_eq!(names(&of_cuts.consensus(&found)), ["spring"]);
        assert!(of_cuts.one_of(found[0].effect, &[found[0].effect]).is_empty());
    }
}
