//! Output error over windows: the parameters of some effects, by Gauss and Newton with Levenberg's damping.

use crate::diagnosis::fitted::Fitted;
use crate::diagnosis::fitting::bounded_step::{BoundedStep, Step};
use crate::diagnosis::fitting::left_out::LeftOut;
use crate::diagnosis::fitting::linearisation::Normal;
use crate::diagnosis::fitting::round::{Attempt, Round};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::prediction::body::State;
use crate::prediction::model::Model;
use crate::statistics::{Cholesky, dot};

/// Rounds of linearisation.
const ROUNDS_MAX: usize = 12;
/// The fit has ended when a round can lower the sum of squares by no more than this, in units of what is left per
/// degree of freedom: a step of a fifth of a standard deviation at most.
const IMPROVEMENT_MIN: f64 = 0.05;
/// A fit explains at most so many times what a linearisation promises; what could not win even so is given up.
pub(in crate::diagnosis) const OVERSHOT: f64 = 3.0;
/// Rounds that make no progress before the fit is given up.
const FAILURES_MAX: usize = 5;

/// How the nominal vehicle of a log is made.
pub(in crate::diagnosis) type Nominal<'a> = &'a (dyn Fn() -> Model + Sync);

/// An effect with values for its parameters.
#[derive(Clone)]
pub(in crate::diagnosis) struct Term<'e> {
    pub(in crate::diagnosis) effect: &'e Fitted,
    pub(in crate::diagnosis) values: Vec<f64>,
}

/// What a nominal model leaves to each log, as terms of a fit at which nothing is commanded yet.
pub(in crate::diagnosis) fn as_terms(along: &[Fitted]) -> Vec<Term<'_>> {
    along.iter().map(|gain| Term { effect: gain, values: vec![0.0] }).collect()
}

/// A set of effects fitted to the training windows.
#[derive(Clone)]
pub(in crate::diagnosis) struct Fit<'e> {
    pub(in crate::diagnosis) terms: Vec<Term<'e>>,
    /// Covariance of all parameters one behind the other if the noise is what it is taken for, row by row.
    pub(in crate::diagnosis) covariance: Vec<f64>,
    /// The same as the scatter of the windows' own wishes has it ([`scattered`]).
    pub(super) scattered_covariance: Vec<f64>,
    /// What becomes of them where a part of the windows is left out; nothing as long as nobody asked.
    pub(super) left_out: LeftOut,
    /// Sum of squares over the training windows, in units of the noise.
    pub(in crate::diagnosis) training: f64,
    /// Start states of all windows, those that were not fitted as given.
    pub(in crate::diagnosis) starts: Vec<State>,
}

impl<'e> Fit<'e> {
    /// Number of parameters.
    pub(in crate::diagnosis) fn size(&self) -> usize {
        self.terms.iter().map(|term| term.values.len()).sum()
    }

