//! A constant on the gyro's reading, after its scale: temperature, age.

use super::text::read_any_axis;
use super::{ANY_RIG, CatalogueEntry, Catalogued, Extension, Origin, SensorChain};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

/// A constant on the gyro's reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroBias {
    /// The axis it acts on.
    pub axis: Axis,
    /// Reported rate at rest, rad/s.
    pub bias_rad_s: f64,
}

impl Catalogued for GyroBias {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "gyro_bias",
        origin: Origin::Sensor,
        summary: "reported rate at rest",
        example: "gyro_bias:axis=yaw,bias_rad_s=0.02",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_any_axis(section)?,
            bias_rad_s: section.number("bias_rad_s", admissible(-5.0, 5.0, "a rate in rad/s"))?,
        })
    }
}

impl Extension for GyroBias {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("bias_rad_s", self.bias_rad_s)]
    }

    fn change_sensors(&self, chain: &mut SensorChain) {
        chain.gyro_bias_rad_s[self.axis.index()] += self.bias_rad_s;
    }
}
