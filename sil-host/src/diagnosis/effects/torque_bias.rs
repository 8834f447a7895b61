//! A constant moment.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::{Moment, Motion};
use crate::prediction::model::Model;

/// On one axis.
pub(super) struct TorqueBias(pub(super) Axis);

const PARAMETERS: [Parameter; 1] = [Parameter { name: "torque_nm", nominal: 0.0, step: 1e-4, min: -50.0, max: 50.0 }];

impl Effect for TorqueBias {
    fn in_words(&self) -> &'static str {
        "a constant moment acts on the vehicle"
    }
    fn name(&self) -> &'static str {
        "torque_bias"
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
        model.moments.push(Box::new(Constant { axis: self.0.index(), torque_nm: values[0] }));
    }
}

struct Constant {
    axis: usize,
    torque_nm: f64,
}

impl Moment for Constant {
    fn add(&self, _: &Motion, moment: &mut [f64; 3]) {
        moment[self.axis] += self.torque_nm;
    }
}
