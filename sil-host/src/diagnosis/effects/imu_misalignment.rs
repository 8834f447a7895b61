//! The sensor is turned about the body's z axis.

use super::{Effect, Parameter, Place};
use crate::prediction::model::Model;

/// Attitude and gyro alike.
pub(super) struct ImuMisalignment;

const PARAMETERS: [Parameter; 1] = [Parameter { name: "yaw_rad", nominal: 0.0, step: 1e-5, min: -1.6, max: 1.6 }];

impl Effect for ImuMisalignment {
    fn in_words(&self) -> &'static str {
        "the sensor is turned about the vertical axis of the body"
    }
    fn name(&self) -> &'static str {
        "imu_misalignment"
    }
    fn place(&self) -> Place {
        Place::Sensor
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.sensors.yaw_rad += values[0];
    }
}
