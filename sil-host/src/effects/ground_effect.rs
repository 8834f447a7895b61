//! More lift close to the ground, by the image of each rotor below it: `T / T_inf = 1 / (1 - (R / 4z)^2)` (Cheeseman
//! and Bennett, The effect of the ground on a helicopter rotor in forward flight, ARC R&M 3021, 1955). The formula ends
//! where the rotor would touch; below half a radius the factor stays at its value there, 4/3.

use super::{
    ActsOn, CatalogueEntry, Catalogued, Extension, FREE, Given, Hypothesis, Needs, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// More lift close to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundEffect {
    /// Height of the rotors above ground at the start, m.
    pub height_m: f64,
    /// Radius of a rotor, m.
    pub rotor_radius_m: f64,
}

const HEIGHT: Parameter =
    Parameter::new("height_m", "m", "height of the rotors above ground at the start", [0.0, 100.0]);
const RADIUS: Parameter = Parameter::new("rotor_radius_m", "m", "radius of a rotor", [0.01, 1.0]).usual(0.127);

impl Catalogued for GroundEffect {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "ground_effect",
        origin: Origin::Environment,
        acts_on: ActsOn::Vehicle,
        parameters: &[HEIGHT, RADIUS],
        summary: "more lift close to the ground",
        statement: "the ground below lifts the vehicle",
        equation: "all lifts times 1 / (1 - (rotor_radius_m / 4z)^2), z the height of the rotors above ground, at \
                   least half a radius",
        example: "ground_effect:height_m=0.2,rotor_radius_m=0.127",
        rigs: FREE,
        needs: Some(Needs::Height),
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { height_m: given.number(&HEIGHT)?, rotor_radius_m: given.number(&RADIUS)? })
    }

    /// Fitted as the square of the radius with which the rotors feel the ground, in which the lift is linear.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let arm_m2 = scope.scale.arm_m * scope.scale.arm_m;
        let squared = Unknown::amplitude("radius_squared_m2", 2e-5 * arm_m2, [0.0, 20.0 * arm_m2]);
        let above = |height_m| {
            Hypothesis::new(Self::ENTRY, [squared], move |[squared_m2]| Self {
                height_m,
                rotor_radius_m: squared_m2.max(0.0).sqrt(),
            })
            .reporting(&[RADIUS.name, HEIGHT.name])
        };
        scope.height_m.map(above).into_iter().collect()
    }
}

impl Extension for GroundEffect {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("height_m", self.height_m), ("rotor_radius_m", self.rotor_radius_m)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.air.ground_radius_squared_m2 += self.rotor_radius_m * self.rotor_radius_m;
        vehicle.air.start_height_m = vehicle.air.start_height_m.or(Some(self.height_m));
    }
}
