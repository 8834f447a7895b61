//! Dry friction is hard to tell: a viscous one takes its place over the rates that a log has most of, and a gust that
//! the commands hold against looks like it where the vehicle rests.

use super::fitted::Fitted;
use super::search::Search;
use crate::axis::Axis;
use crate::diagnosis::block_bootstrap::WINDOWS_MIN;
use crate::diagnosis::fitting::fit::Term;
use crate::prediction::{Channel, Window};

/// Share of a viscous friction that a fit of a dry one begins with.
const SHARE: f64 = 0.3;

/// The axis that an effect brakes the same at any rate; none of other effects.
pub(super) fn axis_of(effect: &Fitted) -> Option<Axis> {
    effect.axis().filter(|_| effect.name() == "coulomb_friction")
}

/// A model with dry friction in the place of a part of its viscous one, so much that it takes as much energy from what
/// was measured; none of other effects, or where nothing viscous is. From nothing on, dry friction explains little to
/// first order: where the viscous one does its work already it has to go at the same time, and a vehicle at rest is
/// held by as much as its gusts have, or not at all.
pub(super) fn for_viscous<'e>(search: &Search<'e>, terms: &[Term<'e>], effect: &'e Fitted) -> Option<Vec<Term<'e>>> {
    let axis = axis_of(effect)?;
    let measured = search.shooting.log.measured(Channel::Rate(axis))?;
    let mut terms = terms.to_vec();
    let is_viscous =
        |term: &&mut Term<'e>| term.effect.name() == "viscous_friction" && term.effect.axis() == Some(axis);
    let coefficient = terms.iter_mut().find(is_viscous)?.values.first_mut()?;
    let windows = &search.shooting.log.windows;
    let rates = || windows.iter().flat_map(|window| &measured[window.start..window.end]);
    let (squares, sizes): (f64, f64) = (rates().map(|rate| rate * rate).sum(), rates().map(|rate| rate.abs()).sum());
    let dry = SHARE * *coefficient * squares / sizes.max(f64::MIN_POSITIVE);
    *coefficient *= 1.0 - SHARE;
    (dry > 0.0).then(|| terms.push(Term { effect, values: vec![dry] }))?;
    Some(terms)
}

/// The place of an axis' rate among the compared channels, and the half of the windows outside of the report, by their
/// places among these, in which it is largest; none where it is not compared.
pub(super) fn turning(search: &Search<'_>, axis: Axis) -> Option<(usize, Vec<usize>)> {
    let log = &search.shooting.log;
    let rate = Channel::Rate(axis);
    let (place, measured) = log.compared().position(|(channel, _)| channel == rate).zip(log.measured(rate))?;
    let square = |index: &usize| {
        let Window { start, end, .. } = log.windows[*index];
        measured[start..end].iter().map(|rate| rate * rate).sum::<f64>() / (end - start).max(1) as f64
    };
    let squares: Vec<f64> = search.unreported.iter().map(square).collect();
    let mut turning: Vec<usize> = (0..squares.len()).collect();
    turning.sort_by(|a, b| squares[*b].total_cmp(&squares[*a]));
    turning.truncate(squares.len().div_ceil(2).max(WINDOWS_MIN));
    turning.sort_unstable();
    Some((place, turning))
}
