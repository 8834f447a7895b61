//! What a reader of the numbers must know before he uses them, a sentence each.

use super::horizons::Horizon;
use crate::diagnosis::Holding;
use crate::diagnosis::base::BaseTerm;
use crate::prediction::WINDOW_S;

/// Share by which a base model must miss a channel by more than the nominal one for that to be said.
const HARM_FROM: f64 = 0.1;
/// So many standard deviations below zero a gain is that of an axis which answers the wrong way round: one in a
/// thousand by chance.
const REVERSED_FROM: f64 = 3.0;

/// Of a base model's numbers, of those that are denied, in words, and of what they predict.
pub(in crate::diagnosis) fn warnings(
    base: &[BaseTerm],
    denied: &[String],
    holding: &[Holding],
    horizons: &[Horizon],
) -> Vec<String> {
    let harm = if holding.is_empty() { harm(base, horizons) } else { holds(holding) };
    base.iter().filter_map(reversed).chain(held(denied)).chain(harm).collect()
}

/// What commands hold against.
fn holds(holding: &[Holding]) -> Option<String> {
    let axes: Vec<&str> = holding.iter().map(|of| of.axis).collect();
    Some(format!(
        "Something that no log shows (wind, the propellers' own wake) moves this vehicle about {}, and the commands \
         hold against it. The base model is fitted with that in mind. Replayed open loop the commands answer what the \
         replay does not have: a model that knows what they do then misses more than one that does not, and how much \
         it misses is no test of it.",
        axes.join(", ")
    ))
}

/// Gains that are a controller's answer to disturbances.
fn held(denied: &[String]) -> Option<String> {
    (!denied.is_empty()).then(|| {
        format!(
            "What follows from what the controller was told shows another input gain than all motion together, {}: \
             most of the commands hold against something that no log shows (wind, the propellers' own wake), and \
             mislead a fit to all of them. The former is to be relied on, and nothing else that was \
             fitted here is.",
            denied.join("; ")
        )
    })
}

/// An axis that turns against its command.
fn reversed(term: &BaseTerm) -> Option<String> {
    let gain = term.parameters.values().next().filter(|_| term.effect == "input_gain")?;
    let axis = term.axis?;
    let likely = match axis {
        "yaw" => "motors that turn the other way round than assumed (propellers out), or a yaw of the other sign",
        _ => "motors in another order than assumed, or a rate of the other sign",
    };
    (gain.value < -REVERSED_FROM * gain.std).then(|| {
        format!(
            "The input gain of {axis} is negative ({gain}): the vehicle seems to turn against its command. No vehicle \
             that flies does; likely are {likely}, and what is said of {axis} is not to be relied on."
        )
    })
}

/// Where the base model predicts worse than the nominal one does, over the length that is compared.
fn harm(base: &[BaseTerm], horizons: &[Horizon]) -> Option<String> {
    let horizon = horizons.iter().find(|horizon| horizon.horizon_s == WINDOW_S && !base.is_empty())?;
    let worse = horizon.errors.iter().filter(|error| error.base > (1.0 + HARM_FROM) * error.nominal);
    let worse: Vec<String> = worse
        .map(|error| format!("{} {:.2} {} for {:.2}", error.quantity, error.base, error.unit, error.nominal))
        .collect();
    (!worse.is_empty()).then(|| {
        format!(
            "Over {WINDOW_S} s the base model is further off than the nominal one: {}. There something that it lacks \
             moved the vehicle more than what it has, and its numbers are not to be relied on.",
            worse.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::Estimate;

    #[test]
    fn an_axis_that_surely_turns_against_its_command_is_named() {
        let gain = |axis, value, std| BaseTerm {
            effect: "input_gain",
            axis: Some(axis),
            parameters: [("gain_rad_s2", Estimate { value, std })].into(),
            ordinary: true,
            extension: None,
        };
        let said =
            warnings(&[gain("roll", 90.0, 2.0), gain("pitch", -90.0, 40.0), gain("yaw", -111.0, 36.0)], &[], &[], &[]);
        assert!(said.len() == 1 && said[0].contains("of yaw is negative (-111 +- 36)"), "{said:?}");
        let bias = BaseTerm { effect: "torque_bias", ..gain("roll", -90.0, 2.0) };
        assert_eq!(warnings(&[bias], &[], &[], &[]), Vec::<String>::new());
    }
}
