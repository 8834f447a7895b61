//! More lift close to the ground, by the image of each rotor below it: `T / T_inf = 1 / (1 - (R / 4z)^2)` (Cheeseman and
//! Bennett, The effect of the ground on a helicopter rotor in forward flight, ARC R&M 3021, 1955). The formula ends where
//! the rotor would touch; below half a radius the factor stays at its value there, 4/3.

use super::{CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// More lift close to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundEffect {
    /// Height of the rotors above ground at the start, m.
    pub height_m: f64,
    /// Radius of a rotor, m.
    pub rotor_radius_m: f64,
}

impl Catalogued for GroundEffect {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "ground_effect",
        origin: Origin::Environment,
        summary: "more lift close to the ground",
        example: "ground_effect:height_m=0.2,rotor_radius_m=0.127",
        rigs: &[Rig::Free],
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            height_m: section.number("height_m", admissible(0.0, 100.0, "a height in m"))?,
            rotor_radius_m: section
                .optional_number("rotor_radius_m", admissible(0.01, 1.0, "a radius in m"))?
                .unwrap_or(0.127),
        })
    }
}

impl Extension for GroundEffect {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("height_m", self.height_m), ("rotor_radius_m", self.rotor_radius_m)]
    }

    fn start_height_m(&self) -> Option<f64> {
        Some(self.height_m)
    }

    fn lift_factor(&self, down_m: f64) -> f64 {
        let height_m = (self.height_m - down_m).max(0.5 * self.rotor_radius_m);
        let ratio = 0.25 * self.rotor_radius_m / height_m;
        1.0 / (1.0 - ratio * ratio)
    }
}
