//! The inertia about an axis is not the nominal one; pitch: of body and ring together, with its change over roll.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::model::Model;

/// About one axis.
pub(super) struct InertiaError(pub(super) Axis);

const PARAMETERS: [Parameter; 1] = [Parameter { name: "scale", nominal: 1.0, step: 1e-4, min: 0.2, max: 5.0 }];

impl Effect for InertiaError {
    fn in_words(&self) -> &'static str {
        "the inertia is not the nominal one"
    }
    fn name(&self) -> &'static str {
        "inertia_error"
    }
    fn place(&self) -> Place {
        Place::Plant
    }
    fn axis(&self) -> Option<Axis> {
        Some(self.0)
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.body.inertia_scale[self.0.index()] *= values[0];
    }
}
