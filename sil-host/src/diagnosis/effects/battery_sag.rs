//! Thrust falls with time, or with the battery's voltage.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// `1 - per_s t`, t from the first row.
pub(super) struct PerSecond;
/// `1 - per_volt (V0 - V)`, V0 the mean of the first second.
pub(super) struct PerVolt;

const PER_SECOND: [Parameter; 1] = [Parameter { name: "per_s", nominal: 0.0, step: 1e-6, min: -0.1, max: 0.1 }];
const PER_VOLT: [Parameter; 1] = [Parameter { name: "per_volt", nominal: 0.0, step: 1e-5, min: -1.0, max: 1.0 }];

impl Effect for PerSecond {
    fn in_words(&self) -> &'static str {
        "thrust falls with time"
    }
    fn name(&self) -> &'static str {
        "battery_sag"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PER_SECOND
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.sag_per_s += values[0];
    }
}

impl Effect for PerVolt {
    fn in_words(&self) -> &'static str {
        "thrust falls with the battery"
    }
    fn name(&self) -> &'static str {
        "battery_sag"
    }
    fn place(&self) -> Place {
        Place::Actuator
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PER_VOLT
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.sag_per_volt += values[0];
    }
}
