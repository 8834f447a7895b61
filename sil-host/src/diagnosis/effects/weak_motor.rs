//! One motor, or its propeller, lifts less than the others.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// Motor 1 to 4.
pub(super) struct WeakMotor(pub(super) u8);

const PARAMETERS: [Parameter; 1] = [Parameter { name: "scale", nominal: 1.0, step: 1e-4, min: 0.0, max: 3.0 }];

impl Effect for WeakMotor {
    fn in_words(&self) -> &'static str {
        "one motor lifts more or less than the others"
    }
    fn name(&self) -> &'static str {
        "weak_motor"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn motor(&self) -> Option<u8> {
        Some(self.0)
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        if let Some(factor) = model.lift_factor.get_mut(usize::from(self.0) - 1) {
            *factor *= values[0];
        }
    }
}
