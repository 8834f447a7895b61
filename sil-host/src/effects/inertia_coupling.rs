//! An off-diagonal entry P = I_xy = -integral(xy dm) of the inertia tensor: a battery mounted askew.
//!
//! Kinetic energy gains `P p q`. On the gimbal p = phi', q = theta' cos phi, so Lagrange's equations become
//! - `I_xx phi'' + P cos phi theta'' = 1/2 J' theta'^2 + Q_phi`
//! - `P cos phi phi'' + J theta'' = -J' phi' theta' + P sin phi phi'^2 + Q_theta`
//!
//! In free flight Euler's equations hold with the whole tensor.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Inertia that couples roll and pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaCoupling {
    /// Entry I_xy of the inertia tensor, kg m².
    pub product_kg_m2: f64,
}

const PRODUCT: Parameter =
    Parameter::new("product_kg_m2", "kg m^2", "entry I_xy of the inertia tensor, a product of inertia", [-10.0, 10.0]);

impl Catalogued for InertiaCoupling {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "inertia_coupling",
        origin: Origin::Plant,
        acts_on: ActsOn::Vehicle,
        parameters: &[PRODUCT],
        summary: "off-diagonal inertia between roll and pitch",
        statement: "roll and pitch are coupled by an off-diagonal inertia",
        equation: "kinetic energy + P p q, P = I_xy = -integral(x y dm): on the gimbal the mass matrix has P cos \
                   phi off its diagonal, and Q_theta = P sin phi phi'^2; in free flight Euler's equations hold \
                   with the whole tensor",
        example: "inertia_coupling:product_kg_m2=0.002",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { product_kg_m2: given.number(&PRODUCT)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        // the body's limit is less than this, for pitch has the ring's inertia too
        let [roll_kg_m2, pitch_kg_m2, _] = scope.scale.inertia_kg_m2;
        let limit_kg_m2 = (roll_kg_m2 * pitch_kg_m2).sqrt();
        let product = Unknown::of(&PRODUCT, 1e-4 * limit_kg_m2).within(-0.8 * limit_kg_m2, 0.8 * limit_kg_m2);
        let of_vehicle = || Hypothesis::new(Self::ENTRY, [product], |[product_kg_m2]| Self { product_kg_m2 });
        scope.is_vehicle.then(of_vehicle).into_iter().collect()
    }
}

impl Extension for InertiaCoupling {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("product_kg_m2", self.product_kg_m2)]
    }

    fn impossible_for(&self, [ixx, iyy, _]: [f64; 3]) -> Option<String> {
        let limit = (ixx * iyy).sqrt();
        (self.product_kg_m2.abs() >= limit).then(|| {
            format!(
                "no body has the product of inertia {:?} kg m^2: expected less than sqrt(ixx iyy), {limit:.6}",
                self.product_kg_m2
            )
        })
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.body.product_xy_kg_m2 += self.product_kg_m2;
    }
}
