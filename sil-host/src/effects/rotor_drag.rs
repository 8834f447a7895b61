//! Drag of the spinning rotors against air that passes through their plane: induced drag and blade flapping, in
//! proportion to the airspeed and in the body's xy plane, `F = -k (v_x, v_y, 0)` (Martin and Salaun, The true role of
//! accelerometer feedback in quadrotor control, ICRA 2010; Faessler, Franchi and Scaramuzza, RA-L 3(2), 2018, identify
//! 0.4 to 0.5 N s/m per kilogram of vehicle).

use super::{
    ActsOn, CatalogueEntry, Catalogued, Extension, FREE, Given, Hypothesis, Needs, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Drag of the rotors in proportion to the airspeed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorDrag {
    /// Force over airspeed k, N s/m.
    pub coefficient_ns_m: f64,
}

const COEFFICIENT: Parameter = Parameter::new("coefficient_ns_m", "N s/m", "force over airspeed", [-20.0, 20.0]);

impl Catalogued for RotorDrag {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "rotor_drag",
        origin: Origin::Plant,
        acts_on: ActsOn::Vehicle,
        parameters: &[COEFFICIENT],
        summary: "body drag in proportion to speed",
        statement: "the rotors brake the vehicle in proportion to its speed",
        equation: "F = -coefficient_ns_m (v_x, v_y, 0), v the velocity against the air in body axes",
        example: "rotor_drag:coefficient_ns_m=0.5",
        rigs: FREE,
        needs: Some(Needs::Velocity),
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { coefficient_ns_m: given.number(&COEFFICIENT)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        // per second of the vehicle's mass
        let per_s = scope.scale.mass_kg;
        let coefficient = Unknown::amplitude(COEFFICIENT.name, 1e-4 * per_s, [-10.0 * per_s, 20.0 * per_s]);
        vec![Hypothesis::new(Self::ENTRY, [coefficient], |[coefficient_ns_m]| Self { coefficient_ns_m })]
    }
}

impl Extension for RotorDrag {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("coefficient_ns_m", self.coefficient_ns_m)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.air.rotor_drag_ns_m += self.coefficient_ns_m;
    }
}
