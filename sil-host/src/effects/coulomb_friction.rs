//! Dry friction, `-c tanh(rate / 0.02 rad/s)`: a bearing without grease. The hyperbolic tangent stands for the sign.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Scope, TORQUE, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

/// Rate at which friction has three quarters of its full size, rad/s.
const RATE_SCALE_RAD_S: f64 = 0.02;

/// Dry friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombFriction {
    /// The axis it acts on.
    pub axis: Axis,
    /// Moment against the motion, N m.
    pub torque_nm: f64,
}

impl Catalogued for CoulombFriction {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "coulomb_friction",
        origin: Origin::Plant,
        acts_on: ActsOn::TurningAxis,
        parameters: &[TORQUE],
        summary: "dry friction",
        statement: "dry friction brakes the vehicle",
        equation: "Q = -torque_nm tanh(rate / 0.02 rad/s)",
        example: "coulomb_friction:axis=pitch,torque_nm=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, torque_nm: given.number(&TORQUE)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let moment_nm = scope.scale.moment_nm;
        // friction that drives is none
        let torque = Unknown::moment(TORQUE.name, &scope.scale).within(0.0, 5.0 * moment_nm);
        let of_axis = |axis| Hypothesis::new(Self::ENTRY, [torque], move |[torque_nm]| Self { axis, torque_nm });
        scope.turning_axes().map(of_axis).collect()
    }
}

impl Extension for CoulombFriction {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("torque_nm", self.torque_nm)]
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }

    fn turns_round_rad_s(&self) -> Option<f64> {
        (self.torque_nm != 0.0).then_some(RATE_SCALE_RAD_S)
    }

    fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        0.5 * inertia_kg_m2[self.axis.index()] * RATE_SCALE_RAD_S / self.torque_nm.abs()
    }
}

impl Moment for CoulombFriction {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let axis = self.axis.index();
        moment[axis] -= self.torque_nm * tanh(motion.rate_rad_s[axis] / RATE_SCALE_RAD_S);
    }
}

/// Hyperbolic tangent, to 1e-16 of one: by a single exponential, for friction is asked for in every stage of a step.
#[inline]
fn tanh(x: f64) -> f64 {
    const ONE_FROM: f64 = 20.0;
    if x.abs() > ONE_FROM {
        return 1f64.copysign(x);
    }
    let left = libm::exp(-2.0 * x.abs());
    ((1.0 - left) / (1.0 + left)).copysign(x)
}
