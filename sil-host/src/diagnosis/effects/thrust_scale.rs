//! All four motors lift more or less than the model says.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// Of all motors alike.
pub(super) struct ThrustScale;

const PARAMETERS: [Parameter; 1] = [Parameter { name: "scale", nominal: 1.0, step: 1e-4, min: 0.1, max: 5.0 }];

impl Effect for ThrustScale {
    fn in_words(&self) -> &'static str {
        "all motors lift more or less than the model says"
    }
    fn name(&self) -> &'static str {
        "thrust_scale"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.lift_factor = model.lift_factor.map(|factor| factor * values[0]);
    }
}
