//! A pure delay from command to motor. The plant lets each command take effect at its own time, between the
//! integrator's steps. Several delays add up.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Commands that arrive late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuationDelay {
    /// Delay, s.
    pub delay_s: f64,
}

const DELAY: Parameter = Parameter::new("delay_s", "s", "delay from command to motor", [0.0, 1.0]);

impl Catalogued for ActuationDelay {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "actuation_delay",
        origin: Origin::Actuator,
        acts_on: ActsOn::Vehicle,
        parameters: &[DELAY],
        summary: "pure delay from command to motor",
        statement: "commands reach the motors with a delay",
        equation: "a command given at t acts at t + delay_s",
        example: "actuation_delay:delay_s=0.01",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { delay_s: given.number(&DELAY)? })
    }

    fn hypotheses(_scope: &Scope) -> Vec<Hypothesis> {
        let delay = Unknown::of(&DELAY, 1e-5).within(0.0, 0.3);
        vec![Hypothesis::new(Self::ENTRY, [delay], |[delay_s]| Self { delay_s }).starting(|_| vec![vec![0.005]])]
    }
}

impl Extension for ActuationDelay {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("delay_s", self.delay_s)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.chain.path.delay_s += self.delay_s;
    }
}
