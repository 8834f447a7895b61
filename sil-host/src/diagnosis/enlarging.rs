//! Models with one effect more: hypotheses are scored to first order, the best fitted in full, and one taken that is
//! worth its parameters.

use super::plausible::is_plausible;
use super::progress::Progress;
use super::scoring::Scored;
use super::search::{Candidate, FITTED_MAX, SEPARABLE, Search};
use crate::diagnosis::fitting::fit::{Fit, OVERSHOT, fit_from};
use crate::diagnosis::fitting::linearisation::Linearisation;
use crate::diagnosis::fitting::round::Round;

impl<'e> Search<'e> {
    /// The best model with one effect more that is worth it, and what else was fitted in its place. Beside a base model
    /// what was passed over for effects that explain more gets its turn once all of those were refused: a gust may look
    /// like dry friction, and explain more than the onset that is there.
    pub(super) fn enlarged(
        &self,
        smaller: &Candidate<'e>,
        nominal: &Candidate<'e>,
        helping: impl Fn(&Fit<'e>, &[&Fit<'e>]) -> Option<usize>,
    ) -> Option<(Candidate<'e>, Vec<Candidate<'e>>)> {
        let (linear, mut scored) = self.scored(smaller);
        // the best of what is left is always fitted, so that each turn leaves less
        while !scored.is_empty() {
            let (mut larger, passed_over) = self.worth_a_fit(smaller, &linear, scored, 0.0);
            let pays = |larger: &Candidate<'e>| self.pays(smaller, larger, nominal);
            let place = if self.has_base() {
                let paying: Vec<usize> = (0..larger.len()).filter(|place| pays(&larger[*place])).collect();
                let fits: Vec<&Fit<'e>> = paying.iter().map(|place| &larger[*place].fit).collect();
                helping(&smaller.fit, &fits).map(|helping| paying[helping])
            } else {
                larger.first().filter(|best| pays(best)).map(|_| 0)
            };
            if let Some(place) = place {
                let best = larger.remove(place);
                return Some((best, larger));
            }
            scored = if self.has_base() { passed_over } else { Vec::new() };
        }
        None
    }

    /// All ways to add one effect that are worth a full fit, best first. Those that explain far less than `known` does,
    /// a fall of the training windows' sum of squares, are not.
    pub(super) fn extensions(&self, to: &Candidate<'e>, known: f64) -> Vec<Candidate<'e>> {
        let (linear, scored) = self.scored(to);
        self.worth_a_fit(to, &linear, scored, known).0
    }

    /// Those of some hypotheses that are worth a full fit, best first, and what was passed over, since it explains far
    /// less than the best.
    fn worth_a_fit(
        &self,
        to: &Candidate<'e>,
        linear: &Linearisation,
        scored: Vec<Scored<'e>>,
        known: f64,
    ) -> (Vec<Candidate<'e>>, Vec<Scored<'e>>) {
        let (mut fits, mut passed_over) = (Vec::new(), Vec::new());
        let mut most = known;
        let (effects, total) = (to.fit.terms.len() - self.always.len(), self.catalogue.len() + FITTED_MAX);
        for (done, scored) in (self.catalogue.len()..).zip(scored) {
            (self.observer)(Progress::Searching { effects, done, total });
            if OVERSHOT * scored.score < most && !scored.in_any_case {
                passed_over.push(scored);
                continue;
            }
            let fit = self.extended(to, linear, scored, to.fit.training - most);
            most = most.max(to.fit.training - fit.fit.training);
            fits.push(fit);
        }
        (self.best_first(fits), passed_over)
    }

    /// The same of a hypothesis, whose score has done the first linearisation of the fit where it could.
    fn extended(&self, to: &Candidate<'e>, linear: &Linearisation, scored: Scored<'e>, to_reach: f64) -> Candidate<'e> {
        let Scored { terms, slopes, .. } = scored;
        let Some(slopes) = slopes else { return self.fitted(terms, &to.fit.starts, to_reach) };
        let first = Round::beside(linear, slopes, terms.clone(), &to.fit.starts);
        let fitted = fit_from(self.shooting, self.nominal, first, &self.training, to_reach);
        if self.runs_off(&fitted, &terms) {
            return self.chosen_by(self.as_it_was(terms, &to.fit.starts, &self.training));
        }
        self.chosen_by(fitted)
    }

    /// Plausible models, each effect once, best first.
    fn best_first(&self, mut fits: Vec<Candidate<'e>>) -> Vec<Candidate<'e>> {
        fits.sort_by(|a, b| criterion(a).total_cmp(&criterion(b)));
        // of two starts of the same effect the better one counts
        let mut seen: Vec<Candidate<'e>> = Vec::new();
        for fit in fits {
            let is_seen = seen.iter().any(|other| other.last_effect().is_the_same(fit.last_effect()));
            if !is_seen && is_plausible(self.shooting, self.nominal, &fit.fit.terms) {
                seen.push(fit);
            }
        }
        self.simplest_first(&mut seen);
        seen
    }

    /// Of those that the log cannot separate from the best, the one with the fewest parameters goes first.
    fn simplest_first(&self, fits: &mut [Candidate<'e>]) {
        let Some(best) = fits.first() else { return };
        let limit = best.choice + 2.0 * SEPARABLE * self.spread(best);
        let inseparable = fits.iter().enumerate().filter(|(_, fit)| fit.choice < limit);
        if let Some((place, _)) = inseparable.min_by_key(|(_, fit)| fit.fit.size()) {
            fits[..=place].rotate_right(1);
        }
    }
}

/// Sum of squares over the windows of choice with a penalty for each parameter.
pub(super) fn criterion(candidate: &Candidate<'_>) -> f64 {
    candidate.choice + 2.0 * candidate.fit.size() as f64
}
