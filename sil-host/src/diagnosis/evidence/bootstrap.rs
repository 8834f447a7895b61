//! How much of the error each finding takes away on the held-out windows, and how sure that is.

use serde::Serialize;

use crate::diagnosis::block_bootstrap::interval;
use crate::diagnosis::found::Found;
use crate::diagnosis::judge;
use crate::diagnosis::search::Search;

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
}

/// Gains of what a search found.
pub(in crate::diagnosis) fn gain<'e>(search: &Search<'e>, found: &Found<'e>) -> Gain {
    let refitted = [&found.refitted.nominal, &found.refitted.chosen];
    let [nominal, extended] = refitted.map(|fit| judge::losses(search, &fit.terms));
    let share = |of: &[usize], loss: &[f64], base: &[f64]| {
        let sum = |values: &[f64]| of.iter().map(|i| values[*i]).sum::<f64>();
        100.0 * (sum(loss) - sum(&extended)) / sum(base)
    };
    let all: Vec<usize> = (0..nominal.len()).collect();
    let excess: Vec<f64> = nominal.iter().zip(&extended).map(|(nominal, extended)| nominal - extended).collect();
    let found_places = search.always.len()..refitted[1].terms.len();
    let mut findings: Vec<(usize, f64, Option<[f64; 2]>)> = found_places
        .chain(found.unusual.iter().copied())
        .map(|index| {
            let mut terms = refitted[1].terms.clone();
            terms.remove(index);
            let without = search.left_without(found, terms);
            let interval = interval(all.len(), |drawn| share(drawn, &without, &excess));
            (index, share(&all, &without, &excess), interval)
        })
        .collect();
    findings.sort_by(|a, b| b.1.total_cmp(&a.1));
    Gain {
        total_pct: share(&all, &nominal, &nominal),
        total_interval_pct: interval(all.len(), |drawn| share(drawn, &nominal, &nominal)),
        places: findings.iter().map(|finding| finding.0).collect(),
        findings_pct: findings.iter().map(|finding| finding.1).collect(),
        findings_interval_pct: findings.iter().map(|finding| finding.2).collect(),
    }
}
