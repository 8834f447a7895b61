//! A mass that differs from the model's: true = scale * nominal. Free flight only; on the gimbal the pivot carries it.

use super::{
    ActsOn, CatalogueEntry, Catalogued, Extension, FREE, Given, Hypothesis, Needs, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// A wrong mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassError {
    /// True mass over nominal.
    pub scale: f64,
}

const SCALE: Parameter = Parameter::new("scale", "", "true mass over nominal", [0.05, 20.0]).nominal(1.0);

impl Catalogued for MassError {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "mass_error",
        origin: Origin::Plant,
        acts_on: ActsOn::Vehicle,
        parameters: &[SCALE],
        summary: "true mass = scale * nominal",
        statement: "the mass is not the nominal one",
        equation: "true mass = scale * nominal, inertia unchanged",
        example: "mass_error:scale=1.1",
        rigs: FREE,
        needs: Some(Needs::Push),
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { scale: given.number(&SCALE)? })
    }

    fn hypotheses(_scope: &Scope) -> Vec<Hypothesis> {
        let scale = Unknown::of(&SCALE, 1e-4).within(0.1, 10.0);
        vec![Hypothesis::new(Self::ENTRY, [scale], |[scale]| Self { scale })]
    }
}

impl Extension for MassError {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.body.mass_scale *= self.scale;
    }
}
