//! How much an axis of a foreign bench accelerates per unit of its command. No effect of the catalogue: its nominal value is fitted to each log,
//! along with whatever else is in the model.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::BodyRig;
use crate::prediction::model::Model;

/// Of one axis.
pub(in crate::diagnosis) struct InputGain(pub(in crate::diagnosis) Axis);

const PARAMETERS: [Parameter; 1] = [Parameter { name: "gain_rad_s2", nominal: 1.0, step: 1e-3, min: -1e4, max: 1e4 }];

impl Effect for InputGain {
    fn in_words(&self) -> &'static str {
        "acceleration per command"
    }
    fn name(&self) -> &'static str {
        "input_gain"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn axis(&self) -> Option<Axis> {
        Some(self.0)
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        if let BodyRig::Axes { gain_rad_s2 } = &mut model.body.rig {
            gain_rad_s2[self.0.index()] = values[0];
        }
    }
}
