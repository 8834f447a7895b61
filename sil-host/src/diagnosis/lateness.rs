//! How late commands act. Motors' lag and the delay before them look alike, so that a log shows their sum far better
//! than either, and neither is below 0: no more than the sum is left to each.

use std::collections::BTreeMap;

use super::estimate::Estimate;
use super::fitted::Fitted;
use super::search::Search;
use crate::diagnosis::fitting::fit::Fit;
use crate::prediction::force_track::Commands;
use crate::prediction::lost_commands::lateness_of_held_s;

/// Lag and delay together, s; none where the fit has not both.
pub(super) fn together_s(search: &Search<'_>, fit: &Fit<'_>) -> Option<Estimate> {
    let has_both = fit.terms.iter().filter(|term| term.effect.is_late()).count() == 2;
    let summed = summed_s(fit).filter(|_| has_both)?;
    Some(Estimate { std: libm::hypot(summed.std, held_s(search)), ..summed })
}

/// The sum of what a fit has of them, s.
pub(super) fn summed_s(fit: &Fit<'_>) -> Option<Estimate> {
    let size = fit.size();
    let (mut places, mut place, mut value) = (Vec::new(), 0, 0.0);
    for term in &fit.terms {
        if term.effect.is_late() {
            places.push(place);
            value += term.values.iter().sum::<f64>();
        }
        place += term.values.len();
    }
    let pairs = places.iter().flat_map(|i| places.iter().map(move |j| fit.scattered_covariance[i * size + j]));
    let variance: f64 = pairs.sum();
    (!places.is_empty() && variance.is_finite()).then(|| Estimate { value, std: variance.max(0.0).sqrt() })
}

/// Counts in the interval of a lag or a delay what no fit knows: whether commands acted from row to row or between rows
/// too (beside a base model lag and delay make up for either, and the likelihood decides nothing), and that neither is
/// more than both together.
pub(super) fn count_lateness(
    search: &Search<'_>,
    fit: &Fit<'_>,
    effect: &Fitted,
    parameters: &mut BTreeMap<&'static str, Estimate>,
) {
    if !effect.is_late() {
        return;
    }
    if let Some(delay) = parameters.get_mut("delay_s") {
        delay.std = libm::hypot(delay.std, held_s(search));
    }
    if let Some(together) = together_s(search, fit) {
        parameters.values_mut().for_each(|own| own.std = own.std.min(together.value + together.std));
    }
}

fn held_s(search: &Search<'_>) -> f64 {
    if search.has_base() { held_std_s(&search.shooting.log.commands) } else { 0.0 }
}

/// Standard deviation of what held commands may be late by, s: uniform, as much too late as too early.
pub(super) fn held_std_s(commands: &Commands) -> f64 {
    lateness_of_held_s(commands) / 3f64.sqrt()
}
