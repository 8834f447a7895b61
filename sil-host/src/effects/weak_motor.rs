//! One motor, or its propeller, weaker than the others: its lift and reaction torque are scaled, its speed is not.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// One motor weaker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakMotor {
    /// The motor's number, 1 to 4.
    pub motor: u8,
    /// True lift over nominal.
    pub scale: f64,
}

const SCALE: Parameter = Parameter::new("scale", "", "true lift over nominal", [0.0, 5.0]).nominal(1.0);

impl Catalogued for WeakMotor {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "weak_motor",
        origin: Origin::Actuator,
        acts_on: ActsOn::Motor,
        parameters: &[SCALE],
        summary: "lift of one motor (or its propeller)",
        statement: "one motor lifts more or less than the others",
        equation: "lift and reaction torque of that motor times scale, its speed unchanged",
        example: "weak_motor:motor=3,scale=0.9",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { motor: given.motor()?, scale: given.number(&SCALE)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let scale = Unknown::of(&SCALE, 1e-4).within(0.0, 3.0);
        let of_motor = |motor| Hypothesis::new(Self::ENTRY, [scale], move |[scale]| Self { motor, scale });
        (1..=4).filter(|_| scope.has_motors).map(of_motor).collect()
    }
}

impl Extension for WeakMotor {
    fn motor(&self) -> Option<u8> {
        Some(self.motor)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change(&self, vehicle: &mut Changes) {
        let factors = vehicle.chain.lift.scale.iter_mut().zip(1..);
        factors.filter(|(_, motor)| *motor == self.motor).for_each(|(factor, _)| *factor *= self.scale);
    }
}
