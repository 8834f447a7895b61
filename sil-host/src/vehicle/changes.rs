//! What effects may change of a vehicle's numbers. Moments that depend on the motion are not here: see
//! [`super::Moment`].

use super::{ActuatorChain, Air, SensorChain};

/// A vehicle's numbers beyond the nominal ones; the default changes nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Changes {
    /// Of the body.
    pub(crate) body: BodyChange,
    /// From command to lift.
    pub(crate) chain: ActuatorChain,
    /// From motion to reading.
    pub(crate) sensors: SensorChain,
    /// Air and ground about a free vehicle.
    pub(crate) air: Air,
}

/// How a body differs from the nominal one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyChange {
    /// Factor on the inertia about roll, pitch (on the gimbal with the ring) and yaw.
    pub(crate) inertia_scale: [f64; 3],
    /// Entry I_xy of the inertia tensor, kg m².
    pub(crate) product_xy_kg_m2: f64,
    /// Factor on the mass.
    pub(crate) mass_scale: f64,
}

impl Default for BodyChange {
    fn default() -> Self {
        Self { inertia_scale: [1.0; 3], product_xy_kg_m2: 0.0, mass_scale: 1.0 }
    }
}
