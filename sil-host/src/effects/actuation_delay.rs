//! A pure delay from command to motor. The plant lets each command take effect at its own time, between the integrator's
//! steps. Several delays add up.

use super::{ANY_RIG, ActuatorChain, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// Commands that arrive late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuationDelay {
    /// Delay, s.
    pub delay_s: f64,
}

impl Catalogued for ActuationDelay {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "actuation_delay",
        origin: Origin::Actuator,
        summary: "pure delay from command to motor",
        example: "actuation_delay:delay_s=0.01",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self { delay_s: section.number("delay_s", admissible(0.0, 1.0, "a delay in s"))? })
    }
}

impl Extension for ActuationDelay {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("delay_s", self.delay_s)]
    }

    fn change_actuators(&self, chain: &mut ActuatorChain) {
        chain.delay_s += self.delay_s;
    }
}
