//! Friction in proportion to the rate, `-b rate`: a greased bearing, or the rotors' aerodynamic damping.

use super::text::read_axis;
use super::{ANY_RIG, AxisMotion, CatalogueEntry, Catalogued, Extension, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

/// Friction in proportion to the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViscousFriction {
    /// The axis it acts on.
    pub axis: Axis,
    /// Moment over rate, N m s; positive brakes.
    pub coefficient_nms: f64,
}

impl Catalogued for ViscousFriction {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "viscous_friction",
        origin: Origin::Plant,
        summary: "friction in proportion to the rate",
        example: "viscous_friction:axis=pitch,coefficient_nms=0.02",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_axis(section, rig)?,
            coefficient_nms: section
                .number("coefficient_nms", admissible(-20.0, 20.0, "a moment over a rate in N m s"))?,
        })
    }
}

impl Extension for ViscousFriction {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("coefficient_nms", self.coefficient_nms)]
    }

    fn axis_torque_nm(&self, motion: AxisMotion) -> f64 {
        -self.coefficient_nms * motion.rate_rad_s
    }

    fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        0.5 * inertia_kg_m2[self.axis.index()] / self.coefficient_nms.abs()
    }
}
