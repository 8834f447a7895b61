//! The angular momentum of the spinning rotors: what a motor needs to speed its rotor up turns the body the other way,
//! and a body that rolls or pitches turns the axis of the rotors' spin with it.
//!
//! With `S = -w1 - w2 + w3 + w4` (motors 3 and 4 turn clockwise from above, about +z of the body) the rotors have the
//! angular momentum `h = J_r S` about z, beside their share of the body's inertia. Of a vehicle free of other torques
//! `I w + h z` is constant in the world, so that in the body's axes
//!
//! `I w' = ... - w x I w + (-q h, p h, -h')`
//!
//! Both parts are one conservation of momentum with one parameter, and therefore one effect. A rotor that speeds up
//! turns the body in the direction of its reaction torque, which follows later, with the square of the speed: a yaw
//! command has a lead. On the gimbal the same torques act, so that (Lagrange, `T = ... + h r` with `r = -theta' sin
//! phi`) `Q_phi = -h theta' cos phi` and `Q_theta = h' sin phi + h phi' cos phi`.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

/// Rotors whose angular momentum acts on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorInertia {
    /// Inertia of one rotor about its axis, kg m²: the motor's bell with the propeller.
    pub inertia_kg_m2: f64,
}

const INERTIA: Parameter =
    Parameter::new("inertia_kg_m2", "kg m^2", "inertia of one rotor: motor's bell and propeller", [0.0, 1e-2]);

/// The four rotors are a part of the body: more than its whole inertia about z they cannot have.
fn limit_kg_m2([_, _, izz_kg_m2]: [f64; 3]) -> f64 {
    0.25 * izz_kg_m2
}

impl Catalogued for RotorInertia {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "rotor_inertia",
        origin: Origin::Plant,
        acts_on: ActsOn::Vehicle,
        parameters: &[INERTIA],
        summary: "angular momentum of the rotors: speeding up, and gyroscopic",
        statement: "the rotors' angular momentum turns the vehicle",
        equation: "h = inertia_kg_m2 (w3 + w4 - w1 - w2): free flight, torque (-q h, p h, -h'); gimbal, Q_phi = -h \
                   theta' cos phi, Q_theta = h' sin phi + h phi' cos phi",
        example: "rotor_inertia:inertia_kg_m2=0.0001",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { inertia_kg_m2: given.number(&INERTIA)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let limit_kg_m2 = 0.8 * limit_kg_m2(scope.scale.inertia_kg_m2);
        let inertia = Unknown::of(&INERTIA, 1e-4 * limit_kg_m2).within(0.0, limit_kg_m2);
        let of_vehicle = || Hypothesis::new(Self::ENTRY, [inertia], |[inertia_kg_m2]| Self { inertia_kg_m2 });
        scope.has_rotors.then(of_vehicle).into_iter().collect()
    }
}

impl Extension for RotorInertia {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("inertia_kg_m2", self.inertia_kg_m2)]
    }

    fn impossible_for(&self, inertia_kg_m2: [f64; 3]) -> Option<String> {
        let limit_kg_m2 = limit_kg_m2(inertia_kg_m2);
        (self.inertia_kg_m2 >= limit_kg_m2).then(|| {
            format!(
                "no rotor has the inertia {:?} kg m^2: expected less than a quarter of izz, {limit_kg_m2:.3e}",
                self.inertia_kg_m2
            )
        })
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }
}

impl Moment for RotorInertia {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let momentum = self.inertia_kg_m2 * motion.spin.speed_rad_s;
        let momentum_change = self.inertia_kg_m2 * motion.spin.acceleration_rad_s2;
        let [p, q, _] = motion.rate_body_rad_s();
        let on_axes = motion.moment_of([-q * momentum, p * momentum, -momentum_change]);
        (0..3).for_each(|axis| moment[axis] += on_axes[axis]);
    }
}
