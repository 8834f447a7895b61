//! The reported attitude is older than the row; the gyro is not.

use super::{Effect, Hints, Parameter, Place};
use crate::prediction::model::Model;

/// Of all angles alike.
pub(super) struct AttitudeDelay;

const PARAMETERS: [Parameter; 1] = [Parameter { name: "delay_s", nominal: 0.0, step: 1e-5, min: 0.0, max: 0.3 }];

impl Effect for AttitudeDelay {
    fn in_words(&self) -> &'static str {
        "the attitude is reported late"
    }
    fn name(&self) -> &'static str {
        "attitude_delay"
    }
    fn place(&self) -> Place {
        Place::Sensor
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn starts(&self, _: &Hints) -> Vec<Vec<f64>> {
        vec![vec![0.005]]
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.sensors.attitude_delay_s += values[0];
    }
}
