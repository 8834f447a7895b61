//! Why a log does not show what its commands do.

use serde::Serialize;

use super::evidence::warnings::Shown;
use super::few_commands::are_few;
use super::verdict::{answers, is_possible};

/// Why a log does not show what the commands do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NotShownBecause {
    /// The log has so few of the commands that were given that they show nothing.
    FewCommands,
    /// What was fitted turns against its commands, or before any motor can turn it.
    NoVehicle,
    /// What follows from the pilot's stick or the reference alone gives another gain than all motion.
    Denied,
    /// No axis has a gain that is surely other than zero.
    NoGain,
    /// No response to the commands predicts the motion much better than its mean.
    BesideCommands,
}

impl NotShownBecause {
    /// Of an answer whose verdict is that.
    pub(super) fn of(shown: &Shown<'_>) -> Self {
        let Shown { base, denied, holding, lateness_s, .. } = shown;
        match () {
            () if are_few(shown.commands_per_s) => Self::FewCommands,
            () if !is_possible(base, !holding.is_empty(), *lateness_s) => Self::NoVehicle,
            () if !denied.is_empty() => Self::Denied,
            () if !answers(base) => Self::NoGain,
            () => Self::BesideCommands,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::{BaseTerm, Estimate};
    use std::collections::BTreeMap;

    #[test]
    fn why_nothing_is_shown_is_said_by_what_is_worst() {
        let gain = |value, std| BaseTerm {
            effect: "input_gain",
            axis: Some("pitch"),
            parameters: BTreeMap::from([("gain_rad_s2", Estimate { value, std })]),
            ordinary: true,
            extension: None,
        };
        let given = |base: &[BaseTerm], denied: &[String], commands_per_s| {
            let shown = Shown { base, by_reference: &[], denied, holding: &[], lateness_s: None, commands_per_s };
            NotShownBecause::of(&shown)
        };
        let because = |base: &[BaseTerm], denied: &[String]| given(base, denied, Some(50.0));
        let denied = ["pitch".to_owned()];
        assert_eq!(given(&[gain(-200.0, 20.0)], &denied, Some(10.0)), NotShownBecause::FewCommands);
        assert_eq!(because(&[gain(-200.0, 20.0)], &denied), NotShownBecause::NoVehicle);
        assert_eq!(because(&[gain(200.0, 20.0)], &denied), NotShownBecause::Denied);
        assert_eq!(because(&[gain(20.0, 20.0)], &[]), NotShownBecause::NoGain);
        assert_eq!(because(&[gain(200.0, 20.0)], &[]), NotShownBecause::BesideCommands);
    }
}
