//! A gyro whose scale is not the data sheet's: reported = scale * true.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::Changes;

/// A wrong scale of the gyro.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroScale {
    /// The axis it acts on.
    pub axis: Axis,
    /// Reported rate over true.
    pub scale: f64,
}

const SCALE: Parameter = Parameter::new("scale", "", "reported rate over true", [0.05, 5.0]).nominal(1.0);

impl Catalogued for GyroScale {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "gyro_scale",
        origin: Origin::Sensor,
        acts_on: ActsOn::AnyAxis,
        parameters: &[SCALE],
        summary: "reported rate over true",
        statement: "the gyro's scale is off",
        equation: "reported rate = scale * true rate + bias, behind the misalignment",
        example: "gyro_scale:axis=roll,scale=1.05",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, scale: given.number(&SCALE)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let scale = Unknown::of(&SCALE, 1e-4).within(0.2, 5.0);
        let of_axis = |axis| Hypothesis::new(Self::ENTRY, [scale], move |[scale]| Self { axis, scale });
        scope.gyro_axes().map(of_axis).collect()
    }
}

impl Extension for GyroScale {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.sensors.gyro_scale[self.axis.index()] *= self.scale;
    }
}
