//! The gyro reports `scale * true + bias`.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::model::Model;

/// On one axis.
pub(super) struct GyroBias(pub(super) Axis);
/// On one axis.
pub(super) struct GyroScale(pub(super) Axis);

const BIAS: [Parameter; 1] = [Parameter { name: "bias_rad_s", nominal: 0.0, step: 1e-4, min: -5.0, max: 5.0 }];
const SCALE: [Parameter; 1] = [Parameter { name: "scale", nominal: 1.0, step: 1e-4, min: 0.2, max: 5.0 }];

impl Effect for GyroBias {
    fn in_words(&self) -> &'static str {
        "the gyro has a bias"
    }
    fn name(&self) -> &'static str {
        "gyro_bias"
    }
    fn place(&self) -> Place {
        Place::Sensor
    }
    fn axis(&self) -> Option<Axis> {
        Some(self.0)
    }
    fn parameters(&self) -> &'static [Parameter] {
        &BIAS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.sensors.gyro_bias_rad_s[self.0.index()] += values[0];
    }
}

impl Effect for GyroScale {
    fn in_words(&self) -> &'static str {
        "the gyro's scale is off"
    }
    fn name(&self) -> &'static str {
        "gyro_scale"
    }
    fn place(&self) -> Place {
        Place::Sensor
    }
    fn axis(&self) -> Option<Axis> {
        Some(self.0)
    }
    fn parameters(&self) -> &'static [Parameter] {
        &SCALE
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.sensors.gyro_scale[self.0.index()] *= values[0];
    }
}
