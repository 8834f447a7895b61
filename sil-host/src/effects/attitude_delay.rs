//! Attitude that is reported late: a log's angles are those of `delay_s` before the row. The gyro is on time, and
//! so is the controller, which makes its own attitude of it. Several delays add up.

use super::{ANY_RIG, CatalogueEntry, Catalogued, Extension, Origin, SensorChain};
use crate::model::{ModelError, Rig, Section, admissible};

/// Attitude that is reported late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeDelay {
    /// Delay, s.
    pub delay_s: f64,
}

impl Catalogued for AttitudeDelay {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "attitude_delay",
        origin: Origin::Sensor,
        summary: "reported attitude lags the true one",
        example: "attitude_delay:delay_s=0.02",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self { delay_s: section.number("delay_s", admissible(0.0, 1.0, "a delay in s"))? })
    }
}

impl Extension for AttitudeDelay {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("delay_s", self.delay_s)]
    }

    fn change_sensors(&self, chain: &mut SensorChain) {
        chain.attitude_delay_s += self.delay_s;
    }
}
