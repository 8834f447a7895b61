//! How large a vehicle is.

/// Sizes by which what acts on a vehicle is large or small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Its lift at hover times its arm, N m.
    pub(crate) moment_nm: f64,
    /// Inertia about roll, pitch (on the gimbal with the ring) and yaw, kg m².
    pub(crate) inertia_kg_m2: [f64; 3],
    /// Mass, kg.
    pub(crate) mass_kg: f64,
    /// From motor to centre, m.
    pub(crate) arm_m: f64,
}

impl Scale {
    /// Separate axes: bodies of unit inertia, on which moments are accelerations in rad/s².
    pub(crate) const SEPARATE_AXES: Scale = Scale { moment_nm: 1.0, inertia_kg_m2: [1.0; 3], mass_kg: 1.0, arm_m: 1.0 };
}
