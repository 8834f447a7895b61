//! Which causes explain how a flight departs from normal ones: what departs beyond chance, every cause that was tried
//! counted as a look, and among causes the likeliest. The spread between normal flights is known from a few flights
//! only, and so departures follow Student's distribution (of several numbers), not a normal one.

use super::causes::{Cause, Departures, Explanation};
use super::normal::Expected;
use crate::diagnosis::known::Known;
use crate::statistics::f_exceeded;

/// The chance of reporting anything in a normal flight.
const FALSE_ALARM: f64 = 0.05;
/// The chance of what the findings leave, below which something is missing from them.
const REST: f64 = 0.01;
/// Natural logarithm of the likelihood within which two causes cannot be separated (as in `search`).
const SEPARABLE: f64 = 3.0;
/// The same of causes that do not differ.
const ALIKE: f64 = 1e-6;
/// A cause that a normal flight shows more often than this is not worth a word.
const NEAREST: f64 = 0.5;
/// Standard deviations from which on a size is something.
const SIGMAS: f64 = 2.0;
/// Causes in one answer.
const CAUSES_MAX: usize = 3;

/// A cause that the flight shows, or the nearest one.
pub(super) struct Chosen {
    pub(super) best: Explanation,
    /// The chance of as much in a normal flight, all looks counted.
    pub(super) chance: f64,
    /// What explains it about as well, best first.
    pub(super) others: Vec<Explanation>,
    /// Share of all squared departures that it explains.
    pub(super) share: f64,
}

/// What was chosen.
pub(super) struct Choice {
    pub(super) found: Vec<Chosen>,
    /// The likeliest cause where none is beyond chance, and that one is not usual either.
    pub(super) nearest: Option<Chosen>,
    /// Causes that were tried, those that differ in no number as one.
    pub(super) looks: usize,
    /// The chance of departures as large as these in a normal flight, and of what the findings leave of them.
    pub(super) chance: f64,
    pub(super) chance_of_rest: f64,
}

impl Choice {
    /// Is more left than a normal flight's?
    pub(super) fn leaves_something(&self) -> bool {
        self.chance_of_rest < REST
    }
}

/// Chooses causes one by one, the likeliest first.
pub(super) fn choose(departures: &Departures<'_>, known: &Known) -> Choice {
    let causes: Vec<Cause> =
        departures.causes().into_iter().filter(|cause| !known.excludes(cause.held_as(), cause.axis())).collect();
    let all = departures.squares();
    let looks = looks(departures, &causes);
    let mut explained = vec![0.0; departures.by.len()];
    let mut found: Vec<Chosen> = Vec::new();
    let mut nearest = None;
    while found.len() < CAUSES_MAX {
        let rest = departures.without(&explained);
        let is_new = |cause: &&Cause| found.iter().all(|chosen| chosen.best.cause != **cause);
        let tried: Vec<Explanation> =
            causes.iter().filter(is_new).filter_map(|cause| rest.explained_by(*cause)).filter(has_size).collect();
        let Some(chosen) = likeliest(&rest, tried, looks, all) else { break };
        if chosen.chance >= FALSE_ALARM {
            nearest = (found.is_empty() && chosen.chance < NEAREST).then_some(chosen);
            break;
        }
        explained.iter_mut().zip(&chosen.best.predicted).for_each(|(sum, own)| *sum += own);
        found.push(chosen);
    }
    let chance = chance_of(departures, all);
    let chance_of_rest = chance_of(departures, departures.without(&explained).squares());
    Choice { found, nearest, looks, chance, chance_of_rest }
}

/// How many looks at a flight some causes are: two that explain the same of every number, as a delay and a lag do, are
/// one, and two causes at once are none.
fn looks(departures: &Departures<'_>, causes: &[Cause]) -> usize {
    let single = causes.iter().filter(|cause| !cause.is_two());
    let all: Vec<Explanation> = single.filter_map(|cause| departures.explained_by(*cause)).collect();
    let is_alike = |one: &Explanation, other: &Explanation| {
        let numbers = one.predicted.iter().zip(&other.predicted).zip(&departures.normal.numbers);
        let is_same = |((one, other), number): ((&f64, &f64), &Expected)| (one - other).abs() <= ALIKE * number.std;
        one.values.len() == other.values.len() && numbers.into_iter().all(is_same)
    };
    (0..all.len()).filter(|place| all[..*place].iter().all(|other| !is_alike(other, &all[*place]))).count().max(1)
}

/// Is one of its sizes known to be something? One that is not explains a departure that any size does. Of two causes at
/// once both must be, or it is one of them.
fn has_size(one: &Explanation) -> bool {
    let mut sizes = one.values.iter().zip(&one.std).map(|(value, std)| value.abs() > SIGMAS * std);
    if one.cause.is_two() { sizes.all(|is_known| is_known) } else { sizes.any(|is_known| is_known) }
}

fn chance_of(departures: &Departures<'_>, squares: f64) -> f64 {
    let count = departures.by.len().max(1) as f64;
    f_exceeded(squares / count, count, departures.normal.freedom)
}

/// The likeliest cause of those beyond chance, or of all where none is; and what is about as likely.
fn likeliest(rest: &Departures<'_>, tried: Vec<Explanation>, looks: usize, all: f64) -> Option<Chosen> {
    let freedom = rest.normal.freedom;
    let chance = |one: &Explanation| {
        let size = one.values.len() as f64;
        (looks as f64 * f_exceeded(one.explained / size, size, freedom)).min(1.0)
    };
    let likelihood = |one: &Explanation| {
        let left = (rest.squares() - one.explained).max(0.0);
        -0.5 * (freedom + rest.by.len() as f64) * libm::log1p(left / freedom)
    };
    // a further number must be worth its while (Akaike)
    let worth = |one: &Explanation| likelihood(one) - one.values.len() as f64;
    let is_beyond = |one: &Explanation| chance(one) < FALSE_ALARM;
    // two causes at once may be what a departure comes from, but one that no single cause shows is chance
    let any = tried.iter().any(|one| !one.cause.is_two() && is_beyond(one));
    let candidates = tried.iter().filter(|one| if any { is_beyond(one) } else { !one.cause.is_two() });
    // rounding does not decide between two that change all numbers alike
    let best = candidates.reduce(|best, one| if worth(one) >= worth(best) - ALIKE { one } else { best })?.clone();
    let limit = likelihood(&best) - SEPARABLE;
    let mut others: Vec<Explanation> =
        tried.into_iter().filter(|one| one.cause != best.cause && likelihood(one) > limit).collect();
    others.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    // one motor once, as what it is likeliest
    let mut motors: Vec<usize> = best.cause.motor().into_iter().collect();
    others.retain(|one| {
        one.cause.motor().is_none_or(|motor| {
            let is_new = !motors.contains(&motor);
            motors.push(motor);
            is_new
        })
    });
    Some(Chosen { chance: chance(&best), share: best.explained / all.max(f64::MIN_POSITIVE), others, best })
}
