//! Friction in proportion to the rate, `-b rate`: a greased bearing, or the rotors' aerodynamic damping.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

/// Friction in proportion to the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViscousFriction {
    /// The axis it acts on.
    pub axis: Axis,
    /// Moment over rate, N m s; positive brakes.
    pub coefficient_nms: f64,
}

const COEFFICIENT: Parameter =
    Parameter::new("coefficient_nms", "N m s", "moment over rate, braking where positive", [-20.0, 20.0]);

impl Catalogued for ViscousFriction {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "viscous_friction",
        origin: Origin::Plant,
        acts_on: ActsOn::TurningAxis,
        parameters: &[COEFFICIENT],
        summary: "friction in proportion to the rate",
        statement: "a moment proportional to the rate brakes the vehicle",
        equation: "Q = -coefficient_nms rate",
        example: "viscous_friction:axis=pitch,coefficient_nms=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, coefficient_nms: given.number(&COEFFICIENT)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let of_axis = |axis: Axis| {
            // per second of the axis' inertia: friction that drives is none, and within 5 ms nothing stops
            let per_s = scope.scale.inertia_kg_m2[axis.index()];
            let coefficient = Unknown::amplitude(COEFFICIENT.name, 1e-3 * per_s, [0.0, 200.0 * per_s]);
            Hypothesis::new(Self::ENTRY, [coefficient], move |[coefficient_nms]| Self { axis, coefficient_nms })
        };
        scope.turning_axes().map(of_axis).collect()
    }
}

impl Extension for ViscousFriction {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("coefficient_nms", self.coefficient_nms)]
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }

    fn keeps_to_axis(&self) -> bool {
        true
    }

    fn restores(&self) -> bool {
        true
    }

    fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        0.5 * inertia_kg_m2[self.axis.index()] / self.coefficient_nms.abs()
    }
}

impl Moment for ViscousFriction {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let axis = self.axis.index();
        moment[axis] -= self.coefficient_nms * motion.rate_rad_s[axis];
    }
}
