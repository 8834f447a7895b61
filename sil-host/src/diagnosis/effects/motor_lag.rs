//! A first-order lag of the command beyond the motor's own.

use super::{Effect, Hints, Parameter, Place};
use crate::prediction::model::Model;

/// Of all motors alike.
pub(super) struct MotorLag;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "time_constant_s", nominal: 0.0, step: 1e-5, min: 0.0, max: 0.5 }];

impl Effect for MotorLag {
    fn in_words(&self) -> &'static str {
        "the motors follow their commands later than the model says"
    }
    fn name(&self) -> &'static str {
        "motor_lag"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn starts(&self, _: &Hints) -> Vec<Vec<f64>> {
        vec![vec![0.01]]
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.chain.lag_s += values[0];
    }
}
