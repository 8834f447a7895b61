//! The rotors brake the vehicle in proportion to its speed against the air, in their own plane: free flight.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// Of all rotors together.
pub(super) struct RotorDrag;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "coefficient_ns_m", nominal: 0.0, step: 1e-4, min: -10.0, max: 20.0 }];

impl Effect for RotorDrag {
    fn in_words(&self) -> &'static str {
        "the rotors brake the vehicle in proportion to its speed"
    }
    fn name(&self) -> &'static str {
        "rotor_drag"
    }
    fn place(&self) -> Place {
        Place::Plant
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.air.rotor_drag_ns_m += values[0];
    }
}
