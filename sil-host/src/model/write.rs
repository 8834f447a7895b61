//! From [`VehicleModel`] back to TOML text, to the last bit: every number is written so that reading gives it back.

use super::{SensorNoise, Tolerance, VehicleModel};
use crate::document::Table;
use crate::vehicle::Mounting;

impl VehicleModel {
    /// The model as text that [`VehicleModel::parse`] reads back unchanged.
    pub fn to_toml(&self) -> String {
        let mut text = Table::default();
        text.string("name", &self.name);
        text.string("rig", self.rig().name());
        text.string("level", self.level().name());
        text.number("gravity_m_s2", self.gravity_m_s2);
        text.number("arm_m", self.arm_m);
        text.number("base_command", self.base_command);
        text.header("[body]");
        let [ixx, iyy, izz] = self.inertia_kg_m2;
        text.number("ixx_kg_m2", ixx);
        text.number("iyy_kg_m2", iyy);
        text.number("izz_kg_m2", izz);
        match self.mounting {
            Mounting::Free { mass_kg } => {
                text.number("mass_kg", mass_kg);
                if self.rotor_drag_ns_m != 0.0 {
                    text.number("rotor_drag_ns_m", self.rotor_drag_ns_m);
                }
                if self.known_rotor_drag_1_s != Self::USUAL_ROTOR_DRAG_1_S {
                    text.number("known_rotor_drag_1_s", self.known_rotor_drag_1_s);
                }
            }
            Mounting::Gimbal { ring_inertia_kg_m2 } => {
                text.header("[ring]");
                text.number("inertia_kg_m2", ring_inertia_kg_m2);
            }
        }
        self.propulsion.write(&mut text);
        text.header("[noise]");
        text.number("gyro_rad_s", self.noise.gyro_rad_s);
        text.number("accel_m_s2", self.noise.accel_m_s2);
        text.number("attitude_rad", self.noise.attitude_rad);
        for (key, value, usual) in [
            ("velocity_m_s", self.noise.velocity_m_s, SensorNoise::USUAL_VELOCITY_M_S),
            ("height_m", self.noise.height_m, SensorNoise::USUAL_HEIGHT_M),
        ] {
            if value != usual {
                text.number(key, value);
            }
        }
        for effect in &self.effects {
            effect.write(&mut text);
        }
        Tolerance::write_all(&self.tolerances, &mut text);
        text.into_text()
    }
}
