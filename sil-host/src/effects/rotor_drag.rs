//! Drag of the spinning rotors against air that passes through their plane: induced drag and blade flapping, in proportion
//! to the airspeed and in the body's xy plane, `F = -k (v_x, v_y, 0)` (Martin and Salaun, The true role of
//! accelerometer feedback in quadrotor control, ICRA 2010; Faessler, Franchi and Scaramuzza, RA-L 3(2), 2018, identify 0.4
//! to 0.5 N s/m per kilogram of vehicle).

use super::{CatalogueEntry, Catalogued, Extension, FreeMotion, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

/// Drag of the rotors in proportion to the airspeed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorDrag {
    /// Force over airspeed k, N s/m.
    pub coefficient_ns_m: f64,
}

impl Catalogued for RotorDrag {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "rotor_drag",
        origin: Origin::Plant,
        summary: "body drag in proportion to speed",
        example: "rotor_drag:coefficient_ns_m=0.5",
        rigs: &[Rig::Free],
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            coefficient_ns_m: section
                .number("coefficient_ns_m", admissible(-20.0, 20.0, "a force over a speed in N s/m"))?,
        })
    }
}

impl Extension for RotorDrag {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("coefficient_ns_m", self.coefficient_ns_m)]
    }

    fn body_force_n(&self, motion: &FreeMotion) -> [f64; 3] {
        let [forward_m_s, right_m_s, _] = motion.air_velocity_body_m_s;
        [-self.coefficient_ns_m * forward_m_s, -self.coefficient_ns_m * right_m_s, 0.0]
    }
}
