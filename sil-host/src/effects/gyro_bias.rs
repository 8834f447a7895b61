//! A constant on the gyro's reading, after its scale: temperature, age.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::Changes;

/// A constant on the gyro's reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroBias {
    /// The axis it acts on.
    pub axis: Axis,
    /// Reported rate at rest, rad/s.
    pub bias_rad_s: f64,
}

const BIAS: Parameter = Parameter::new("bias_rad_s", "rad/s", "reported rate at rest", [-5.0, 5.0]);

impl Catalogued for GyroBias {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "gyro_bias",
        origin: Origin::Sensor,
        acts_on: ActsOn::AnyAxis,
        parameters: &[BIAS],
        summary: "reported rate at rest",
        statement: "the gyro has a bias",
        equation: "reported rate = scale * true rate + bias_rad_s, behind the misalignment",
        example: "gyro_bias:axis=yaw,bias_rad_s=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, bias_rad_s: given.number(&BIAS)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let bias = Unknown::of(&BIAS, 1e-4);
        let of_axis = |axis| Hypothesis::new(Self::ENTRY, [bias], move |[bias_rad_s]| Self { axis, bias_rad_s });
        scope.gyro_axes().map(of_axis).collect()
    }
}

impl Extension for GyroBias {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("bias_rad_s", self.bias_rad_s)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.sensors.gyro_bias_rad_s[self.axis.index()] += self.bias_rad_s;
    }
}
