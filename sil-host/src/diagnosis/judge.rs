//! The judge is what a user sees: the error of open-loop predictions, channel by channel, over windows that nothing was
//! fitted to (about axes whose commands hold against a disturbance, of each row from those before it: `yardstick`).
//! What is in a model stays if it takes a share of that error away beyond chance, and if no channel is worse for it
//! beyond chance, by such a share. The search's own measure, a likelihood, is about the next row given all rows before;
//! a model may be better at that and worse at what it is for.
//!
//! The windows of the report are not looked at. Over the others, fold by fold, each is predicted with the numbers that
//! the other folds give (one step of Newton's from those of all).

use rayon::prelude::*;

use crate::axis::Axis;
use crate::diagnosis::block_bootstrap::{interval, interval_of_one};
use crate::diagnosis::dry_friction;
use crate::diagnosis::fitting::bounded_step::BoundedStep;
use crate::diagnosis::fitting::fit::{Fit, Term, model_of, with_priors};
use crate::diagnosis::fitting::linearisation::Normal;
use crate::diagnosis::fitting::shifted::shifted_models;
use crate::diagnosis::search::Search;
use crate::diagnosis::usual::may_be_found;
use crate::diagnosis::yardstick::{Errors, squared_errors};
use crate::effects::Unknown;
use crate::prediction::Window;
use crate::prediction::accuracy::{ErrorOf, predict, root_mean_square, tallies};
use crate::prediction::windowed_log::Driven;

/// Share of the error that a finding must take away.
const SHARE_MIN: f64 = 0.02;
/// Standard deviations from which on a number is not zero.
pub(super) const SIGMAS: f64 = 2.0;
/// Folds, and windows in a block of one: neighbours in time have errors in common.
const FOLDS: usize = 5;
const BLOCK: usize = 4;

/// A model fitted to all windows but those of the report, and what it would miss of each had that not been among them.
struct Judged<'e> {
    fit: Fit<'e>,
    /// Normal equations of its numbers, window by window.
    normals: Vec<Normal>,
    errors: Vec<Errors>,
}

/// Takes out of a base model what makes its predictions worse beyond chance, one by one and all of an axis at once: a
/// trim with the brake that goes with it may do harm together that neither does alone. That commands act late is no
/// question: lag and delay are hard to tell apart, and one without the other takes up more than its own. Causes that
/// are known, the last of the terms, stay.
pub(super) fn useful<'e>(search: &Search<'e>, base: Fit<'e>, causes: usize) -> Fit<'e> {
    let mut with = Judged::of(search, base);
    loop {
        let may_go = |index: &usize| !with.fit.terms[*index].effect.is_late();
        let places: Vec<usize> = (search.gains.len()..with.fit.terms.len() - causes).filter(may_go).collect();
        let expected = sets(&with.fit, &places).into_iter().map(|set| {
            let other = with.expected_without(search, &set);
            (set, other)
        });
        let better = expected.filter(|(_, other)| is_surely_better(&with.errors, &other.errors));
        let mut better: Vec<(Vec<usize>, f64)> =
            better.map(|(set, other)| (set, change(&with.errors, &other.errors))).collect();
        better.sort_by(|a, b| a.1.total_cmp(&b.1));
        // what is expected to be better is fitted, the best first
        let mut fitted = better.into_iter().map(|(set, _)| with.without(search, &set));
        match fitted.find(|other| is_surely_better(&with.errors, &other.errors)) {
            Some(best) => with = best,
            None => return with.fit,
        }
    }
}

/// Each of some places of a model by itself, and those of each axis together.
fn sets(fit: &Fit<'_>, places: &[usize]) -> Vec<Vec<usize>> {
    let of_axis = |axis: Axis| -> Vec<usize> {
        places.iter().copied().filter(|index| fit.terms[*index].effect.axis() == Some(axis)).collect()
    };
    let together = Axis::ALL.map(of_axis).into_iter().filter(|set| set.len() > 1);
    places.iter().map(|index| vec![*index]).chain(together).collect()
}

/// Takes out, one by one, the findings that do not help what is reported.
pub(super) fn judged<'e>(search: &Search<'e>, base: Fit<'e>, chosen: Fit<'e>) -> Fit<'e> {
    if chosen.terms.len() == search.always.len() {
        return chosen;
    }
    let (base, mut with) = (Judged::of(search, base), Judged::of(search, chosen));
    loop {
        let loses = |one: &usize| change(&base.errors[*one..=*one], &with.errors[*one..=*one]) > SHARE_MIN;
        let worse: Vec<usize> = surely_better_ones(&with.errors, &base.errors).filter(loses).collect();
        let mut removable = Vec::new();
        for index in search.always.len()..with.fit.terms.len() {
            let without = with.without(search, &[index]);
            let gains = change(&without.errors, &with.errors);
            let mends = worse.iter().map(|i| -change(&with.errors[*i..=*i], &without.errors[*i..=*i]));
            let mends = mends.fold(0.0, f64::max);
            if !pays(search, &with.fit.terms[index], &without, &with) || mends > 0.0 {
                removable.push((gains + mends, without));
            }
        }
        match removable.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, without)) => with = without,
            None => return with.fit,
        }
    }
}

