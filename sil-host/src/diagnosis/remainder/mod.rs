//! What the findings do not explain: residuals that are correlated from row to row (`structure`) or that depend on a
//! measured quantity (`signature`), or findings that all but cancel each other (`cancelling`).

pub(in crate::diagnosis) mod cancelling;
pub(in crate::diagnosis) mod signature;
pub(in crate::diagnosis) mod structure;

use super::Unexplained;
use super::fitting::fit::model_of;
use super::found::Found;
use super::search::{Candidate, Search};

/// What the findings of a search leave.
pub(super) fn unexplained(search: &Search<'_>, found: &Found<'_>) -> Unexplained {
    let shooting = search.shooting;
    let whole = search.fitted_to_all(&found.chosen);
    let driven = shooting.log.drive(model_of(search.nominal, &whole.fit.terms));
    let all: Vec<usize> = (0..shooting.log.windows.len()).collect();
    let whiteness = structure::whiteness(shooting, &driven, &all, &whole.fit.starts);
    let even = whiteness.iter().all(structure::Whiteness::is_white);
    let dependence = signature::strongest(search, &found.chosen, &whole.fit);
    let white = even && dependence.is_none();
    let expected = shooting.degrees_of_freedom(&search.choice);
    let beyond = |candidate: &Candidate<'_>| (candidate.choice - expected).max(0.0);
    let nominal = beyond(&found.nominal);
    let variance_pct = if nominal > 0.0 { 100.0 * (beyond(&found.chosen) / nominal).min(1.0) } else { 0.0 };
    let worst = whiteness.iter().max_by(|a, b| a.deviation.total_cmp(&b.deviation));
    let goes_on = worst.filter(|_| !even).map(|worst| {
        let (name, sigmas) = (worst.channel.name(), worst.deviation);
        let words = format!("the residual of {name} is correlated from row to row ({sigmas:.0} sigma)");
        let Some(axis) = worst.channel.turning_axis() else { return words };
        let frequency = signature::frequency(search, &whole.fit, axis).unwrap_or_default();
        format!("{}: {words}, {frequency}", axis.name())
    });
    let cancelling = || cancelling::cancelling(&whole.fit, search.always.len());
    let signature = dependence.or(goes_on).or_else(cancelling).unwrap_or_default();
    Unexplained { variance_pct, white, signature }
}
