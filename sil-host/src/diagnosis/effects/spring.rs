//! A moment toward an angle of rest, proportional to the way from it: a cable, say. Fitted as stiffness and moment at zero, in which the
//! prediction is linear, and told as stiffness and rest angle.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::{Moment, Motion};
use crate::prediction::model::Model;

/// On one axis.
pub(super) struct Spring(pub(super) Axis);

const PARAMETERS: [Parameter; 2] = [
    Parameter { name: "stiffness_nm_rad", nominal: 0.0, step: 1e-4, min: -50.0, max: 500.0 },
    Parameter { name: "moment_at_zero_nm", nominal: 0.0, step: 1e-4, min: -50.0, max: 50.0 },
];

impl Effect for Spring {
    fn in_words(&self) -> &'static str {
        "a spring pulls the vehicle toward an angle"
    }
    fn name(&self) -> &'static str {
        "spring"
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
        let (stiffness_nm_rad, at_zero_nm) = (values[0], values[1]);
        model.moments.push(Box::new(Linear { axis: self.0.index(), stiffness_nm_rad, at_zero_nm }));
    }
    fn told(&self, values: &[f64]) -> Vec<(&'static str, f64)> {
        vec![("stiffness_nm_rad", values[0]), ("rest_rad", values[1] / values[0])]
    }
    fn values_of(&self, told: &dyn Fn(&str) -> Option<f64>) -> Vec<f64> {
        let stiffness_nm_rad = told("stiffness_nm_rad").unwrap_or_default();
        vec![stiffness_nm_rad, stiffness_nm_rad * told("rest_rad").unwrap_or_default()]
    }
}

struct Linear {
    axis: usize,
    stiffness_nm_rad: f64,
    at_zero_nm: f64,
}

impl Moment for Linear {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        moment[self.axis] += self.at_zero_nm - self.stiffness_nm_rad * motion.angle_rad[self.axis];
    }
}
