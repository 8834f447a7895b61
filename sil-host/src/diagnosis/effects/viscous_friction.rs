//! A moment against the rate, proportional to it: bearings in oil, or the rotors' damping.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::{Moment, Motion};
use crate::prediction::model::Model;

/// On one axis.
pub(super) struct ViscousFriction(pub(super) Axis);

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "coefficient_nms", nominal: 0.0, step: 1e-4, min: -10.0, max: 50.0 }];

impl Effect for ViscousFriction {
    fn in_words(&self) -> &'static str {
        "a moment proportional to the rate brakes the vehicle"
    }
    fn name(&self) -> &'static str {
        "viscous_friction"
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
        model.moments.push(Box::new(Damping { axis: self.0.index(), coefficient_nms: values[0] }));
    }
}

struct Damping {
    axis: usize,
    coefficient_nms: f64,
}

impl Moment for Damping {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        moment[self.axis] -= self.coefficient_nms * motion.rate_rad_s[self.axis];
    }
}
