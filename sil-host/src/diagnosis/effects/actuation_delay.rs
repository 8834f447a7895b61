//! A pure delay from command to motor.

use super::{Effect, Hints, Parameter, Place};
use crate::prediction::model::Model;

/// Of all motors alike.
pub(super) struct ActuationDelay;

const PARAMETERS: [Parameter; 1] = [Parameter { name: "delay_s", nominal: 0.0, step: 1e-5, min: 0.0, max: 0.3 }];

impl Effect for ActuationDelay {
    fn in_words(&self) -> &'static str {
        "commands reach the motors late"
    }
    fn name(&self) -> &'static str {
        "actuation_delay"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn starts(&self, _: &Hints) -> Vec<Vec<f64>> {
        vec![vec![0.005]]
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.chain.delay_s += values[0];
    }
}
