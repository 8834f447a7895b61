//! The moment of air that passes through the rotors' plane: the advancing blades lift more, so that the discs flap
//! back, and the rotors' drag attacks above the centre of gravity. Both turn the vehicle away from where it flies to,
//! in proportion to its airspeed: the derivatives M_u and L_v of a helicopter, its speed stability (Bramwell,
//! Helicopter Dynamics, 2nd edition 2001, chapter 5; of quadrotors Pounds, Mahony and Corke, Control Engineering
//! Practice 18(7), 2010).

use super::{
    ActsOn, CatalogueEntry, Catalogued, Extension, FREE, Given, Hypothesis, Needs, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// A moment in proportion to the airspeed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedStability {
    /// Moment over airspeed, N s; positive lifts the side that leads.
    pub coefficient_ns: f64,
}

const COEFFICIENT: Parameter = Parameter::new(
    "coefficient_ns",
    "N s",
    "moment over airspeed, lifting the leading side where positive",
    [-5.0, 5.0],
);

/// Moment over airspeed and inertia at most, rad/s² per m/s: five times that of a vehicle of 27 g, and the smaller the
/// vehicle, the more.
const MOST_PER_INERTIA: f64 = 50.0;

impl Catalogued for SpeedStability {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "speed_stability",
        origin: Origin::Plant,
        acts_on: ActsOn::Vehicle,
        parameters: &[COEFFICIENT],
        summary: "a moment in proportion to airspeed, against the flight",
        statement: "the air across its rotors turns the vehicle away from where it flies to",
        equation: "tau = coefficient_ns (-v_y, v_x, 0), v the velocity against the air in body axes",
        example: "speed_stability:coefficient_ns=0.01",
        rigs: FREE,
        needs: Some(Needs::Airspeed),
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { coefficient_ns: given.number(&COEFFICIENT)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        if scope.tilting_axes().next().is_none() {
            return Vec::new();
        }
        let [roll, pitch, _] = scope.scale.inertia_kg_m2;
        let mean = 0.5 * (roll + pitch);
        let range = [-MOST_PER_INERTIA * mean, MOST_PER_INERTIA * mean];
        let coefficient = Unknown::amplitude(COEFFICIENT.name, 1e-3 * mean, range);
        vec![Hypothesis::new(Self::ENTRY, [coefficient], |[coefficient_ns]| Self { coefficient_ns })]
    }
}

impl Extension for SpeedStability {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("coefficient_ns", self.coefficient_ns)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.air.speed_stability_ns += self.coefficient_ns;
    }
}
