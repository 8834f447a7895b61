//! What one effect more would explain of a log, to first order: one linearisation each, from which its fit goes on.

use super::dry_friction::{axis_of, for_viscous};
use super::progress::Progress;
use super::search::{Candidate, FITTED_MAX, SIGNIFICANT, Search};
use crate::diagnosis::fitting::fit::{Term, model_of, regular, with_priors};
use crate::diagnosis::fitting::hints::hints;
use crate::diagnosis::fitting::linearisation::{Eliminated, Linearisation, normal_beside};
use crate::diagnosis::fitting::shifted::shifted_models;
use crate::prediction::windowed_log::Residuals;
use crate::statistics::{Cholesky, dot};

/// A linearisation, and the same with the start states eliminated.
type Linear<'l> = (&'l Linearisation, &'l [Option<Eliminated<'l>>]);

/// A model with one effect more, before it is fitted.
pub(super) struct Scored<'e> {
    /// How far the effect would lower the training windows' sum of squares, to first order.
    pub(super) score: f64,
    pub(super) terms: Vec<Term<'e>>,
    /// Slopes along its numbers, window by window; none where its fit begins at values that change something already,
    /// and not what they should.
    pub(super) slopes: Option<Vec<Vec<Residuals>>>,
    /// Is it worth a fit whatever its score?
    pub(super) in_any_case: bool,
}

impl<'e> Search<'e> {
    /// The model's linearisation, and all ways to add one effect that may be significant, those that would explain most
    /// to first order first.
    pub(super) fn scored(&self, to: &Candidate<'e>) -> (Linearisation, Vec<Scored<'e>>) {
        let driven = self.shooting.log.drive(model_of(self.nominal, &to.fit.terms));
        let hints = hints(&self.shooting.log, &driven);
        let shifted = shifted_models(self.shooting, self.nominal, &to.fit.terms, 0);
        let linear = self.shooting.linearise(&driven, &shifted, &self.training, &to.fit.starts, None);
        let eliminated = linear.eliminated();
        let mut scored: Vec<Scored<'e>> = Vec::new();
        let effects = to.fit.terms.len() - self.always.len();
        let total = self.catalogue.len() + FITTED_MAX;
        for (done, effect) in self.catalogue.iter().enumerate() {
            (self.observer)(Progress::Searching { effects, done, total });
            if to.fit.terms.iter().any(|term| term.effect.is_the_same(effect)) {
                continue;
            }
            let added = |values| [to.fit.terms.as_slice(), &[Term { effect, values }]].concat();
            let mut begun: Vec<Vec<Term<'e>>> = effect.starts(&hints).into_iter().map(added).collect();
            begun.extend(self.has_base().then(|| for_viscous(self, &to.fit.terms, effect)).flatten());
            scored.extend(begun.into_iter().map(|terms| self.score(to, (&linear, &eliminated), terms)));
        }
        scored.sort_by(|a, b| b.score.total_cmp(&a.score));
        scored.retain(|scored| scored.score > 0.5 * SIGNIFICANT);
        // to first order a limit of the commands that is far from the true one explains little, however much the true
        // one would
        let is_limit = |scored: &&mut Scored<'e>| {
            scored.slopes.is_none() && axis_of(scored.terms[to.fit.terms.len()].effect).is_none()
        };
        if let Some(first) = scored.iter_mut().filter(|_| self.has_base()).find(is_limit) {
            first.in_any_case = true;
        }
        let beyond = scored.iter().skip(FITTED_MAX).position(|scored| scored.in_any_case);
        let beyond = beyond.map(|place| scored.swap_remove(FITTED_MAX + place));
        scored.truncate(FITTED_MAX);
        scored.extend(beyond);
        drop(eliminated);
        (linear, scored)
    }

    /// How far the last of the terms would lower the training windows' sum of squares, to first order.
    fn score(&self, to: &Candidate<'e>, (linear, eliminated): Linear<'_>, terms: Vec<Term<'e>>) -> Scored<'e> {
        let last = terms.len() - 1;
        let shifted = shifted_models(self.shooting, self.nominal, &terms, last);
        let (normal, slopes) = if terms[last].effect.is_void(&terms[last].values) {
            let extra = self.shooting.slopes_of(linear, &shifted, &self.training, &to.fit.starts);
            (normal_beside(eliminated, &extra), Some(extra))
        } else {
            let base = self.shooting.log.drive(model_of(self.nominal, &terms));
            let linear = self.shooting.linearise(&base, &shifted, &self.training, &to.fit.starts, Some(linear));
            (linear.normal(), None)
        };
        let normal = with_priors(normal, &terms);
        let size = normal.right.len();
        let gain = Cholesky::new(&regular(&normal.matrix, size, 1e-9), size)
            .map_or(0.0, |factor| dot(&factor.solve(&normal.right), &normal.right));
        Scored { score: to.fit.training - normal.chi2 + gain, terms, slopes, in_any_case: false }
    }
}
