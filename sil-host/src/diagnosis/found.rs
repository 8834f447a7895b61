//! What a search found, from the choice of effects to what is reported of it: most important first, judged beside a
//! base model, fitted to all windows but those of the report.

use super::judge::{doubtful, first_that_helps, floors, judged, losses, unusual_terms};
use super::search::{Candidate, Choice, Search};
use crate::diagnosis::fitting::fit::{Fit, Term, model_of};
use crate::prediction::body::State;

/// What the search found.
pub(super) struct Found<'e> {
    /// The model without effects.
    pub(super) nominal: Candidate<'e>,
    /// The chosen effects, most important first.
    pub(super) chosen: Candidate<'e>,
    /// Per chosen effect: what else was fitted in its place, best first.
    pub(super) alternatives: Vec<Vec<Candidate<'e>>>,
    /// Places of the base model's terms that are findings too.
    pub(super) unusual: Vec<usize>,
    /// The models once the choice is made, fitted to all windows but those of the report.
    pub(super) refitted: Refitted<'e>,
}

/// Models fitted to all windows but those of the report.
pub(super) struct Refitted<'e> {
    /// Without effects.
    pub(super) nominal: Fit<'e>,
    /// The base model; the nominal one where the search did without.
    pub(super) base: Fit<'e>,
    /// With the chosen ones.
    pub(super) chosen: Fit<'e>,
}

impl<'e> Found<'e> {
    /// The terms that are findings, those of the base model last.
    pub(super) fn findings(&self, search: &Search<'_>) -> Vec<Term<'e>> {
        let terms = &self.refitted.chosen.terms;
        let places = (search.always.len()..terms.len()).chain(self.unusual.iter().copied());
        places.map(|place| terms[place].clone()).collect()
    }

    /// What else was fitted in place of a term of the chosen model; nothing of one of the base model.
    pub(super) fn alternatives_of(&self, search: &Search<'_>, index: usize) -> &[Candidate<'e>] {
        index.checked_sub(search.always.len()).and_then(|place| self.alternatives.get(place)).map_or(&[], Vec::as_slice)
    }
}

impl<'e> Search<'e> {
    /// Squared errors over the windows of the report under the terms that are left of the extended model. Beside a base
    /// model they are fitted anew: trims and lags take up some of what is missing.
    pub(super) fn left_without(&self, found: &Found<'e>, terms: Vec<Term<'e>>) -> Vec<f64> {
        let terms = if self.has_base() { self.refitted(terms, &found.refitted.chosen.starts).terms } else { terms };
        losses(self, &terms, &floors(self, &found.refitted.chosen.terms))
    }

    /// Looks for the effects in a log.
    pub(super) fn run(&self) -> Found<'e> {
        self.found(self.choose(|smaller, larger| first_that_helps(self, smaller, larger)))
    }

