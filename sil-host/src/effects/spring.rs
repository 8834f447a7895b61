//! A spring, `-k (angle - rest)`: a cable between body and rig, say.

use super::text::read_axis;
use super::{ANY_RIG, AxisMotion, CatalogueEntry, Catalogued, Extension, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

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

impl Catalogued for Spring {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "spring",
        origin: Origin::Plant,
        summary: "a spring, a cable say",
        example: "spring:axis=pitch,stiffness_nm_rad=0.1,rest_rad=0.05",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_axis(section, rig)?,
            stiffness_nm_rad: section
                .number("stiffness_nm_rad", admissible(-50.0, 50.0, "a moment over an angle in N m/rad"))?,
            rest_rad: section.optional_number("rest_rad", admissible(-7.0, 7.0, "an angle in rad"))?.unwrap_or(0.0),
        })
    }
}

impl Extension for Spring {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("stiffness_nm_rad", self.stiffness_nm_rad), ("rest_rad", self.rest_rad)]
    }

    fn axis_torque_nm(&self, motion: AxisMotion) -> f64 {
        -self.stiffness_nm_rad * (motion.angle_rad - self.rest_rad)
    }

    fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        0.5 * (inertia_kg_m2[self.axis.index()] / self.stiffness_nm_rad.abs()).sqrt()
    }
}