    /// The same fit to those windows with what leaving out parts of them says of its numbers.
    pub(in crate::diagnosis) fn with_parts_left_out(
        mut self,
        shooting: &Shooting<'_>,
        nominal: Nominal<'_>,
        windows: &[usize],
    ) -> Fit<'e> {
        self.left_out = LeftOut::of(&self, shooting, nominal, windows);
        self
    }

    /// Variance of a number that depends on all parameters by these slopes: the larger one of what the scatter of the
    /// windows' wishes has, and of what leaving out parts of the flight has. Infinite where the fit says nothing.
    pub(in crate::diagnosis) fn variance_along(&self, slope: &[f64]) -> f64 {
        let rows = self.scattered_covariance.chunks(slope.len().max(1));
        let carried: Vec<f64> = rows.map(|row| dot(row, slope)).collect();
        let scattered = dot(slope, &carried);
        if scattered.is_finite() { scattered.max(self.left_out.variance_along(slope)) } else { f64::INFINITY }
    }

    /// Per parameter of the fit, by how much some numbers that follow from its terms change with it.
    pub(in crate::diagnosis) fn slopes_of(&self, of_terms: impl Fn(&[Term<'e>]) -> Vec<f64>) -> Vec<Vec<f64>> {
        let steps = self.terms.iter().flat_map(|term| term.effect.unknowns()).map(|unknown| unknown.step);
        let along = |(place, step): (usize, f64)| {
            // a number at the end of its range moves to one side alone
            let by = |by: f64| {
                let mut all = vec![0.0; self.size()];
                all[place] = by;
                let step = Step::straight(&self.terms, &all);
                (step.to[place], of_terms(&step.applied(&self.terms)))
            };
            let ((less, of_less), (more, of_more)) = (by(-step), by(step));
            of_less.iter().zip(&of_more).map(|(of_less, of_more)| (of_more - of_less) / (more - less)).collect()
        };
        steps.enumerate().map(along).collect()
    }

    /// Variance of one of a term's parameters.
    pub(in crate::diagnosis) fn variance_of(&self, term: usize, parameter: usize) -> f64 {
        let mut slope = vec![0.0; self.size()];
        slope[self.first_place_of(term) + parameter] = 1.0;
        self.variance_along(&slope)
    }

    /// By how many of its standard deviations one of a term's parameters is more than a value.
    pub(in crate::diagnosis) fn deviations_from(&self, value: f64, term: usize, parameter: usize) -> f64 {
        let std = self.variance_of(term, parameter).max(f64::MIN_POSITIVE).sqrt();
        (self.terms[term].values[parameter] - value) / std
    }

    /// Place of a term's first parameter among all.
    pub(in crate::diagnosis) fn first_place_of(&self, term: usize) -> usize {
        self.terms[..term].iter().map(|term| term.values.len()).sum()
    }

    /// How all numbers move to first order, within their ranges, where those of some terms are known to change
    /// nothing.
    pub(in crate::diagnosis) fn step_without(&self, terms: &[usize]) -> Step {
        let is_out = self.terms.iter().enumerate().filter(|(index, _)| terms.contains(index));
        let numbers = is_out.flat_map(|(_, term)| term.effect.unknowns().iter().zip(&term.values));
        let away: Vec<f64> = numbers.map(|(unknown, value)| unknown.nominal - value).collect();
        let (size, out) = (self.size(), self.places_of(terms));
        let part = |rows: &[usize], columns: &[usize]| -> Vec<f64> {
            rows.iter().flat_map(|i| columns.iter().map(move |j| self.covariance[i * size + j])).collect()
        };
        let apart = Cholesky::new(&regular(&part(&out, &out), out.len(), 0.0), out.len());
        let all: Vec<usize> = (0..size).collect();
        let step: Vec<f64> = match apart.map(|factor| factor.solve(&away)) {
            Some(weights) => part(&all, &out).chunks(out.len().max(1)).map(|row| dot(row, &weights)).collect(),
            None => vec![0.0; size],
        };
        Step::cut(&self.terms, &step, &out)
    }

    /// Places of some terms' numbers among all.
    pub(in crate::diagnosis) fn places_of(&self, terms: &[usize]) -> Vec<usize> {
        let owners = self.terms.iter().enumerate().flat_map(|(index, term)| term.values.iter().map(move |_| index));
        owners.enumerate().filter(|(_, owner)| terms.contains(owner)).map(|(place, _)| place).collect()
    }

    /// The fit without some of its terms, the others moved by `step` ([`Self::step_without`]). Their covariances stay
    /// as they were.
    pub(in crate::diagnosis) fn expected_without(&self, terms: &[usize], step: &Step) -> Fit<'e> {
        let (size, out) = (self.size(), self.places_of(terms));
        let moved = step.applied(&self.terms);
        let kept = moved.into_iter().enumerate().filter(|(index, _)| !terms.contains(index)).map(|(_, term)| term);
        let others = |matrix: &[f64]| -> Vec<f64> {
            let is_out = |place: usize| out.contains(&place);
            let kept = matrix.iter().enumerate().filter(|(k, _)| !is_out(k / size) && !is_out(k % size));
            kept.map(|(_, value)| *value).collect()
        };
        Fit {
            terms: kept.collect(),
            covariance: others(&self.covariance),
            scattered_covariance: others(&self.scattered_covariance),
            left_out: LeftOut::default(),
            training: self.training,
            starts: self.starts.clone(),
        }
    }
}

/// The model with these terms in it.
pub(in crate::diagnosis) fn model_of(nominal: Nominal<'_>, terms: &[Term<'_>]) -> Model {
    let mut model = nominal();
    for term in terms {
        term.effect.apply(&term.values, &mut model);
    }
    model
}

/// Fits the terms from their values on, and the start states of the training windows from `starts` on.
pub(in crate::diagnosis) fn fit<'e>(
    shooting: &Shooting<'_>,
    nominal: Nominal<'_>,
    terms: Vec<Term<'e>>,
    starts: &[State],
    training: &[usize],
) -> Fit<'e> {
    fit_to_reach(shooting, nominal, terms, starts, training, f64::INFINITY)
}

/// The same, given up where the sum of squares can't come down to `to_reach`.
pub(in crate::diagnosis) fn fit_to_reach<'e>(
    shooting: &Shooting<'_>,
    nominal: Nominal<'_>,
    terms: Vec<Term<'e>>,
    starts: &[State],
    training: &[usize],
    to_reach: f64,
) -> Fit<'e> {
    let first = Round::first(shooting, nominal, terms, starts, training);
    fit_from(shooting, nominal, first, training, to_reach)
}

