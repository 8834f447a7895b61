//! Which effects: added one by one while each pays on windows that no fit has seen (those of choice), exchanged where
//! another explains more, taken out where they no longer pay.
//!
//! ```text
//! .-> hypotheses: score (one linearisation each) -> the best few: full fit -> windows of choice -> add the best
//! '---- take out what no longer pays, exchange what another explains better <----'
//! ```

use std::sync::OnceLock;

use super::enlarging::criterion;
use super::fitted::Fitted;
use super::holding::LastingGain;
use super::plausible::has_bound;
use super::progress::Observer;
use super::yardstick::Yardstick;
use crate::diagnosis::fitting::fit::{Fit, Nominal, Term, fit, fit_to_reach, model_of};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::prediction::accuracy::{predict, tallies, worst_ratio};
use crate::prediction::body::State;
use crate::prediction::windowed_log::Driven;
use crate::prediction::{Part, Window};

/// Hypotheses that are fitted in full after scoring.
pub(super) const FITTED_MAX: usize = 7;
/// Effects in one model.
const EFFECTS_MAX: usize = 5;
/// So many effects that leave a log far from explained are a wrong turn, where there is no base model beside them.
const FEW: usize = 3;
/// Multiple of an exact model's error that is far.
const FAR: f64 = 3.0;
/// Effects added, taken out again ones included.
const ROUNDS_MAX: usize = 8;
/// Fall of the sum of squares, in units of the remaining sum per degree of freedom, that a new effect must bring on all
/// windows, half of it on the training windows: a chance of 1e-4 over sixty hypotheses of up to three parameters.
pub(super) const SIGNIFICANT: f64 = 30.0;
/// The same on the windows of choice, where nothing was fitted.
const PAYS: f64 = 6.0;
/// Natural logarithm of the likelihood within which two models cannot be separated (docs/commands.md).
pub(super) const SEPARABLE: f64 = 3.0;
/// Share of the error that a finding must take away (docs/commands.md).
const SHARE_MIN: f64 = 0.02;

/// A log and the hypotheses tested on it.
pub(super) struct Search<'e> {
    pub(super) shooting: &'e Shooting<'e>,
    pub(super) nominal: Nominal<'e>,
    pub(super) catalogue: &'e [Fitted],
    /// What the nominal model itself leaves to be fitted, and with which values to begin.
    pub(super) gains: Vec<Term<'e>>,
    /// What is fitted along whatever the search finds: the gains, and the base model where it begins with one.
    pub(super) always: Vec<Term<'e>>,
    /// Windows that numbers are fitted to.
    pub(super) training: Vec<usize>,
    /// Windows that decide which effects are in the model.
    pub(super) choice: Vec<usize>,
    /// All windows but those of the report.
    pub(super) unreported: Vec<usize>,
    /// Windows of which errors are reported, or all of a log that is too short to spare any.
    pub(super) report: Vec<usize>,
    /// Receives the search's progress.
    pub(super) observer: Observer<'e>,
    /// What the judge measures by, once it has been asked.
    yardstick: OnceLock<Yardstick>,
    /// The gains if disturbances lasted.
    pub(super) lasting_gains: Vec<LastingGain>,
}

/// A fit and what it is worth.
#[derive(Clone)]
pub(super) struct Candidate<'e> {
    pub(super) fit: Fit<'e>,
    /// Sum of squares over the windows of choice.
    pub(super) choice: f64,
}

impl<'e> Candidate<'e> {
    /// The effect that was added last.
    pub(super) fn last_effect(&self) -> &'e Fitted {
        self.fit.terms[self.fit.terms.len() - 1].effect
    }
}

/// What a search chose.
pub(super) struct Choice<'e> {
    /// The model without effects.
    pub(super) nominal: Candidate<'e>,
    /// The chosen effects.
    pub(super) chosen: Candidate<'e>,
    /// Per chosen effect: what else was fitted in its place, best first.
    pub(super) alternatives: Vec<Vec<Candidate<'e>>>,
}

