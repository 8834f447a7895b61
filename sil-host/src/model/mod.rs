//! The vehicle as numbers: what a model file says, read once and then shared by the plant, the control
//! configuration and the diagnosis.
//!
//! A model file is TOML; `models/` holds those of the project, every number with its source. The same text is
//! how the diagnosis writes down a model that it has extended: [`VehicleModel::to_toml`] gives back what
//! [`VehicleModel::parse`] reads.

mod at_voltage;
mod bench;
mod effects;
mod keys;
mod parts;
mod read;
mod template;
mod tolerance;
mod write;

pub use crate::document::{ModelError, Position, Problem};
use crate::effects::Effect;
use crate::vehicle::propulsion::{Level, Propulsion};
pub use crate::vehicle::{Mounting, Rig};
pub use bench::{BenchAxis, BenchModel};
pub use keys::{ModelKey, keys};
pub(crate) use template::Template;
pub use tolerance::{CUT_SD, Extent, Spread, Tolerance};

/// All that is known of a vehicle and of the rig it hangs in.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleModel {
    /// What it is called in reports.
    pub name: String,
    /// Acceleration of gravity, m/s².
    pub gravity_m_s2: f64,
    /// Distance from a motor's axis to the centre, m.
    pub arm_m: f64,
    /// Command at which all four motors rest at the start: hover.
    pub base_command: f64,
    /// Principal moments of inertia of the body alone, (x, y, z), kg m².
    pub inertia_kg_m2: [f64; 3],
    /// What holds the body, or nothing.
    pub mounting: Mounting,
    /// Force by which the rotors of a free vehicle brake it over airspeed, N s/m; 0 in a rig.
    pub rotor_drag_ns_m: f64,
    /// What its core knows of that over the mass, 1/s: what it levels itself by.
    pub known_rotor_drag_1_s: f64,
    /// From command to lift.
    pub propulsion: Propulsion,
    /// The same of motors 1 to 4 where each is another, as in a vehicle that was drawn from tolerances. No file has it,
    /// and only the plant knows it: controllers and predictions of logs take `propulsion` for all four.
    pub arms: Option<Box<[Propulsion; 4]>>,
    /// What the sensors add to the truth.
    pub noise: SensorNoise,
    /// What the vehicle does beyond its nominal model.
    pub effects: Vec<Effect>,
    /// How far one such vehicle differs from the next.
    pub tolerances: Vec<Tolerance>,
}

/// Standard deviations per sample, white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// Gyro, rad/s.
    pub gyro_rad_s: f64,
    /// Accelerometer, m/s².
    pub accel_m_s2: f64,
    /// Attitude as logs report it, rad.
    pub attitude_rad: f64,
    /// Velocity as logs of free flight report it, m/s.
    pub velocity_m_s: f64,
    /// Height above ground as they report it, m.
    pub height_m: f64,
}

impl SensorNoise {
    /// Exact sensors.
    pub const NONE: SensorNoise =
        SensorNoise { gyro_rad_s: 0.0, accel_m_s2: 0.0, attitude_rad: 0.0, velocity_m_s: 0.0, height_m: 0.0 };
    /// Velocity of a model file that says nothing of it, m/s: satellite navigation's, smoothed by an inertial filter.
    pub const USUAL_VELOCITY_M_S: f64 = 0.05;
    /// Height, m: a range finder's over flat ground.
    pub const USUAL_HEIGHT_M: f64 = 0.02;
}

impl VehicleModel {
    /// Rotor drag that the core assumes where a model file says nothing of it, 1/s: the middle of what Faessler,
    /// Franchi and Scaramuzza (RA-L 3(2), 2018) identified, and that of a rig, whose core does not use it.
    pub const USUAL_ROTOR_DRAG_1_S: f64 = 0.45;

    /// Reads a model file.
    ///
    /// # Errors
    /// [`ModelError`] if the file cannot be read or anything in it is missing, unknown or impossible.
    pub fn load(path: &std::path::Path) -> Result<Self, ModelError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &file),
            Err(source) => Err(ModelError::Unreadable { file, source }),
        }
    }

    /// The project's own model of a rig, on the level of the specific device.
    pub fn nominal(rig: Rig) -> Self {
        let (text, name) = match rig {
            Rig::Gimbal => (include_str!("../../../models/f450-gimbal.toml"), "models/f450-gimbal.toml"),
            Rig::Free => (include_str!("../../../models/f450-free.toml"), "models/f450-free.toml"),
        };
        Self::parse(text, name).expect("a test reads every file under models/")
    }

    /// The same without windings, whose currents are costly to follow.
    #[cfg(test)]
    pub(crate) fn generic(rig: Rig) -> Self {
        let (text, name) = match rig {
            Rig::Gimbal => (include_str!("../../../models/generic-gimbal.toml"), "models/generic-gimbal.toml"),
            Rig::Free => (include_str!("../../../models/generic-free.toml"), "models/generic-free.toml"),
        };
        Self::parse(text, name).expect("a test reads every file under models/")
    }

    /// The same free vehicle with another rotors' drag over its mass, 1/s, of which its core does not know. One in a
    /// rig stays as it is.
    #[must_use]
    pub fn with_rotor_drag(mut self, drag_1_s: f64) -> Self {
        if let Mounting::Free { mass_kg } = self.mounting {
            self.rotor_drag_ns_m = drag_1_s * mass_kg;
        }
        self
    }

    /// The rig that it hangs in.
    pub fn rig(&self) -> Rig {
        match self.mounting {
            Mounting::Gimbal { .. } => Rig::Gimbal,
            Mounting::Free { .. } => Rig::Free,
        }
    }

    /// How much detail its propulsion has.
    pub fn level(&self) -> Level {
        self.propulsion.level()
    }
}

#[cfg(test)]
mod tests;
