//! A mass that differs from the model's: true = scale * nominal. Free flight only; on the gimbal the pivot carries it.

use super::{BodyChange, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// A wrong mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassError {
    /// True mass over nominal.
    pub scale: f64,
}

impl Catalogued for MassError {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "mass_error",
        origin: Origin::Plant,
        summary: "true mass = scale * nominal",
        example: "mass_error:scale=1.1",
        rigs: &[Rig::Free],
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self { scale: section.number("scale", admissible(0.05, 20.0, "true mass over nominal"))? })
    }
}

impl Extension for MassError {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change_body(&self, change: &mut BodyChange) {
        change.mass_scale *= self.scale;
    }
}
