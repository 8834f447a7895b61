//! How late commands act. Motors' lag and the delay before them look alike, so that a log shows their sum far better
//! than either, and neither is below 0: no more than the sum is left to each. Where a fit has no lag at all it knows no
//! more than that, however sure of it: something that no model has (a moment that runs ahead of the commands) has eaten
//! the lag that all motors have, and the delay beside it is motors' too.

use std::collections::BTreeMap;

use super::base::acts_at_once;
use super::estimate::Estimate;
use super::fitted::Fitted;
use super::search::Search;
use crate::diagnosis::fitting::fit::{Fit, Term};
use crate::effects::Unknown;
use crate::prediction::force_track::Commands;
use crate::prediction::lost_commands::{lateness_of_held_s, usual_step_s};

/// Lag and delay together, s; none where the fit has not both.
pub(super) fn together_s(search: &Search<'_>, fit: &Fit<'_>) -> Option<Estimate> {
    let has_both = fit.terms.iter().filter(|term| term.effect.is_late()).count() == 2;
    let summed = summed_s(fit).filter(|_| has_both)?;
    Some(Estimate { std: libm::hypot(summed.std, unknown_std_s(search)), ..summed })
}

/// The sum of what a fit has of them, s.
pub(super) fn summed_s(fit: &Fit<'_>) -> Option<Estimate> {
    let (mut slope, mut value, mut range) = (Vec::new(), 0.0, 0.0);
    for term in &fit.terms {
        let is_late = term.effect.is_late();
        range += if is_late { term.effect.unknowns().iter().map(Unknown::range).sum::<f64>() } else { 0.0 };
        slope.extend(term.values.iter().map(|_| if is_late { 1.0 } else { 0.0 }));
        value += if is_late { term.values.iter().sum() } else { 0.0 };
    }
    let variance = fit.variance_along(&slope);
    (slope.contains(&1.0) && variance.is_finite()).then(|| Estimate { value, std: variance.max(0.0).sqrt().min(range) })
}

/// Do these terms have a bench without motors? Beside a model's own motors a lag may be none; in the air a delay is
/// told only where it is longer than any (`usual`).
pub(super) fn has_no_motors(search: &Search<'_>, terms: &[Term<'_>]) -> bool {
    let may_have_none = search.has_own_lag() || search.shooting.log.is_of_unknown_flyer();
    search.has_base() && !may_have_none && acts_at_once(terms)
}

/// Counts in the interval of a lag or a delay what no fit knows ([`of_rows_std_s`]), and that neither is more than both
/// together.
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
        delay.std = libm::hypot(delay.std, unknown_std_s(search));
    }
    if let Some(together) = together_s(search, fit) {
        let most_s = together.value + together.std;
        let is_open = has_no_motors(search, &fit.terms);
        parameters.values_mut().for_each(|own| own.std = if is_open { most_s } else { own.std.min(most_s) });
    }
}

fn unknown_std_s(search: &Search<'_>) -> f64 {
    if search.has_base() { of_rows_std_s(&search.shooting.log.commands) } else { 0.0 }
}

/// Standard deviation of what rows leave open of a real log's lateness, s. First, whether commands acted from row to
/// row or between rows too: beside a base model lag and delay make up for either, and the likelihood decides nothing.
/// Second, when within its row each column's value was taken: a logger writes the newest one that it has of command and
/// of rate, each of them up to a row old, and loggers have been seen to slip by a row in the middle of a flight.
pub(super) fn of_rows_std_s(commands: &Commands) -> f64 {
    libm::hypot(held_std_s(commands), usual_step_s(commands) / 6f64.sqrt())
}

/// Standard deviation of what held commands may be late by, s: uniform, as much too late as too early.
pub(super) fn held_std_s(commands: &Commands) -> f64 {
    lateness_of_held_s(commands) / 3f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::simulated_bench::Bench;
    use crate::diagnosis::{Diagnosis, Subject, diagnose};
    use crate::log::Log;
    use crate::sensors::random::RandomStream;

    const LATE_S: f64 = 0.03;

    /// 40 s of a bench in gusts, whose lag and delay are 30 ms together.
    fn bench(lag_s: f64) -> Log {
        let random = RandomStream::new(4, "late");
        Bench { rows: 8_000, lag_s, delay_s: LATE_S - lag_s, gusts_rad_s2: 20.0 }.log(random)
    }

    fn number(answer: &Diagnosis, effect: &str) -> Estimate {
        *answer.base.iter().find(|term| term.effect == effect).unwrap().parameters.values().next().unwrap()
    }

    #[test]
    fn lag_and_delay_are_told_apart_unless_no_motor_is_as_quick_as_that_lag() {
        for lag_s in [0.02, 0.0] {
            let answer = diagnose(&bench(lag_s), &Subject::Axes).unwrap();
            let [lag, delay] = ["motor_lag", "actuation_delay"].map(|effect| number(&answer, effect));
            let together = answer.lateness_s.unwrap();
            println!("{lag:?} {delay:?} {together:?} {:?}", answer.findings);
            assert!(
                (together.value - LATE_S).abs() < 3.0 * together.std && together.std < 0.1 * LATE_S,
                "{together:?}"
            );
            let is_late = |effect: &str| ["motor_lag", "actuation_delay"].contains(&effect);
            let is_told = answer.findings.iter().any(|finding| is_late(finding.effect));
            if lag_s > 0.0 {
                assert!((lag.value - lag_s).abs() < 3.0 * lag.std && lag.std < 0.3 * lag_s && is_told, "{lag:?}");
            } else {
                assert!(lag.std > LATE_S && delay.std > LATE_S && !is_told, "{lag:?} {delay:?}");
            }
        }
    }

    /// Rows of 10 ms: held ones come 3.75 ms later than those of a usual controller, to either side; and two columns
    /// that are each up to a row old differ by less than a row, most likely by nothing: a triangle.
    #[test]
    fn rows_leave_open_how_old_their_commands_and_rates_are() {
        let commands =
            Commands { time_s: (0..100).map(|row| 0.01 * f64::from(row)).collect(), value: vec![[0.0; 4]; 100] };
        let expected_s = f64::sqrt(0.00375 * 0.00375 / 3.0 + 0.01 * 0.01 / 6.0);
        assert!((of_rows_std_s(&commands) - expected_s).abs() < 1e-9);
        let single = Commands { time_s: vec![0.0], value: vec![[0.0; 4]] };
        assert_eq!(of_rows_std_s(&single), 0.0);
    }
}
