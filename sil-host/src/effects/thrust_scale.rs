//! All four motors stronger or weaker than the model's: lift and reaction torque are scaled, speed is not.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// All motors stronger or weaker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustScale {
    /// True lift over nominal.
    pub scale: f64,
}

const SCALE: Parameter = Parameter::new("scale", "", "true lift over nominal", [0.0, 5.0]).nominal(1.0);

impl Catalogued for ThrustScale {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "thrust_scale",
        origin: Origin::Actuator,
        acts_on: ActsOn::Vehicle,
        parameters: &[SCALE],
        summary: "lift of all four motors",
        statement: "all motors lift more or less than in the model",
        equation: "lift and reaction torque of all four motors times scale, their speeds unchanged",
        example: "thrust_scale:scale=0.9",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { scale: given.number(&SCALE)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let scale = Unknown::of(&SCALE, 1e-4).within(0.1, 5.0);
        let of_vehicle = || Hypothesis::new(Self::ENTRY, [scale], |[scale]| Self { scale });
        scope.is_vehicle.then(of_vehicle).into_iter().collect()
    }
}

impl Extension for ThrustScale {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change(&self, vehicle: &mut Changes) {
        for factor in &mut vehicle.chain.lift.scale {
            *factor *= self.scale;
        }
    }
}