/// The first of some larger models that pays for what it has beyond a smaller one.
pub(super) fn first_that_helps<'e>(search: &Search<'e>, smaller: &Fit<'e>, larger: &[&Fit<'e>]) -> Option<usize> {
    if larger.is_empty() {
        return None;
    }
    let without = Judged::of(search, smaller.clone());
    let pays = |larger: &&Fit<'e>| {
        larger.terms.last().is_some_and(|added| pays(search, added, &without, &Judged::of(search, (*larger).clone())))
    };
    larger.iter().position(pays)
}

/// Places of those of the base model's terms that are findings too: they pay as a finding must.
pub(super) fn unusual_terms<'e>(
    search: &Search<'e>,
    chosen: &Fit<'e>,
    may_be: &dyn Fn(&Term<'e>) -> bool,
) -> Vec<usize> {
    let with = Judged::of(search, chosen.clone());
    // where the fit of the rest has other optima, a term of no size may seem to pay
    let places = (search.gains.len()..search.always.len()).filter(|index| may_be(&chosen.terms[*index]));
    let large = places.filter(|index| deviations(chosen, *index) > SIGMAS).collect();
    let is_paid = |index: usize, without: &Judged<'e>| pays(search, &chosen.terms[index], without, &with);
    // a fit of the rest leaves less than is expected of it
    let may_pay = may_be_found(search, chosen, large)
        .into_iter()
        .filter(|index| is_paid(*index, &with.expected_without(search, &[*index])));
    may_pay.filter(|index| is_paid(*index, &with.without(search, &[*index]))).collect()
}

