//! Steady wind. The airframe's drag goes with the square of the airspeed, `F = -1/2 rho A |v| v` with v the velocity
//! against the air and A its drag area (drag coefficient times area); rotor drag, where there is some, feels the same
//! air. Density: the standard atmosphere at sea level (ISO 2533).

use super::{
    ActsOn, CatalogueEntry, Catalogued, Extension, FREE, Given, Hypothesis, Needs, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Moving air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Velocity of the air to the north, m/s.
    pub north_m_s: f64,
    /// Velocity of the air to the east, m/s.
    pub east_m_s: f64,
    /// Drag coefficient times area, m²; our own estimate for an F450: a disc of 0.15 m.
    pub drag_area_m2: f64,
}

const NORTH: Parameter =
    Parameter::new("north_m_s", "m/s", "velocity of the air to the north", [-50.0, 50.0]).usual(0.0);
const EAST: Parameter = Parameter::new("east_m_s", "m/s", "velocity of the air to the east", [-50.0, 50.0]).usual(0.0);
const DRAG_AREA: Parameter =
    Parameter::new("drag_area_m2", "m^2", "drag coefficient times area of the airframe", [0.0, 2.0]).usual(0.02);

impl Catalogued for Wind {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "wind",
        origin: Origin::Environment,
        acts_on: ActsOn::Vehicle,
        parameters: &[NORTH, EAST, DRAG_AREA],
        summary: "steady wind on the airframe",
        statement: "a steady wind drags the vehicle along",
        equation: "F = -1/2 rho drag_area_m2 |v| v, v the velocity against the air, rho = 1.225 kg/m^3; rotor drag \
                   feels the same air",
        example: "wind:north_m_s=3,east_m_s=-1,drag_area_m2=0.02",
        rigs: FREE,
        needs: Some(Needs::Velocity),
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self {
            north_m_s: given.number(&NORTH)?,
            east_m_s: given.number(&EAST)?,
            drag_area_m2: given.number(&DRAG_AREA)?,
        })
    }

    /// Fitted from air that stands still or comes from one side, and a drag area like that of a disc between the
    /// motors: in still air, or without an area, one of them would show no trace.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let arm_m2 = scope.scale.arm_m * scope.scale.arm_m;
        let drag_area = Unknown::of(&DRAG_AREA, 2e-4 * arm_m2).within(0.0, 40.0 * arm_m2);
        let unknowns = [Unknown::of(&NORTH, 1e-3), Unknown::of(&EAST, 1e-3), drag_area];
        let of_log = Hypothesis::new(Self::ENTRY, unknowns, |[north_m_s, east_m_s, drag_area_m2]| Self {
            north_m_s,
            east_m_s,
            drag_area_m2,
        });
        const AIR_M_S: [[f64; 2]; 5] = [[0.5, 0.5], [4.0, 0.0], [-4.0, 0.0], [0.0, 4.0], [0.0, -4.0]];
        vec![of_log.starting(move |_| AIR_M_S.map(|[north, east]| vec![north, east, 0.4 * arm_m2]).into())]
    }
}

impl Extension for Wind {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("north_m_s", self.north_m_s), ("east_m_s", self.east_m_s), ("drag_area_m2", self.drag_area_m2)]
    }

    fn change(&self, vehicle: &mut Changes) {
        let [north_m_s, east_m_s] = &mut vehicle.air.wind_m_s;
        (*north_m_s, *east_m_s) = (*north_m_s + self.north_m_s, *east_m_s + self.east_m_s);
        vehicle.air.drag_area_m2 += self.drag_area_m2;
    }
}
