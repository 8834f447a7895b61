//! What a reader of the numbers must know before he uses them, a sentence each.

use super::horizons::Horizon;
use crate::axis::Axis;
use crate::diagnosis::Holding;
use crate::diagnosis::base::BaseTerm;
use crate::diagnosis::estimate::Estimate;
use crate::diagnosis::holding::held_against;
use crate::diagnosis::verdict::{self, QUICKEST_S};
use crate::log::sanity::ByReference;
use crate::prediction::WINDOW_S;

/// Share by which a base model must miss a channel by more than the nominal one for that to be said.
const HARM_FROM: f64 = 0.1;
/// Commands a second of a controller that gives others between them, from which on answers have been held against the
/// truth: blind campaigns with logs of 100 and more.
const COMMANDS_TRIED: f64 = 90.0;

/// What an answer says of a vehicle and its commands.
pub(in crate::diagnosis) struct Shown<'a> {
    pub(in crate::diagnosis) base: &'a [BaseTerm],
    pub(in crate::diagnosis) by_reference: &'a [ByReference],
    /// In words.
    pub(in crate::diagnosis) denied: &'a [String],
    pub(in crate::diagnosis) holding: &'a [Holding],
    /// Lag and delay together, s.
    pub(in crate::diagnosis) lateness_s: Option<Estimate>,
    /// Commands that the log has of each second, where the controller gave others between them.
    pub(in crate::diagnosis) commands_per_s: Option<f64>,
}

/// Of a base model's numbers, of those that are denied, and of what they predict, or why that is no test of them.
pub(in crate::diagnosis) fn warnings(shown: &Shown<'_>, horizons: &[Horizon]) -> Vec<String> {
    let Shown { base, by_reference, denied, holding, lateness_s, commands_per_s } = shown;
    let harm = held_against(holding).or_else(|| harm(base, horizons));
    let too_quick = lateness_s.filter(|_| !holding.is_empty()).and_then(too_quick);
    let reversed = Axis::ALL.into_iter().filter_map(|axis| reversed(axis.name(), base, by_reference));
    let few = commands_per_s.and_then(few_commands);
    reversed.chain(held(denied)).chain(too_quick).chain(harm).chain(few).collect()
}

/// A log that has few of the commands that were given.
fn few_commands(per_s: f64) -> Option<String> {
    (per_s < COMMANDS_TRIED).then(|| {
        format!(
            "The controller commanded more often than the {per_s:.0} times a second that this log has, and what it \
             commanded between them nobody knows. Of a simulated vehicle that is as modelled, such logs have shown \
             frictions, inertias and onsets of a few percent that are not there. Log 100 commands a second or more, or \
             the control loop's own rate."
        )
    })
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

/// Commands that nothing can follow so early.
fn too_quick(lateness_s: Estimate) -> Option<String> {
    let [own, least] = [lateness_s.value, QUICKEST_S].map(|late_s| 1e3 * late_s);
    verdict::is_too_quick(lateness_s).then(|| {
        format!(
            "Lag and delay together are {own:.1} ms, and no motor turns a vehicle within {least:.0}: what was fitted \
             is how the controller answers the motion, and its numbers are not to be relied on."
        )
    })
}

/// An axis that turns against its command, by all motion or by what follows from the stick.
fn reversed(axis: &'static str, base: &[BaseTerm], by_reference: &[ByReference]) -> Option<String> {
    let own = base.iter().filter(|term| term.axis == Some(axis)).find_map(verdict::reversed_gain);
    let by_stick = || {
        let of = by_reference.iter().find(|of| of.axis == axis)?;
        verdict::is_reversed(Estimate { value: of.gain_rad_s2, std: of.std_rad_s2 }).then(|| of.to_string())
    };
    let gain = own.map(|gain| gain.to_string()).or_else(by_stick)?;
    let likely = match axis {
        "yaw" => "motors that turn the other way round than assumed (propellers out), or a yaw of the other sign",
        _ => "motors in another order than assumed, a rate of the other sign, or a vehicle that stood, lay or hung",
    };
    Some(format!(
        "The input gain of {axis} is negative ({gain}): the vehicle seems to turn against its command. No vehicle that \
         flies does; likely are {likely}, and what is said of {axis} is not to be relied on."
    ))
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

    fn said(base: &[BaseTerm], by_reference: &[ByReference], lateness_s: Option<Estimate>, holds: bool) -> Vec<String> {
        let held = Holding { axis: "roll", std_rad_s2: 8.0, memory_s: 1.0 };
        let holding = if holds { &[held][..] } else { &[] };
        warnings(&Shown { base, by_reference, denied: &[], holding, lateness_s, commands_per_s: None }, &[])
    }

    #[test]
    fn commands_between_those_of_a_log_are_told() {
        let shown = |commands_per_s| {
            let (lateness_s, none) = (None, &[][..]);
            let shown = Shown { base: &[], by_reference: &[], denied: none, holding: &[], lateness_s, commands_per_s };
            warnings(&shown, &[])
        };
        let few = shown(Some(50.0));
        assert!(few.len() == 1 && few[0].contains("the 50 times a second"), "{few:?}");
        assert_eq!([shown(Some(100.0)), shown(None)], [Vec::<String>::new(), Vec::new()]);
    }

    #[test]
    fn an_axis_that_surely_turns_against_its_command_is_named() {
        let gain = |axis, value, std| BaseTerm {
            effect: "input_gain",
            axis: Some(axis),
            parameters: [("gain_rad_s2", Estimate { value, std })].into(),
            ordinary: true,
            extension: None,
        };
        let base = [gain("roll", 90.0, 2.0), gain("pitch", -90.0, 40.0), gain("yaw", -111.0, 36.0)];
        let of_base = said(&base, &[], None, false);
        assert!(of_base.len() == 1 && of_base[0].contains("of yaw is negative (-111 +- 36)"), "{of_base:?}");
        let bias = BaseTerm { effect: "torque_bias", ..gain("roll", -90.0, 2.0) };
        assert_eq!(said(&[bias], &[], None, false), Vec::<String>::new());
        // what a fit does not show the stick may
        let stick = ByReference { axis: "pitch", by_stick: true, gain_rad_s2: -108.0, std_rad_s2: 18.0, late_s: 0.04 };
        let by_stick = said(&base[..2], &[stick], None, false);
        assert!(by_stick.len() == 1 && by_stick[0].contains("-108 +- 18 rad/s^2 by the stick"), "{by_stick:?}");
    }

    #[test]
    fn commands_that_act_before_any_motor_can_are_named_where_they_hold_against_a_disturbance() {
        let late = |value, std| Some(Estimate { value, std });
        let quick = said(&[], &[], late(0.0059, 0.0006), true);
        assert!(quick.len() == 2 && quick[0].contains("together are 5.9 ms"), "{quick:?}");
        for (lateness_s, holds) in [(late(0.0059, 0.0030), true), (late(0.0059, 0.0006), false), (None, true)] {
            let other = said(&[], &[], lateness_s, holds);
            assert!(other.iter().all(|sentence| !sentence.contains("together")), "{lateness_s:?}: {other:?}");
        }
    }
}