/// The finding whose numbers are no further from what changes nothing than chance explains, the most doubtful of
/// several: a spring beside a gravity that takes as much away may pay on the windows at hand, and says nothing of the
/// vehicle.
pub(super) fn doubtful(fit: &Fit<'_>, findings: std::ops::Range<usize>) -> Option<usize> {
    let doubted = findings.map(|index| (index, deviations(fit, index))).filter(|(_, deviations)| *deviations <= SIGMAS);
    doubted.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

/// By how many of its standard deviations the surest of a term's sizes differs from what changes nothing, or all of
/// them together: of a wave sine and cosine may each be less sure than its amplitude.
fn deviations(fit: &Fit<'_>, index: usize) -> f64 {
    let (term, first) = (&fit.terms[index], fit.first_place_of(index));
    let (mut together, mut square, mut surest) = (vec![0.0; fit.size()], 0.0, 0.0_f64);
    for (place, unknown) in Unknown::sizes(term.effect.unknowns()) {
        let size = term.values[place] - unknown.nominal;
        together[first + place] = size;
        square += size * size;
        surest = surest.max(fit.deviations_from(unknown.nominal, index, place).abs());
    }
    surest.max(square / fit.variance_along(&together).max(f64::MIN_POSITIVE).sqrt())
}

/// Does a model pay for a term that another lacks: a share of the error, beyond chance? What puts one channel right is
/// not to be lost in the chance of all the others.
fn pays(search: &Search<'_>, term: &Term<'_>, without: &Judged<'_>, with: &Judged<'_>) -> bool {
    let (without, with) = (&without.errors, &with.errors);
    change(without, with) < -SHARE_MIN
        && (is_surely_better(without, with) || surely_better_ones(without, with).next().is_some())
        && dry_friction::axis_of(term.effect).is_none_or(|axis| brakes_what_turns(search, axis, without, with))
}

/// Is a rate predicted better beyond chance where it is large? At rest the commands hold against gusts: what seems to
/// keep the vehicle where it is, open loop, may be the gust that they answer, and over half a second a vehicle that
/// rests in gusts seems to be held by dry friction (on a hundred vehicles that imitate reality all that was false was
/// that). While it turns, and over a tenth of a second, a friction that is not there makes the prediction worse.
fn brakes_what_turns(search: &Search<'_>, axis: Axis, without: &[Errors], with: &[Errors]) -> bool {
    let Some((rate, turning)) = dry_friction::turning(search, axis) else { return true };
    let of = |errors: &[Errors]| vec![turning.iter().map(|window| errors[rate][*window]).collect()];
    is_surely_better(&of(without), &of(with))
}

/// Mean relative change of all errors from one model to another, as a logarithm.
fn change(from: &[Errors], to: &[Errors]) -> f64 {
    let windows = from.first().map_or(0, Vec::len);
    change_over(&(0..windows).collect::<Vec<_>>(), from, to)
}

fn change_over(windows: &[usize], from: &[Errors], to: &[Errors]) -> f64 {
    let sum = |errors: &Errors| windows.iter().map(|window| errors[*window]).sum::<f64>().max(f64::MIN_POSITIVE);
    let changes = from.iter().zip(to).map(|(from, to)| 0.5 * libm::log(sum(to) / sum(from)));
    changes.sum::<f64>() / from.len().max(1) as f64
}

/// In which channels, at which horizon, is the second better, beyond the chance that there is with as many of them?
fn surely_better_ones(from: &[Errors], to: &[Errors]) -> impl Iterator<Item = usize> {
    let windows = from.first().map_or(0, Vec::len);
    (0..from.len()).filter(move |&one| {
        let (from_one, to_one) = (&from[one..=one], &to[one..=one]);
        change(from_one, to_one) < 0.0
            && interval_of_one(windows, from.len(), |drawn| change_over(drawn, from_one, to_one))
                .is_some_and(|[_, most]| most < 0.0)
    })
}

/// Is the second better beyond chance? With few windows chance is all there is.
fn is_surely_better(from: &[Errors], to: &[Errors]) -> bool {
    let windows = from.first().map_or(0, Vec::len);
    change(from, to) < 0.0
        && interval(windows, |drawn| change_over(drawn, from, to)).is_some_and(|[_, most]| most < 0.0)
}

impl<'e> Judged<'e> {
    fn of(search: &Search<'e>, fit: Fit<'e>) -> Judged<'e> {
        let shooting = search.shooting;
        let driven = shooting.log.drive(model_of(search.nominal, &fit.terms));
        let shifted = shifted_models(shooting, search.nominal, &fit.terms, 0);
        let windows = &search.yardstick(&driven).windows;
        let normals = shooting.linearise(&driven, &shifted, windows, &fit.starts, None).normals();
        Judged::by(search, fit, normals)
    }

    /// By what its windows' normal equations say.
    fn by(search: &Search<'e>, fit: Fit<'e>, normals: Vec<Normal>) -> Judged<'e> {
        let log = &search.shooting.log;
        let drive = |terms: &[Term<'e>]| log.drive(model_of(search.nominal, terms));
        let yardstick = search.yardstick(&drive(&fit.terms));
        let folds = folds(&fit, &yardstick.windows, &normals);
        let driven: Vec<Driven> = folds.iter().map(|terms| drive(terms)).collect();
        let errors = yardstick.errors(log, |window| &driven[fold_of(window)]);
        Judged { fit, normals, errors }
    }

    /// The model without some of its terms, all else where the normal equations expect it then: much less work than a
    /// fit, and nearly as good where a model is nearly linear in its numbers.
    fn expected_without(&self, search: &Search<'e>, set: &[usize]) -> Judged<'e> {
        let (step, places) = (self.fit.step_without(set), self.fit.places_of(set));
        let normals = self.normals.iter().map(|normal| normal.after(&step.by, &places)).collect();
        Judged::by(search, self.fit.expected_without(set, &step), normals)
    }

    /// The model without some of its terms, all else fitted anew.
    fn without(&self, search: &Search<'e>, set: &[usize]) -> Judged<'e> {
        let terms = self.fit.terms.iter().enumerate().filter(|(index, _)| !set.contains(index));
        let terms = terms.map(|(_, term)| term.clone()).collect();
        Judged::of(search, search.refitted(terms, &self.fit.starts))
    }
}

fn fold_of(window: usize) -> usize {
    window / BLOCK % FOLDS
}

/// The terms as the windows outside of each fold have them.
fn folds<'e>(fit: &Fit<'e>, windows: &[usize], normals: &[Normal]) -> Vec<Vec<Term<'e>>> {
    let of_fold = |fold: usize| {
        let outside = windows.iter().zip(normals).filter(|(index, _)| fold_of(**index) != fold);
        let normal = with_priors(Normal::sum(outside.map(|(_, normal)| normal)), &fit.terms);
        let step = BoundedStep::new(&normal, &fit.terms, 1e-6);
        step.map_or_else(|| fit.terms.clone(), |of_fold| of_fold.step.applied(&fit.terms))
    };
    (0..FOLDS).map(of_fold).collect()
}

/// Mean squares of an exact model's errors over the windows of the report, channel by channel.
pub(super) fn floors(search: &Search<'_>, terms: &[Term<'_>]) -> Vec<f64> {
    let log = &search.shooting.log;
    let driven = log.drive(model_of(search.nominal, terms));
    let predicted = tallies(&predict(log, &driven, &search.windows(&search.report)));
    let of = |channel| root_mean_square(&predicted, ErrorOf::Channel(channel)).map_or(1.0, |(_, floor)| floor * floor);
    log.compared().map(|(channel, _)| of(channel).max(f64::MIN_POSITIVE)).collect()
}

/// Squared errors over the windows of the report, window by window, each channel in units of some mean square. What is
/// compared needs the same ones: how much of the noise a prediction takes up depends on its model.
pub(super) fn losses(search: &Search<'_>, terms: &[Term<'_>], floors: &[f64]) -> Vec<f64> {
    let (log, windows) = (&search.shooting.log, search.windows(&search.report));
    let driven = log.drive(model_of(search.nominal, terms));
    let of_window = |window: &Window| {
        let sight = log.start_sight(&driven, window);
        squared_errors(log, &driven, window, sight.as_ref())
            .iter()
            .zip(floors)
            .map(|(square, floor)| square / floor)
            .sum()
    };
    windows.par_iter().map(of_window).collect()
}
