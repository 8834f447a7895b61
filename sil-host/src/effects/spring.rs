//! A spring, `-k (angle - rest)`: a cable between body and rig, say.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

/// A spring between body and rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The axis it acts on.
    pub axis: Axis,
    /// Moment over angle, N m/rad; positive pulls back.
    pub stiffness_nm_rad: f64,
    /// Angle without moment, rad.
    pub rest_rad: f64,
}

const STIFFNESS: Parameter =
    Parameter::new("stiffness_nm_rad", "N m/rad", "moment over angle, pulling back where positive", [-50.0, 50.0]);
const REST: Parameter = Parameter::new("rest_rad", "rad", "angle without moment", [-7.0, 7.0]).usual(0.0);

/// Stiffness that stands for none where a fit has a moment without one, as a share of the step of a difference
/// quotient: its angle of rest is far away, and it pulls with that moment wherever the vehicle is.
const NO_STIFFNESS: f64 = 1e-9;

impl Catalogued for Spring {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "spring",
        origin: Origin::Plant,
        acts_on: ActsOn::TurningAxis,
        parameters: &[STIFFNESS, REST],
        summary: "a spring, a cable say",
        statement: "a spring pulls the vehicle toward an angle",
        equation: "Q = -stiffness_nm_rad (angle - rest_rad)",
        example: "spring:axis=pitch,stiffness_nm_rad=0.1,rest_rad=0.05",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, stiffness_nm_rad: given.number(&STIFFNESS)?, rest_rad: given.number(&REST)? })
    }

    /// Fitted as stiffness and moment at angle 0, in which the prediction is linear.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let of_axis = |axis: Axis| {
            // per second squared of the axis' inertia: from falling over within 0.1 s to 16 Hz
            let per_s2 = scope.scale.inertia_kg_m2[axis.index()];
            let stiffness = Unknown::amplitude(STIFFNESS.name, 1e-3 * per_s2, [-100.0 * per_s2, 1e4 * per_s2]);
            let at_zero = Unknown::moment("moment_at_zero_nm", &scope.scale).as_trim(REST.name);
            Hypothesis::new(Self::ENTRY, [stiffness, at_zero], move |[stiffness_nm_rad, at_zero_nm]| {
                let is_none = stiffness_nm_rad == 0.0;
                let stiffness_nm_rad = if is_none { NO_STIFFNESS * stiffness.step } else { stiffness_nm_rad };
                Self { axis, stiffness_nm_rad, rest_rad: at_zero_nm / stiffness_nm_rad }
            })
        };
        scope.borne_axes().filter(|axis| scope.knows_angle(*axis)).map(of_axis).collect()
    }
}

impl Extension for Spring {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("stiffness_nm_rad", self.stiffness_nm_rad), ("rest_rad", self.rest_rad)]
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

    fn acts_by_angle(&self) -> bool {
        true
    }

    fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        0.5 * (inertia_kg_m2[self.axis.index()] / self.stiffness_nm_rad.abs()).sqrt()
    }
}

impl Moment for Spring {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let axis = self.axis.index();
        moment[axis] -= self.stiffness_nm_rad * (motion.angle_rad[axis] - self.rest_rad);
    }
}
