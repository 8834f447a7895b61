//! One motor, or its propeller, weaker than the others: its lift and reaction torque are scaled, its speed is not.

use super::{ANY_RIG, ActuatorChain, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// One motor weaker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakMotor {
    /// Place of the motor in arrays of four: its number less one.
    pub motor: usize,
    /// True lift over nominal.
    pub scale: f64,
}

impl Catalogued for WeakMotor {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "weak_motor",
        origin: Origin::Actuator,
        summary: "lift of one motor (or its propeller)",
        example: "weak_motor:motor=3,scale=0.9",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        let number = section.whole_number("motor", admissible(1.0, 4.0, "the motor's number, whole"))?;
        let scale = section.number("scale", admissible(0.0, 5.0, "true lift over nominal"))?;
        Ok(Self { motor: number as usize - 1, scale })
    }
}

impl Extension for WeakMotor {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("motor", (self.motor + 1) as f64), ("scale", self.scale)]
    }

    fn change_actuators(&self, chain: &mut ActuatorChain) {
        if let Some(factor) = chain.lift_scale.get_mut(self.motor) {
            *factor *= self.scale;
        }
    }
}
