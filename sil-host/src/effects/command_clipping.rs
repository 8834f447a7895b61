//! A speed controller that does less than it is asked at an end of its range. Of several, the tightest limits hold.

use super::{ANY_RIG, ActuatorChain, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// Speed controllers that do less than they are asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandClipping {
    /// Smallest command that is done, 0..1.
    pub min: f64,
    /// Largest command that is done, 0..1.
    pub max: f64,
}

impl Catalogued for CommandClipping {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "command_clipping",
        origin: Origin::Actuator,
        summary: "commands beyond min and max are not done",
        example: "command_clipping:min=0.3,max=0.7",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        let command = admissible(0.0, 1.0, "a command, 0 to 1");
        let [min, max] = [section.optional_number("min", command)?, section.optional_number("max", command)?];
        let clipping = Self { min: min.unwrap_or(0.0), max: max.unwrap_or(1.0) };
        if (min.is_none() && max.is_none()) || clipping.min >= clipping.max {
            return Err(section
                .impossible("command_clipping lacks a range: expected `min` or `max` or both, min below max".into()));
        }
        Ok(clipping)
    }
}

impl Extension for CommandClipping {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("min", self.min), ("max", self.max)]
    }

    fn change_actuators(&self, chain: &mut ActuatorChain) {
        chain.command_min = chain.command_min.max(self.min);
        chain.command_max = chain.command_max.min(self.max);
    }
}
