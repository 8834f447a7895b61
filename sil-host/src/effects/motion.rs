//! What an effect may depend on, and what of the body it may change.

/// A point in time as effects see it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Instant {
    /// Time since the start, s.
    pub(crate) time_s: f64,
    /// Start of the stretch that is integrated, s: nothing sets in between it and `time_s`, so that what sets in at the
    /// stretch's very end is not yet there at its last stage.
    pub(crate) stretch_start_s: f64,
}

/// Motion about one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisMotion {
    /// Euler angle of the axis, rad.
    pub(crate) angle_rad: f64,
    /// On the gimbal the angle's derivative, in free flight the body rate, rad/s.
    pub(crate) rate_rad_s: f64,
    /// When.
    pub(crate) instant: Instant,
}

/// Motion on the gimbal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GimbalMotion {
    pub(crate) sin_roll: f64,
    pub(crate) cos_roll: f64,
    pub(crate) sin_pitch: f64,
    pub(crate) cos_pitch: f64,
    /// Roll and pitch, rad.
    pub(crate) angle_rad: [f64; 2],
    /// Their derivatives, rad/s.
    pub(crate) rate_rad_s: [f64; 2],
    /// When.
    pub(crate) instant: Instant,
}

impl GimbalMotion {
    /// Motion about roll (0) or pitch (1).
    pub(crate) fn about(&self, axis: usize) -> AxisMotion {
        AxisMotion { angle_rad: self.angle_rad[axis], rate_rad_s: self.rate_rad_s[axis], instant: self.instant }
    }
}

/// Motion in free flight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeMotion {
    /// Sum of the lifts over the weight: 1 at hover.
    pub(crate) lift_over_weight: f64,
    /// Roll, pitch, yaw, rad.
    pub(crate) angle_rad: [f64; 3],
    /// Body rate, rad/s.
    pub(crate) rate_body_rad_s: [f64; 3],
    /// Velocity against the air, body axes, m/s.
    pub(crate) air_velocity_body_m_s: [f64; 3],
    /// When.
    pub(crate) instant: Instant,
}

impl FreeMotion {
    /// Motion about roll (0), pitch (1) or yaw (2).
    pub(crate) fn about(&self, axis: usize) -> AxisMotion {
        AxisMotion { angle_rad: self.angle_rad[axis], rate_rad_s: self.rate_body_rad_s[axis], instant: self.instant }
    }
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
