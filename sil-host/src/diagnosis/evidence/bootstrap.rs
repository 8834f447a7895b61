//! How much of the error each finding takes away on the held-out windows, and how sure that is.

use serde::Serialize;

use crate::diagnosis::block_bootstrap::{interval, interval_and_chance};
use crate::diagnosis::found::Found;
use crate::diagnosis::judge;
use crate::diagnosis::search::Search;

/// Share of the error that a finding must take away, %.
const CONFIRMED_PCT: f64 = 2.0;
/// Share of the draws in which it may take none away. The judge was sure of it over three times as many windows; where
/// these few ask for the same, they refuse of what takes a third of the error away as much as they confirm.
const BY_CHANCE: f64 = 0.1;

/// Gains on held-out data, with intervals that hold 95 % of a block bootstrap.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// Fall of the held-out squared error, in units of the noise, from the nominal to the extended model, % of the
    /// nominal's.
    pub total_pct: f64,
    /// Its interval; none where the held-out windows are too few.
    pub total_interval_pct: Option<[f64; 2]>,
    /// Places of the findings in the model, most important first.
    #[serde(skip)]
    pub places: Vec<usize>,
    /// The findings' `gain_pct`, in their order.
    #[serde(skip)]
    pub findings_pct: Vec<f64>,
    /// Their intervals.
    pub findings_interval_pct: Vec<Option<[f64; 2]>>,
    /// In which share of the draws each takes nothing away; none where there are no intervals.
    #[serde(skip)]
    chances: Vec<Option<f64>>,
}

/// Gains of what a search found.
pub(in crate::diagnosis) fn gain<'e>(search: &Search<'e>, found: &Found<'e>) -> Gain {
    let refitted = [&found.refitted.nominal, &found.refitted.chosen];
    let floors = judge::floors(search, &refitted[1].terms);
    let [nominal, extended] = refitted.map(|fit| judge::losses(search, &fit.terms, &floors));
    let share = |of: &[usize], loss: &[f64], base: &[f64]| {
        let sum = |values: &[f64]| of.iter().map(|i| values[*i]).sum::<f64>();
        100.0 * (sum(loss) - sum(&extended)) / sum(base)
    };
    let all: Vec<usize> = (0..nominal.len()).collect();
    let found_places = search.always.len()..refitted[1].terms.len();
    let mut findings: Vec<_> = found_places
        .chain(found.unusual.iter().copied())
        .map(|index| {
            let mut terms = refitted[1].terms.clone();
            terms.remove(index);
            let without = search.left_without(found, terms);
            let drawn = interval_and_chance(all.len(), |drawn| share(drawn, &without, &without));
            (index, share(&all, &without, &without), drawn)
        })
        .collect();
    findings.sort_by(|a, b| b.1.total_cmp(&a.1));
    Gain {
        total_pct: share(&all, &nominal, &nominal),
        total_interval_pct: interval(all.len(), |drawn| share(drawn, &nominal, &nominal)),
        places: findings.iter().map(|finding| finding.0).collect(),
        findings_pct: findings.iter().map(|finding| finding.1).collect(),
        findings_interval_pct: findings.iter().map(|finding| finding.2.map(|(interval, _)| interval)).collect(),
        chances: findings.iter().map(|finding| finding.2.map(|(_, chance)| chance)).collect(),
    }
}

/// What the windows of the report confirm of what was found: that it makes nothing worse, and beside a base model that
/// it takes a share of the error away, beyond chance. They have no say in what is looked for; they may only object.
pub(in crate::diagnosis) fn confirmed<'e>(search: &Search<'e>, mut found: Found<'e>) -> Found<'e> {
    loop {
        let Gain { places, findings_pct, chances, .. } = gain(search, &found);
        let least_pct = if search.has_base() { CONFIRMED_PCT } else { 0.0 };
        let may_be_chance = |chance: &Option<f64>| search.has_base() && chance.is_some_and(|chance| chance > BY_CHANCE);
        let places = places.into_iter().zip(findings_pct).zip(chances);
        let not_confirmed = places.filter(|((_, pct), chance)| *pct < least_pct || may_be_chance(chance));
        let Some(((place, _), _)) = not_confirmed.min_by(|a, b| a.0.1.total_cmp(&b.0.1)) else { return found };
        let objected = found.refitted.chosen.terms[place].effect;
        let mut wanted = found.findings(search);
        wanted.retain(|term| !term.effect.is_the_same(objected));
        found = search.agreed(found, &wanted);
    }
}