/// The same, its first linearisation done already.
pub(in crate::diagnosis) fn fit_from<'e>(
    shooting: &Shooting<'_>,
    nominal: Nominal<'_>,
    first: Round<'e>,
    training: &[usize],
    to_reach: f64,
) -> Fit<'e> {
    let last = match end_from(shooting, nominal, first, training, to_reach) {
        End::Linearised(round) => round,
        End::Moved(attempt) => attempt.round(shooting, nominal, training),
    };
    last.result(shooting, training)
}

/// The numbers alone of the same, not how sure they are.
pub(super) fn values_from(
    shooting: &Shooting<'_>,
    nominal: Nominal<'_>,
    first: Round<'_>,
    training: &[usize],
) -> Vec<f64> {
    match end_from(shooting, nominal, first, training, f64::INFINITY) {
        End::Linearised(round) => all_values(&round.terms),
        End::Moved(attempt) => all_values(&attempt.terms),
    }
}

/// Where a fit ends.
enum End<'e> {
    /// Where its slopes are known.
    Linearised(Round<'e>),
    /// A last step further: slopes there say how sure its numbers are, and move none.
    Moved(Attempt<'e>),
}

fn end_from<'e>(
    shooting: &Shooting<'_>,
    nominal: Nominal<'_>,
    first: Round<'e>,
    training: &[usize],
    to_reach: f64,
) -> End<'e> {
    let mut best = first;
    let mut damping = 1e-4;
    let mut failures = 0;
    for round in 1..=ROUNDS_MAX {
        let Some(BoundedStep { step, promised }) = best.step(damping) else { break };
        let least = IMPROVEMENT_MIN * spread(best.normal.chi2, shooting, training);
        if promised < least || best.normal.chi2 - OVERSHOT * promised > to_reach {
            break;
        }
        let terms = step.applied(&best.terms);
        let mut starts = best.starts.clone();
        shooting.move_starts(&best.linear, &step.by, training, &mut starts);
        let next = Attempt::at(shooting, nominal, terms, starts, training, Some(&best));
        if next.chi2 < best.normal.chi2 {
            if best.normal.chi2 - next.chi2 < least || round == ROUNDS_MAX {
                return End::Moved(next);
            }
            best = next.round(shooting, nominal, training);
            damping = (damping * 0.1).max(1e-9);
            failures = 0;
        } else {
            damping = (damping * 30.0).max(1e-4);
            failures += 1;
            if failures == FAILURES_MAX {
                break;
            }
        }
    }
    End::Linearised(best)
}

/// Mean square that is left per degree of freedom, in units of the noise; never less than that of noise alone.
pub(super) fn spread(chi2: f64, shooting: &Shooting<'_>, training: &[usize]) -> f64 {
    (chi2 / shooting.degrees_of_freedom(training)).max(1.0)
}

/// Normal equations of all numbers of some terms, with what is known of these beside the log.
pub(in crate::diagnosis) fn with_priors(mut normal: Normal, terms: &[Term<'_>]) -> Normal {
    let size = normal.right.len();
    let numbers = terms.iter().flat_map(|term| term.effect.unknowns().iter().zip(&term.values));
    for (place, (unknown, value)) in numbers.enumerate().take(size) {
        let Some(prior) = unknown.prior else { continue };
        let weight = 1.0 / (prior.std * prior.std);
        let away = value - prior.mean;
        normal.matrix[place * size + place] += weight;
        normal.right[place] -= weight * away;
    }
    normal.chi2 += prior_chi2(terms);
    normal
}

/// What is known beside the log of the numbers of some terms, as a sum of squares.
pub(super) fn prior_chi2(terms: &[Term<'_>]) -> f64 {
    let numbers = terms.iter().flat_map(|term| term.effect.unknowns().iter().zip(&term.values));
    let away = numbers.filter_map(|(unknown, value)| unknown.prior.map(|prior| (value - prior.mean) / prior.std));
    away.map(|away| away * away).sum()
}

/// The matrix damped along its diagonal; a parameter without any influence stays where it is.
pub(in crate::diagnosis) fn regular(matrix: &[f64], size: usize, damping: f64) -> Vec<f64> {
    let mut regular = matrix.to_vec();
    for i in 0..size {
        let own = matrix[i * size + i];
        regular[i * size + i] = if own > 0.0 { own * (1.0 + damping + 1e-12) } else { 1.0 };
    }
    regular
}

/// All numbers of some terms, one behind the other.
pub(super) fn all_values(terms: &[Term<'_>]) -> Vec<f64> {
    terms.iter().flat_map(|term| term.values.iter().copied()).collect()
}
