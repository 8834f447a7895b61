//! An off-diagonal entry P = I_xy = -integral(xy dm) of the inertia tensor: a battery mounted askew.
//!
//! Kinetic energy gains `P p q`. On the gimbal p = phi', q = theta' cos phi, so Lagrange's equations become
//! - `I_xx phi'' + P cos phi theta'' = 1/2 J' theta'^2 + Q_phi`
//! - `P cos phi phi'' + J theta'' = -J' phi' theta' + P sin phi phi'^2 + Q_theta`
//!
//! In free flight Euler's equations hold with the whole tensor.

use super::{ANY_RIG, BodyChange, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// Inertia that couples roll and pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaCoupling {
    /// Entry I_xy of the inertia tensor, kg m².
    pub product_kg_m2: f64,
}

impl Catalogued for InertiaCoupling {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "inertia_coupling",
        origin: Origin::Plant,
        summary: "off-diagonal inertia between roll and pitch",
        example: "inertia_coupling:product_kg_m2=0.002",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            product_kg_m2: section
                .number("product_kg_m2", admissible(-10.0, 10.0, "a product of inertia in kg m^2"))?,
        })
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

    fn change_body(&self, change: &mut BodyChange) {
        change.product_xy_kg_m2 += self.product_kg_m2;
    }
}