    /// What is reported of a choice, the effect first whose loss would cost most on the windows of choice.
    fn found(&self, Choice { nominal, chosen, alternatives }: Choice<'e>) -> Found<'e> {
        let loss = |index: usize| {
            self.losses_without([&nominal.fit, &chosen.fit], index, &self.choice).iter().sum::<f64>() - chosen.choice
        };
        let first = self.always.len();
        let mut order: Vec<(usize, f64)> = (first..chosen.fit.terms.len()).map(|index| (index, loss(index))).collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut alternatives: Vec<Option<Vec<Candidate<'e>>>> = alternatives.into_iter().map(Some).collect();
        let mut terms = chosen.fit.terms[..first].to_vec();
        terms.extend(order.iter().map(|(index, _)| chosen.fit.terms[*index].clone()));
        let alternatives: Vec<Vec<Candidate<'e>>> = order
            .iter()
            .map(|(index, _)| alternatives.get_mut(index - first).and_then(Option::take).unwrap_or_default())
            .collect();
        let chosen = self.fitted(terms, &chosen.fit.starts, f64::INFINITY);
        let bases = self.refitted_bases(&nominal);
        self.concluded(nominal, bases, chosen, alternatives, &|_| true)
    }

    /// The same with what most cuts of the log give: `wanted` are findings, those of the base model's terms included.
    pub(super) fn agreed(&self, found: Found<'e>, wanted: &[Term<'e>]) -> Found<'e> {
        let is_wanted = |term: &Term<'e>| wanted.iter().any(|other| other.effect.is_the_same(term.effect));
        let first = self.always.len();
        let (base, own) = found.chosen.fit.terms.split_at(first);
        let is_of_base = |term: &&Term<'e>| base.iter().any(|other| other.effect.is_the_same(term.effect));
        let is_new = |term: &&Term<'e>| !own.iter().any(|other| other.effect.is_the_same(term.effect));
        let new: Vec<Term<'e>> = wanted.iter().filter(|term| !is_of_base(term) && is_new(term)).cloned().collect();
        let mut agreed = if new.is_empty() && own.iter().all(is_wanted) {
            found
        } else {
            let kept = own.iter().zip(&found.alternatives).filter(|(term, _)| is_wanted(term));
            let (mut own, mut alternatives): (Vec<_>, Vec<_>) =
                kept.map(|(term, others)| (term.clone(), others.clone())).unzip();
            alternatives.extend(new.iter().map(|_| Vec::new()));
            own.extend(new);
            let terms = [base, &own].concat();
            let chosen = self.fitted(terms, &found.chosen.fit.starts, f64::INFINITY);
            let bases = [found.refitted.nominal, found.refitted.base];
            self.concluded(found.nominal, bases, chosen, alternatives, &is_wanted)
        };
        let terms = &agreed.refitted.chosen.terms;
        agreed.unusual.retain(|place| is_wanted(&terms[*place]));
        agreed
    }

    /// A model fitted to all windows but those of the report.
    pub(super) fn again(&self, candidate: &Candidate<'e>) -> Fit<'e> {
        self.refitted(candidate.fit.terms.clone(), &candidate.fit.starts)
    }

    /// The nominal and the base model as they are reported.
    fn refitted_bases(&self, base: &Candidate<'e>) -> [Fit<'e>; 2] {
        let base = self.again(base);
        let nominal =
            if self.has_base() { self.again(&self.settled(self.gains.clone(), f64::INFINITY)) } else { base.clone() };
        [nominal, base]
    }

    /// What is reported of chosen effects; of the base model's terms those may be findings that the caller says.
    fn concluded(
        &self,
        nominal: Candidate<'e>,
        [unfitted, base]: [Fit<'e>; 2],
        chosen: Candidate<'e>,
        alternatives: Vec<Vec<Candidate<'e>>>,
        may_be_unusual: &dyn Fn(&Term<'e>) -> bool,
    ) -> Found<'e> {
        let first = self.always.len();
        // without effects it is the same model, whatever way its fit came
        let all = if chosen.fit.terms.len() == first { base.clone() } else { self.again(&chosen) };
        if !self.has_base() {
            let refitted = Refitted { nominal: unfitted, base, chosen: all };
            return Found { nominal, chosen, alternatives, unusual: Vec::new(), refitted };
        }
        let kept = self.beyond_chance(&base, judged(self, base.clone(), all));
        let is_kept = |term: &Term<'e>| kept.terms.iter().any(|other| other.effect.is_the_same(term.effect));
        let terms = chosen.fit.terms[first..].iter().zip(alternatives);
        let alternatives = terms.filter(|(term, _)| is_kept(term)).map(|(_, others)| others).collect();
        let chosen = self.fitted(kept.terms.clone(), &kept.starts, f64::INFINITY);
        let unusual = unusual_terms(self, &kept, may_be_unusual);
        let refitted = Refitted { nominal: unfitted, base, chosen: kept };
        Found { nominal, chosen, alternatives, unusual, refitted }
    }

    /// A model with what leaving out parts of the log says of its numbers, without the findings that are nothing by
    /// that, the most doubtful first.
    fn beyond_chance(&self, base: &Fit<'e>, judged: Fit<'e>) -> Fit<'e> {
        let first = self.always.len();
        let mut kept = judged;
        loop {
            // without effects it is the base model, whatever way its fit came
            let fit = if kept.terms.len() == first { base.clone() } else { kept };
            let fit = self.with_parts_left_out(fit);
            let Some(doubtful) = doubtful(&fit, first..fit.terms.len()) else { return fit };
            let mut terms = fit.terms;
            terms.remove(doubtful);
            kept = self.refitted(terms, &fit.starts);
        }
    }

    /// Sums of squares of some windows with one effect simply left out. Start states are sought from those of the
    /// chosen model and from those of the nominal one: the best ones may be near to either.
    fn losses_without(&self, [nominal, chosen]: [&Fit<'e>; 2], index: usize, windows: &[usize]) -> Vec<f64> {
        let mut terms = chosen.terms.clone();
        terms.remove(index);
        let [far, near] = [chosen, nominal].map(|fit| self.losses(&terms, &fit.starts, windows));
        far.iter().zip(&near).map(|(far, near)| far.min(*near)).collect()
    }

    /// Sums of squares of some windows under a model, their start states at their best from given ones on.
    fn losses(&self, terms: &[Term<'e>], starts: &[State], windows: &[usize]) -> Vec<f64> {
        let driven = self.shooting.log.drive(model_of(self.nominal, terms));
        self.shooting.settle(&driven, windows, &mut starts.to_vec())
    }
}
