//! A curve from command to thrust that bends otherwise than the model's. Flight controllers know the share of the
//! square in it as the thrust exponent.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Another bend of the curve from command to thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustCurve {
    /// Share of the square in the curve; negative where it bends the other way.
    pub expo: f64,
    /// The command at which thrust stays as it is, 0..1.
    pub fixed_at: f64,
}

const EXPO: Parameter = Parameter::new("expo", "", "share of the square, negative bends the other way", [-1.0, 1.0]);
const FIXED_AT: Parameter =
    Parameter::new("fixed_at", "", "command at which thrust stays as it is", [0.05, 1.0]).nominal(1.0).usual(1.0);

impl ThrustCurve {
    /// The curve of commands that are weaker by this factor, on a slope that is so much less; `None` where it is beyond
    /// what a curve may be. `lower` times the command does what the command did.
    pub(crate) fn of_weaker(&self, lower: f64) -> Option<Self> {
        let linear = (1.0 - self.expo) * lower;
        let weaker = Self { expo: self.expo / (linear + self.expo), fixed_at: self.fixed_at * lower };
        let is_in = |parameter: &Parameter, value: f64| (parameter.min..=parameter.max).contains(&value);
        (is_in(&EXPO, weaker.expo) && is_in(&FIXED_AT, weaker.fixed_at)).then_some(weaker)
    }
}

impl Catalogued for ThrustCurve {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "thrust_curve",
        origin: Origin::Actuator,
        acts_on: ActsOn::Vehicle,
        parameters: &[EXPO, FIXED_AT],
        summary: "another bend of thrust over command",
        statement: "thrust over command bends otherwise than the model's",
        equation: "command u acts as u (1 - expo + expo u) / (1 - expo + expo fixed_at), at most 1, behind the lag and \
                   before the ESC's curve",
        example: "thrust_curve:expo=0.3,fixed_at=0.5",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { expo: given.number(&EXPO)?, fixed_at: given.number(&FIXED_AT)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let expo = Unknown::of(&EXPO, 1e-4);
        // a change of all thrust alike has a name of its own: what differs is how thrust grows about hover
        let fixed_at = scope.base_command.unwrap_or(FIXED_AT.nominal);
        // under a collective that hardly changes, as on the testbed, another bend is another lift
        let is_seen = scope.pushed || scope.has_motors && scope.collective_varies && !scope.is_vehicle;
        let of_vehicle = || Hypothesis::new(Self::ENTRY, [expo], move |[expo]| Self { expo, fixed_at });
        is_seen.then(of_vehicle).into_iter().collect()
    }
}

impl Extension for ThrustCurve {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("expo", self.expo), ("fixed_at", self.fixed_at)]
    }

    fn change(&self, vehicle: &mut Changes) {
        let fixed = 1.0 - self.expo + self.expo * self.fixed_at;
        vehicle.chain.path.bend[0] += (1.0 - self.expo) / fixed - 1.0;
        vehicle.chain.path.bend[1] += self.expo / fixed;
    }
}
