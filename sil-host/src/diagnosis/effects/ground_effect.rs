//! More lift close to the ground: free flight, where the log has the height above it. Fitted as the square of the radius with which the
//! rotors feel the ground, in which the lift is linear, and told as that radius and the height at the log's start.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// Of all rotors alike.
pub(super) struct GroundEffect {
    /// Height of the rotors above ground in the first row, m.
    pub(super) start_height_m: f64,
}

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "radius_squared_m2", nominal: 0.0, step: 1e-6, min: 0.0, max: 1.0 }];

impl Effect for GroundEffect {
    fn in_words(&self) -> &'static str {
        "the ground below lifts the vehicle"
    }
    fn name(&self) -> &'static str {
        "ground_effect"
    }
    fn place(&self) -> Place {
        Place::Environment
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn told(&self, values: &[f64]) -> Vec<(&'static str, f64)> {
        vec![("rotor_radius_m", values[0].max(0.0).sqrt()), ("height_m", self.start_height_m)]
    }
    fn values_of(&self, told: &dyn Fn(&str) -> Option<f64>) -> Vec<f64> {
        let radius_m = told("rotor_radius_m").unwrap_or_default();
        vec![radius_m * radius_m]
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.air.ground_radius_squared_m2 += values[0];
    }
}
