//! Steady wind. The airframe's drag goes with the square of the airspeed, `F = -1/2 rho A |v| v` with v the velocity against
//! the air and A its drag area (drag coefficient times area); rotor drag, where there is some, feels the same air.
//! Density: the standard atmosphere at sea level (ISO 2533).

use super::{CatalogueEntry, Catalogued, Extension, FreeMotion, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

const AIR_DENSITY_KG_M3: f64 = 1.225;

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

impl Catalogued for Wind {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "wind",
        origin: Origin::Environment,
        summary: "steady wind on the airframe",
        example: "wind:north_m_s=3,east_m_s=-1,drag_area_m2=0.02",
        rigs: &[Rig::Free],
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            north_m_s: section.optional_number("north_m_s", admissible(-50.0, 50.0, "a speed in m/s"))?.unwrap_or(0.0),
            east_m_s: section.optional_number("east_m_s", admissible(-50.0, 50.0, "a speed in m/s"))?.unwrap_or(0.0),
            drag_area_m2: section
                .optional_number("drag_area_m2", admissible(0.0, 2.0, "a drag area in m^2"))?
                .unwrap_or(0.02),
        })
    }
}

impl Extension for Wind {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("north_m_s", self.north_m_s), ("east_m_s", self.east_m_s), ("drag_area_m2", self.drag_area_m2)]
    }

    fn body_force_n(&self, motion: &FreeMotion) -> [f64; 3] {
        let velocity = motion.air_velocity_body_m_s;
        let speed_m_s = velocity.iter().map(|component| component * component).sum::<f64>().sqrt();
        velocity.map(|component| -0.5 * AIR_DENSITY_KG_M3 * self.drag_area_m2 * speed_m_s * component)
    }

    fn wind_ned_m_s(&self) -> [f64; 3] {
        [self.north_m_s, self.east_m_s, 0.0]
    }
}
