//! Off-diagonal inertia between roll and pitch: kinetic energy `+ P p q`.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// Between roll and pitch.
pub(super) struct InertiaCoupling;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "product_kg_m2", nominal: 0.0, step: 1e-6, min: -0.009, max: 0.009 }];

impl Effect for InertiaCoupling {
    fn in_words(&self) -> &'static str {
        "roll and pitch are coupled by an off-diagonal inertia"
    }
    fn name(&self) -> &'static str {
        "inertia_coupling"
    }
    fn place(&self) -> Place {
        Place::Plant
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.body.product_kg_m2 += values[0];
    }
}
