//! From TOML text to [`VehicleModel`].
//!
//! The admissible ranges span everything from a palm-sized quadrotor to one of 10 kg. They are there to catch
//! slips of the unit (millimetres, degrees, gram square centimetres), not to judge a design.

use super::{SensorNoise, Tolerance, VehicleModel};
use crate::document::{ModelError, Section, Source, admissible};
use crate::effects::Effect;
use crate::vehicle::propulsion::Propulsion;
use crate::vehicle::{Mounting, Rig};

impl VehicleModel {
    /// Reads a model from its text; `name` stands for the file in messages.
    ///
    /// # Errors
    /// [`ModelError::Invalid`] for the first thing that is missing, unknown or impossible.
    pub fn parse(text: &str, name: &str) -> Result<Self, ModelError> {
        let source = Source { name, text };
        let document = source.parse()?;
        Self::read(&Section::root(source, &document))
    }

    pub(super) fn read(root: &Section<'_>) -> Result<Self, ModelError> {
        let name = root.text("name", "what the vehicle is called, as text")?;
        let rig = root.choice("rig", &Rig::NAMES)?;
        let propulsion = Propulsion::read(root)?;
        let gravity = admissible(0.0, 30.0, "the acceleration of gravity in m/s^2");
        let arm = admissible(0.01, 2.0, "the distance motor to centre in metres");
        let base = admissible(0.0, 1.0, "the hover command as a fraction of full command");
        let gravity_m_s2 = root.number("gravity_m_s2", gravity)?;
        let arm_m = root.number("arm_m", arm)?;
        let base_command = root.number("base_command", base)?;
        let (inertia_kg_m2, mounting, [rotor_drag_ns_m, known_rotor_drag_1_s]) = read_body(root, rig)?;
        let noise = read_noise(&root.section("noise")?)?;
        let effects = root
            .sections("effect")?
            .iter()
            .map(|section| Effect::read(section, rig, inertia_kg_m2))
            .collect::<Result<_, _>>()?;
        let tolerances = Tolerance::read_all(root)?;
        root.finish()?;
        Ok(Self {
            name: name.to_owned(),
            gravity_m_s2,
            arm_m,
            base_command,
            inertia_kg_m2,
            mounting,
            rotor_drag_ns_m,
            known_rotor_drag_1_s,
            propulsion,
            arms: None,
            noise,
            effects,
            tolerances,
        })
    }
}

/// Inertia, mounting, and of the rotors' drag what the vehicle has and what its core knows.
fn read_body(root: &Section<'_>, rig: Rig) -> Result<([f64; 3], Mounting, [f64; 2]), ModelError> {
    let inertia = admissible(1e-7, 10.0, "a moment of inertia in kg m^2");
    let body = root.section("body")?;
    let inertia_kg_m2 =
        [body.number("ixx_kg_m2", inertia)?, body.number("iyy_kg_m2", inertia)?, body.number("izz_kg_m2", inertia)?];
    let mut drag = [0.0, VehicleModel::USUAL_ROTOR_DRAG_1_S];
    let mounting = match rig {
        Rig::Gimbal => {
            let ring = root.section("ring")?;
            let ring_inertia = admissible(0.0, 10.0, "the ring's inertia about pitch in kg m^2");
            let ring_inertia_kg_m2 = ring.number("inertia_kg_m2", ring_inertia)?;
            ring.finish()?;
            Mounting::Gimbal { ring_inertia_kg_m2 }
        }
        Rig::Free => {
            let mass_kg = body.number("mass_kg", admissible(0.005, 50.0, "the mass in kg"))?;
            let own = admissible(0.0, 20.0, "the rotors' drag over airspeed in N s/m");
            let known = admissible(0.01, 2.0, "the rotors' drag over airspeed and mass as the core knows it in 1/s");
            drag[0] = body.number_or("rotor_drag_ns_m", own, 0.0)?;
            drag[1] = body.number_or("known_rotor_drag_1_s", known, drag[1])?;
            Mounting::Free { mass_kg }
        }
    };
    body.finish()?;
    check_triangle(&body, inertia_kg_m2)?;
    Ok((inertia_kg_m2, mounting, drag))
}

/// Each principal moment is a sum of two of three non-negative integrals, so none exceeds the other two together.
fn check_triangle(body: &Section<'_>, [x, y, z]: [f64; 3]) -> Result<(), ModelError> {
    // a flat plate reaches equality; rounding of the decimal numbers must not reject it
    let slack = 1.0 + 1e-9;
    if x <= (y + z) * slack && y <= (z + x) * slack && z <= (x + y) * slack {
        return Ok(());
    }
    Err(body.impossible(format!(
        "no body has the moments of inertia {x:?}, {y:?}, {z:?} kg m^2: expected each to be at most the sum of the \
         other two"
    )))
}

fn read_noise(noise: &Section<'_>) -> Result<SensorNoise, ModelError> {
    let gyro = admissible(0.0, 1.0, "the gyro's standard deviation in rad/s");
    let accel = admissible(0.0, 20.0, "the accelerometer's standard deviation in m/s^2");
    let attitude = admissible(0.0, 0.5, "the logged attitude's standard deviation in rad");
    let velocity = admissible(0.0, 20.0, "the logged velocity's standard deviation in m/s");
    let height = admissible(0.0, 20.0, "the logged height's standard deviation in m");
    let read = SensorNoise {
        gyro_rad_s: noise.number("gyro_rad_s", gyro)?,
        accel_m_s2: noise.number("accel_m_s2", accel)?,
        attitude_rad: noise.number("attitude_rad", attitude)?,
        velocity_m_s: noise.number_or("velocity_m_s", velocity, SensorNoise::USUAL_VELOCITY_M_S)?,
        height_m: noise.number_or("height_m", height, SensorNoise::USUAL_HEIGHT_M)?,
    };
    noise.finish()?;
    Ok(read)
}
