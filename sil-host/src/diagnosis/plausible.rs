//! What no vehicle can have is no finding: a number at the end of its range, where the fit wanted to go on; commands
//! clipped until nothing of them is left; a battery that gives more the emptier it is.

use crate::diagnosis::fitting::fit::{Nominal, Term, model_of};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::effects::Unknown;
use crate::prediction::model::Model;

/// Distance from a bound, as a share of the range, that is still at the bound.
const AT_BOUND: f64 = 1e-3;
/// Share of the commands' standard deviation that must be left of them.
const INPUT_MIN: f64 = 0.5;

/// Could the effect that was added last be a vehicle's?
pub(super) fn is_plausible(shooting: &Shooting<'_>, nominal: Nominal<'_>, terms: &[Term<'_>]) -> bool {
    let Some(Term { effect, values }) = terms.last() else { return true };
    let mut numbers = effect.unknowns().iter().zip(values);
    let is_inside = !numbers.any(|(unknown, value)| is_at_bound(unknown, *value));
    is_inside && leaves_input(shooting, nominal, terms) && is_drained(&model_of(nominal, terms))
}

/// Does the battery give less thrust with time, and with each volt that it has lost? By volts it may seem to give more
/// where what a motor does per command rises with its speed: whoever gives more throttle draws the voltage down.
fn is_drained(model: &Model) -> bool {
    let lift = &model.changes.chain.lift;
    lift.loss_per_volt >= 0.0 && lift.loss_per_s >= 0.0
}

/// Is one of a model's numbers at the end of its range?
pub(super) fn has_bound(terms: &[Term<'_>]) -> bool {
    let numbers = terms.iter().flat_map(|term| term.effect.unknowns().iter().zip(&term.values));
    numbers.into_iter().any(|(unknown, value)| is_at_bound(unknown, *value))
}

/// At the end of its range, and not because that end is where it changes nothing.
fn is_at_bound(unknown: &Unknown, value: f64) -> bool {
    let margin = AT_BOUND * (unknown.max - unknown.min);
    let is_void = (value - unknown.nominal).abs() <= margin;
    !is_void && (value - unknown.min < margin || unknown.max - value < margin)
}

/// Does enough of the commands arrive at the motors?
fn leaves_input(shooting: &Shooting<'_>, nominal: Nominal<'_>, terms: &[Term<'_>]) -> bool {
    let commands = &shooting.log.commands.value;
    // sum of squares about the motors' means
    let variation = |model: &Model| -> f64 {
        let arrived: Vec<[f64; 4]> =
            commands.iter().map(|row| model.drive.clipped(*row, &model.changes.chain.path)).collect();
        let of_motor = |motor: usize| {
            let mean = arrived.iter().map(|row| row[motor]).sum::<f64>() / arrived.len().max(1) as f64;
            arrived.iter().map(|row| (row[motor] - mean) * (row[motor] - mean)).sum::<f64>()
        };
        (0..4).map(of_motor).sum()
    };
    variation(&model_of(nominal, terms)) >= INPUT_MIN * INPUT_MIN * variation(&model_of(nominal, &[]))
}