impl<'e> Search<'e> {
    /// A log's windows and the hypotheses.
    pub(super) fn new(
        shooting: &'e Shooting<'e>,
        nominal: Nominal<'e>,
        catalogue: &'e [Fitted],
        gains: Vec<Term<'e>>,
        observer: Observer<'e>,
    ) -> Search<'e> {
        let of = |part: Part| shooting.log.part(&[part]);
        let mut report = of(Part::Report);
        if report.is_empty() {
            report = (0..shooting.log.windows.len()).collect();
        }
        let (training, choice) = (of(Part::Fit), of(Part::Choice));
        let unreported = shooting.log.part(&[Part::Fit, Part::Choice]);
        let always = gains.clone();
        let yardstick = OnceLock::new();
        let lasting_gains = Vec::new();
        Search {
            shooting,
            nominal,
            catalogue,
            gains,
            always,
            training,
            choice,
            unreported,
            report,
            observer,
            yardstick,
            lasting_gains,
        }
    }

    /// The same from a base model on, with what can be beside it.
    pub(super) fn from(self, base: &[Term<'e>], catalogue: &'e [Fitted]) -> Search<'e> {
        Search { always: base.to_vec(), catalogue, ..self }
    }

    /// The same, with what gains would be if disturbances lasted.
    pub(super) fn with_lasting_gains(self, lasting_gains: Vec<LastingGain>) -> Search<'e> {
        Search { lasting_gains, ..self }
    }

    /// What the judge measures by; the first model it is asked for is near enough to all others.
    pub(super) fn yardstick(&self, near: &Driven) -> &Yardstick {
        self.yardstick.get_or_init(|| Yardstick::new(self.shooting, &self.unreported, near))
    }

    /// Windows by their numbers.
    pub(super) fn windows(&self, which: &[usize]) -> Vec<Window> {
        which.iter().map(|index| self.shooting.log.windows[*index]).collect()
    }

    /// Chooses the effects of a log. Beside a base model they must help what is reported: the caller knows which of
    /// some larger models is the first that does.
    pub(super) fn choose(&self, helping: impl Fn(&Fit<'e>, &[&Fit<'e>]) -> Option<usize>) -> Choice<'e> {
        let nominal = self.nominal();
        let mut chosen = nominal.clone();
        let mut alternatives: Vec<Vec<Candidate<'e>>> = Vec::new();
        // each round adds one; revision may take some out again, and must not go round in circles
        for _ in 0..ROUNDS_MAX {
            let effects = chosen.fit.terms.len() - self.always.len();
            if effects == EFFECTS_MAX || effects >= FEW && !self.has_base() && self.is_far(&chosen) {
                break;
            }
            let Some((larger, others)) = self.enlarged(&chosen, &nominal, &helping) else { break };
            chosen = larger;
            alternatives.push(others);
            if chosen.fit.terms.len() > self.always.len() + 1 {
                (chosen, alternatives) = self.revised(chosen, &nominal);
            }
        }
        Choice { nominal, chosen, alternatives }
    }

    /// Does it begin with a base model?
    pub(super) fn has_base(&self) -> bool {
        self.always.len() > self.gains.len()
    }

    /// Has the nominal model motors with a lag of their own?
    pub(super) fn has_own_lag(&self) -> bool {
        (self.nominal)().drive.quickest_s().is_finite()
    }

    /// Is a model far from explaining the windows of choice?
    pub(super) fn is_far(&self, candidate: &Candidate<'e>) -> bool {
        let log = &self.shooting.log;
        let driven = log.drive(model_of(self.nominal, &candidate.fit.terms));
        let predicted = predict(log, &driven, &self.windows(&self.choice));
        worst_ratio(&tallies(&predicted)) > FAR
    }

    /// The model without any effect, what it leaves to each log fitted.
    pub(super) fn nominal(&self) -> Candidate<'e> {
        self.settled(self.always.clone(), f64::INFINITY)
    }

    /// The model with these effects fitted from their values on, all start states at their best; given up where it
    /// can't come near a sum of squares.
    pub(super) fn settled(&self, terms: Vec<Term<'e>>, to_reach: f64) -> Candidate<'e> {
        self.chosen_by(self.settled_fit(terms, to_reach))
    }

    /// The fit alone, without what it leaves of the windows of choice.
    pub(super) fn settled_fit(&self, terms: Vec<Term<'e>>, to_reach: f64) -> Fit<'e> {
        let starts = self.settled_starts(&terms);
        self.fit_within_bounds(terms, &starts, &self.training, to_reach)
    }

    /// The chosen effects fitted to all windows: the residual is then what no model of them explains.
    pub(super) fn fitted_to_all(&self, chosen: &Candidate<'e>) -> Candidate<'e> {
        let all = self.shooting.log.in_use();
        let fit = fit(self.shooting, self.nominal, chosen.fit.terms.clone(), &chosen.fit.starts, &all);
        Candidate { fit, choice: chosen.choice }
    }

    /// A model fitted to all windows but those of the report, from values and start states on.
    pub(super) fn refitted(&self, terms: Vec<Term<'e>>, starts: &[State]) -> Fit<'e> {
        let mut refitted = self.fit_within_bounds(terms, starts, &self.unreported, f64::INFINITY);
        let driven = self.shooting.log.drive(model_of(self.nominal, &refitted.terms));
        self.shooting.settle(&driven, &self.report, &mut refitted.starts);
        refitted
    }

    /// The same fit with what leaving out parts of its windows says of its numbers.
    pub(super) fn with_parts_left_out(&self, refitted: Fit<'e>) -> Fit<'e> {
        refitted.with_parts_left_out(self.shooting, self.nominal, &self.unreported)
    }

    /// Start states of the training windows at their best under these effects, from the measured ones on.
    pub(super) fn settled_starts(&self, terms: &[Term<'e>]) -> Vec<State> {
        let driven = self.shooting.log.drive(model_of(self.nominal, terms));
        let mut starts = self.shooting.log.measured_starts(&driven.model);
        self.shooting.settle(&driven, &self.training, &mut starts);
        starts
    }

    /// The model with these effects fitted; given up where it can't come near a sum of squares.
    pub(super) fn fitted(&self, terms: Vec<Term<'e>>, starts: &[State], to_reach: f64) -> Candidate<'e> {
        self.chosen_by(self.fit_within_bounds(terms, starts, &self.training, to_reach))
    }

    /// A fit and what it leaves of the windows of choice.
    pub(super) fn chosen_by(&self, mut fit: Fit<'e>) -> Candidate<'e> {
        let driven = self.shooting.log.drive(model_of(self.nominal, &fit.terms));
        let choice = self.shooting.settle(&driven, &self.choice, &mut fit.starts).iter().sum();
        Candidate { fit, choice }
    }

    /// A fit of some windows. One that runs from a base model to the end of a range is none: with a delay so long that
    /// it has lost its command a model may be nearer to few windows than the right one is; its terms stay where they
    /// were.
    fn fit_within_bounds(&self, terms: Vec<Term<'e>>, starts: &[State], windows: &[usize], to_reach: f64) -> Fit<'e> {
        let fitted = fit_to_reach(self.shooting, self.nominal, terms.clone(), starts, windows, to_reach);
        if self.runs_off(&fitted, &terms) { self.as_it_was(terms, starts, windows) } else { fitted }
    }

    /// Has a fit run from these terms of a base model to the end of a range?
    pub(super) fn runs_off(&self, fitted: &Fit<'e>, terms: &[Term<'e>]) -> bool {
        self.has_base() && has_bound(&fitted.terms) && !has_bound(terms)
    }

    /// A fit that stays where it begins.
    pub(super) fn as_it_was(&self, terms: Vec<Term<'e>>, starts: &[State], windows: &[usize]) -> Fit<'e> {
        fit_to_reach(self.shooting, self.nominal, terms, starts, windows, f64::NEG_INFINITY)
    }

    /// Is the larger model worth its parameters?
    pub(super) fn pays(&self, smaller: &Candidate<'e>, larger: &Candidate<'e>, nominal: &Candidate<'e>) -> bool {
        let spread = self.spread(larger);
        let training = (smaller.fit.training - larger.fit.training) / spread;
        let choice = (smaller.choice - larger.choice) / spread;
        let excess = nominal.choice - self.shooting.degrees_of_freedom(&self.choice);
        let is_significant = training + choice > SIGNIFICANT && training > 0.5 * SIGNIFICANT;
        is_significant && choice > PAYS && choice * spread > SHARE_MIN * SHARE_MIN * excess.max(0.0)
    }

    /// Mean square that a model leaves on the training windows, in units of the noise: where no model of the catalogue
    /// explains a log, its sums of squares mean that much less.
    pub(super) fn spread(&self, candidate: &Candidate<'e>) -> f64 {
        (candidate.fit.training / self.shooting.degrees_of_freedom(&self.training)).max(1.0)
    }

    /// Takes out what no longer pays and exchanges what another explains better, until nothing changes.
    fn revised(&self, mut chosen: Candidate<'e>, nominal: &Candidate<'e>) -> (Candidate<'e>, Vec<Vec<Candidate<'e>>>) {
        for _ in 0..EFFECTS_MAX {
            let mut better = None;
            let mut alternatives = Vec::new();
            for index in self.always.len()..chosen.fit.terms.len() {
                let mut terms = chosen.fit.terms.clone();
                let removed = terms.remove(index);
                let without = self.fitted(terms, &chosen.fit.starts, f64::INFINITY);
                if !self.pays(&without, &chosen, nominal) {
                    better = Some(without);
                    break;
                }
                let others = self.extensions(&without, without.fit.training - chosen.fit.training);
                let exchanged = others.iter().find(|other| {
                    !other.last_effect().is_the_same(removed.effect) && self.is_preferred(other, &chosen)
                });
                if let Some(exchanged) = exchanged {
                    better = Some(exchanged.clone());
                    break;
                }
                alternatives.push(
                    others.into_iter().filter(|other| !other.last_effect().is_the_same(removed.effect)).collect(),
                );
            }
            match better {
                Some(better) => chosen = better,
                None => return (chosen, alternatives),
            }
        }
        let none = vec![Vec::new(); chosen.fit.terms.len() - self.always.len()];
        (chosen, none)
    }

    /// Is another model clearly better, or as good with fewer parameters?
    fn is_preferred(&self, other: &Candidate<'e>, chosen: &Candidate<'e>) -> bool {
        let spread = self.spread(chosen);
        criterion(other) + PAYS * spread < criterion(chosen)
            || other.fit.size() < chosen.fit.size() && other.choice < chosen.choice + 2.0 * SEPARABLE * spread
    }
}
