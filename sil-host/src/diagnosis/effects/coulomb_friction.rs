//! Dry friction: a moment of constant size against the rate, `-c tanh(rate / 0.02 rad/s)`.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::{Moment, Motion};
use crate::prediction::model::Model;

/// On one axis.
pub(super) struct CoulombFriction(pub(super) Axis);

const PARAMETERS: [Parameter; 1] = [Parameter { name: "torque_nm", nominal: 0.0, step: 1e-4, min: -5.0, max: 50.0 }];

/// Rate at which it is three quarters there, rad/s.
pub(crate) const SOFTENING_RAD_S: f64 = 0.02;

impl Effect for CoulombFriction {
    fn in_words(&self) -> &'static str {
        "dry friction brakes the vehicle"
    }
    fn name(&self) -> &'static str {
        "coulomb_friction"
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
        model.dry[self.0.index()] = true;
        model.moments.push(Box::new(Dry { axis: self.0.index(), torque_nm: values[0] }));
    }
}

struct Dry {
    axis: usize,
    torque_nm: f64,
}

impl Moment for Dry {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        moment[self.axis] -= self.torque_nm * libm::tanh(motion.rate_rad_s[self.axis] / SOFTENING_RAD_S);
    }
}
