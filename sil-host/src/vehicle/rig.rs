//! What holds the vehicle.

use super::{BodyChange, FreeBody, Gimbal};

/// The two rigs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rig {
    /// Roll rod in a pitch ring, no yaw, no translation.
    Gimbal,
    /// Free flight.
    Free,
}

/// What holds the body, with the numbers that only this rig has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mounting {
    /// The body turns about x in a ring that turns about y.
    Gimbal {
        /// Inertia of the ring about the pitch axis, kg m².
        ring_inertia_kg_m2: f64,
    },
    /// Nothing does.
    Free {
        /// Mass, kg.
        mass_kg: f64,
    },
}

impl Rig {
    /// Names in model files and on the command line.
    pub const NAMES: [(&'static str, Rig); 2] = [("gimbal", Rig::Gimbal), ("free", Rig::Free)];

    /// Its name in model files.
    pub fn name(self) -> &'static str {
        match self {
            Rig::Gimbal => "gimbal",
            Rig::Free => "free",
        }
    }
}

/// The body in its rig, ready for the equations of motion.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RigidBody {
    /// On the gimbal.
    Gimbal(Gimbal),
    /// In free flight.
    Free(FreeBody),
}

/// The nominal body in its rig, as numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NominalBody {
    /// Principal moments of inertia of the body alone, (x, y, z), kg m².
    pub(crate) inertia_kg_m2: [f64; 3],
    /// What holds it, or nothing.
    pub(crate) mounting: Mounting,
    /// Acceleration of gravity, m/s².
    pub(crate) gravity_m_s2: f64,
}

impl NominalBody {
    /// The body with what effects change of it.
    pub(crate) fn changed(&self, change: &BodyChange) -> RigidBody {
        match self.mounting {
            Mounting::Gimbal { ring_inertia_kg_m2 } => {
                RigidBody::Gimbal(Gimbal::new(self.inertia_kg_m2, ring_inertia_kg_m2, change))
            }
            Mounting::Free { mass_kg } => {
                RigidBody::Free(FreeBody::new(self.inertia_kg_m2, mass_kg, self.gravity_m_s2, change))
            }
        }
    }
}
