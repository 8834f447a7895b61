//! A gyro whose scale is not the data sheet's: reported = scale * true.

use super::text::read_any_axis;
use super::{ANY_RIG, CatalogueEntry, Catalogued, Extension, Origin, SensorChain};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

/// A wrong scale of the gyro.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroScale {
    /// The axis it acts on.
    pub axis: Axis,
    /// Reported rate over true.
    pub scale: f64,
}

impl Catalogued for GyroScale {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "gyro_scale",
        origin: Origin::Sensor,
        summary: "reported rate over true",
        example: "gyro_scale:axis=roll,scale=1.05",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_any_axis(section)?,
            scale: section.number("scale", admissible(0.05, 5.0, "reported rate over true"))?,
        })
    }
}

impl Extension for GyroScale {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change_sensors(&self, chain: &mut SensorChain) {
        chain.gyro_scale[self.axis.index()] *= self.scale;
    }
}
