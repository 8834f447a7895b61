//! What the findings do not explain: residuals that are correlated from row to row (`structure`) or that depend on a
//! measured quantity (`signature`), or findings that all but cancel each other (`cancelling`).

pub(in crate::diagnosis) mod cancelling;
pub(in crate::diagnosis) mod signature;
pub(in crate::diagnosis) mod structure;

use super::Unexplained;
use super::fitting::fit::model_of;
use super::fitting::shooting::Shooting;
use super::found::Found;
use super::search::Search;
use crate::prediction::accuracy::{ErrorOf, WindowTally, root_mean_square, worst_ratio};

/// What the findings of a search leave, and of the held-out errors of the nominal and the extended model.
pub(super) fn unexplained(
    search: &Search<'_>,
    found: &Found<'_>,
    nominal: &[WindowTally],
    extended: &[WindowTally],
) -> Unexplained {
    let shooting = search.shooting;
    let whole = search.fitted_to_all(&found.chosen);
    let driven = shooting.log.drive(model_of(search.nominal, &whole.fit.terms));
    let all = shooting.log.in_use();
    let whiteness = structure::whiteness(shooting, &driven, &all, &whole.fit.starts);
    let even = whiteness.iter().all(structure::Whiteness::is_white);
    let dependence = signature::strongest(search, &found.chosen, &whole.fit);
    let white = even && dependence.is_none();
    let worst = whiteness.iter().max_by(|a, b| a.deviation.total_cmp(&b.deviation));
    let goes_on = worst.filter(|_| !even).map(|worst| {
        let (name, sigmas) = (worst.channel.name(), worst.deviation);
        let words = format!("the residual of {name} is correlated from row to row ({sigmas:.0} sigma)");
        let Some(axis) = worst.channel.turning_axis() else { return words };
        let frequency = signature::frequency(search, &whole.fit, axis).map(|hz| format!(", {hz}")).unwrap_or_default();
        format!("{}: {words}{frequency}", axis.name())
    });
    let cancelled = cancelling::cancelling(&whole.fit, search.always.len());
    let cancelling = cancelled.is_some();
    let signature = dependence.or(goes_on).or(cancelled).unwrap_or_default();
    let (variance_pct, times_floor) = (left_pct(shooting, nominal, extended), worst_ratio(extended));
    Unexplained { variance_pct, times_floor, white, signature, cancelling }
}

/// What is left of the nominal model's squared error beyond the noise, each channel relative to the nominal error, %.
fn left_pct(shooting: &Shooting<'_>, nominal: &[WindowTally], extended: &[WindowTally]) -> f64 {
    let (mut before, mut after) = (0.0, 0.0);
    for (channel, _) in shooting.log.compared() {
        let of = |windows| root_mean_square(windows, ErrorOf::Channel(channel));
        let (Some((nominal, _)), Some((extended, floor))) = (of(nominal), of(extended)) else { continue };
        let beyond = |error: f64| (error * error - floor * floor).max(0.0) / (nominal * nominal).max(f64::MIN_POSITIVE);
        before += beyond(nominal);
        after += beyond(extended);
    }
    if before > 0.0 { 100.0 * (after / before).min(1.0) } else { 0.0 }
}
