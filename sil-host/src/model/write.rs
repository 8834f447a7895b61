//! From [`VehicleModel`] back to TOML text, to the last bit: every number is written so that reading gives it back.

use std::fmt::Write;

use super::document::{Section, Source};
use super::{ModelError, Mounting, Problem, SensorNoise, VehicleModel};

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
            Mounting::Free { mass_kg } => text.number("mass_kg", mass_kg),
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
        text.0
    }
}

/// TOML text in the making.
#[derive(Debug, Default)]
pub(crate) struct Table(String);

impl Table {
    pub(crate) fn header(&mut self, header: &str) {
        let _ = writeln!(self.0, "\n{header}");
    }

    /// Rust's shortest form that reads back to the same number is valid TOML as long as the number is finite.
    pub(crate) fn number(&mut self, key: &str, value: f64) {
        let _ = writeln!(self.0, "{key} = {value:?}");
    }

    pub(crate) fn string(&mut self, key: &str, value: &str) {
        let _ = writeln!(self.0, "{key} = {}", toml::Value::from(value));
    }

    /// A number where `value` is one that is finite, else text.
    pub(crate) fn number_or_string(&mut self, key: &str, value: &str) {
        match value.parse() {
            Ok(number) if f64::is_finite(number) => self.number(key, number),
            _ => self.string(key, value),
        }
    }

    /// Reads the text as one table; an error has no place, since nobody wrote this text.
    pub(crate) fn read_back<T>(&self, read: impl FnOnce(&Section<'_>) -> Result<T, ModelError>) -> Result<T, Problem> {
        let source = Source { name: "", text: &self.0 };
        let document = source.parse();
        let result = document.and_then(|document| read(&Section::root(source, &document)));
        result.map_err(|error| match error {
            ModelError::Invalid { problem, .. } => problem,
            ModelError::Unreadable { source, .. } => Problem::Syntax(source.to_string()),
        })
    }
}
