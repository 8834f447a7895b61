//! The vehicle weighs more or less than the model says: free flight.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// Of the whole vehicle.
pub(super) struct MassError;

const PARAMETERS: [Parameter; 1] = [Parameter { name: "scale", nominal: 1.0, step: 1e-4, min: 0.1, max: 10.0 }];

impl Effect for MassError {
    fn in_words(&self) -> &'static str {
        "the mass is not the nominal one"
    }
    fn name(&self) -> &'static str {
        "mass_error"
    }
    fn place(&self) -> Place {
        Place::Plant
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.air.mass_scale *= values[0];
    }
}
