//! The ESC does less than it is asked at an end of its range.

use super::{Effect, Hints, Parameter, Place};
use crate::prediction::model::Model;

/// Of all motors alike.
pub(super) struct CommandClipping;

const PARAMETERS: [Parameter; 2] = [
    Parameter { name: "min", nominal: 0.0, step: 1e-4, min: 0.0, max: 0.9 },
    Parameter { name: "max", nominal: 1.0, step: 1e-4, min: 0.1, max: 1.0 },
];

impl Effect for CommandClipping {
    fn in_words(&self) -> &'static str {
        "the speed controllers do less than they are asked at an end of their range"
    }
    fn name(&self) -> &'static str {
        "command_clipping"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    /// Inside the range of the commands, at one end or the other: outside, nothing depends on it.
    fn starts(&self, hints: &Hints) -> Vec<Vec<f64>> {
        let [low, high] = hints.command_range;
        let inset = 0.1 * (high - low);
        vec![vec![0.0, high - inset], vec![low + inset, 1.0]]
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        let chain = &mut model.chain;
        (chain.command_min, chain.command_max) = (chain.command_min.max(values[0]), chain.command_max.min(values[1]));
    }
}
