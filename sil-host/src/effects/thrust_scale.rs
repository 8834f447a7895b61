//! All four motors stronger or weaker than the model's: lift and reaction torque are scaled, speed is not.

use super::{ANY_RIG, ActuatorChain, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// All motors stronger or weaker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustScale {
    /// True lift over nominal.
    pub scale: f64,
}

impl Catalogued for ThrustScale {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "thrust_scale",
        origin: Origin::Actuator,
        summary: "lift of all four motors",
        example: "thrust_scale:scale=0.9",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self { scale: section.number("scale", admissible(0.0, 5.0, "true lift over nominal"))? })
    }
}

impl Extension for ThrustScale {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change_actuators(&self, chain: &mut ActuatorChain) {
        for factor in &mut chain.lift_scale {
            *factor *= self.scale;
        }
    }
}
