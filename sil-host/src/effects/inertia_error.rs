//! A moment of inertia that differs from the model's: true = scale * nominal.
//!
//! On the gimbal roll scales I_xx and pitch scales J(phi), ring included, and with it J'(phi): the kinetic energy is
//! `1/2 s_roll I_xx phi'^2 + 1/2 s_pitch J(phi) theta'^2`.

use super::text::read_axis;
use super::{ANY_RIG, BodyChange, CatalogueEntry, Catalogued, Extension, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

/// A wrong moment of inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaError {
    /// The axis it acts on.
    pub axis: Axis,
    /// True inertia over nominal.
    pub scale: f64,
}

impl Catalogued for InertiaError {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "inertia_error",
        origin: Origin::Plant,
        summary: "true inertia = scale * nominal",
        example: "inertia_error:axis=pitch,scale=1.2",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_axis(section, rig)?,
            scale: section.number("scale", admissible(0.05, 20.0, "true inertia over nominal"))?,
        })
    }
}

impl Extension for InertiaError {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change_body(&self, change: &mut BodyChange) {
        change.inertia_scale[self.axis.index()] *= self.scale;
    }
}
