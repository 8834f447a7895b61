//! An IMU that is turned about the body's z axis. Positive turns its x axis from forward to right: it reports
//! `p c + q s`, `-p s + q c`, the specific force likewise, and the attitude of `R_wb Rz(yaw)`.

use super::{ANY_RIG, CatalogueEntry, Catalogued, Extension, Origin, SensorChain};
use crate::model::{ModelError, Rig, Section, admissible};

/// An IMU that is turned about the vertical axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuMisalignment {
    /// Angle of the sensor about the body's z axis, rad.
    pub yaw_rad: f64,
}

impl Catalogued for ImuMisalignment {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "imu_misalignment",
        origin: Origin::Sensor,
        summary: "IMU turned about the body's z axis",
        example: "imu_misalignment:yaw_rad=0.05",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self { yaw_rad: section.number("yaw_rad", admissible(-3.2, 3.2, "an angle in rad"))? })
    }
}

impl Extension for ImuMisalignment {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("yaw_rad", self.yaw_rad)]
    }

    fn change_sensors(&self, chain: &mut SensorChain) {
        chain.yaw_rad += self.yaw_rad;
    }
}
