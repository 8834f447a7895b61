//! Dry friction, `-c tanh(rate / 0.02 rad/s)`: a bearing without grease. The hyperbolic tangent stands for the sign.

use super::text::read_axis;
use super::{ANY_RIG, AxisMotion, CatalogueEntry, Catalogued, Extension, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

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
        summary: "dry friction",
        example: "coulomb_friction:axis=pitch,torque_nm=0.02",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_axis(section, rig)?,
            torque_nm: section.number("torque_nm", admissible(-20.0, 20.0, "a moment in N m"))?,
        })
    }
}

impl Extension for CoulombFriction {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("torque_nm", self.torque_nm)]
    }

    fn axis_torque_nm(&self, motion: AxisMotion) -> f64 {
        -self.torque_nm * libm::tanh(motion.rate_rad_s / RATE_SCALE_RAD_S)
    }

    fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        0.5 * inertia_kg_m2[self.axis.index()] * RATE_SCALE_RAD_S / self.torque_nm.abs()
    }
}
