//! Motors slower than the model's: a first-order lag on the command, `T dc/dt = command - c`, before the motor's own.
//!
//! Between two commands the lag's motion is an exponential, which the plant takes as such. Several add their time
//! constants.

use super::{ANY_RIG, ActuatorChain, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// A first-order lag beyond the nominal motor's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLag {
    /// Time constant T, s.
    pub time_constant_s: f64,
}

impl Catalogued for MotorLag {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "motor_lag",
        origin: Origin::Actuator,
        summary: "first-order lag beyond the motor's own",
        example: "motor_lag:time_constant_s=0.03",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self { time_constant_s: section.number("time_constant_s", admissible(0.0, 2.0, "a time constant in s"))? })
    }
}

impl Extension for MotorLag {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("time_constant_s", self.time_constant_s)]
    }

    fn change_actuators(&self, chain: &mut ActuatorChain) {
        chain.lag_s += self.time_constant_s;
    }

    fn step_max_s(&self, _inertia_kg_m2: [f64; 3]) -> f64 {
        if self.time_constant_s > 0.0 { 0.5 * self.time_constant_s } else { f64::INFINITY }
    }
}
