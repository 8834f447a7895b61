//! The air about a free vehicle, and the ground below it: rotor drag in the body's xy plane, in proportion to the
//! velocity against the air; the airframe's drag with its square; lift that grows near the ground. The effects say
//! where the equations come from.

/// Of dry air at sea level, kg/m³ (ISO 2533).
const DENSITY_KG_M3: f64 = 1.225;
/// Nearer to the ground than half a radius the image formula ends: lift stays what it is there.
const NEAREST_RADII: f64 = 0.5;

/// Air and ground, and what the vehicle is to them; the default is still air, which nothing drags on, far from the
/// ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Air {
    /// Rotor drag over airspeed, N s/m.
    pub(crate) rotor_drag_ns_m: f64,
    /// Moment that turns the vehicle away from where it flies to, over airspeed, N s; on separate axes rad/s² per m/s.
    pub(crate) speed_stability_ns: f64,
    /// Velocity of the air, north and east, m/s.
    pub(crate) wind_m_s: [f64; 2],
    /// Drag coefficient times area of the airframe, m².
    pub(crate) drag_area_m2: f64,
    /// Square of the radius with which the rotors feel the ground, m²; 0 where they feel none.
    pub(crate) ground_radius_squared_m2: f64,
    /// Height of the rotors above ground at the start, m, where something says so.
    pub(crate) start_height_m: Option<f64>,
}

impl Air {
    /// True if no force depends on place or velocity.
    pub(crate) fn is_void(&self) -> bool {
        !self.drags() && self.ground_radius_squared_m2 == 0.0
    }

    /// True if the vehicle feels its velocity.
    #[inline]
    pub(crate) fn drags(&self) -> bool {
        self.rotor_drag_ns_m != 0.0 || self.drag_area_m2 != 0.0
    }

    /// True if the vehicle's velocity turns it.
    #[inline]
    pub(crate) fn turns(&self) -> bool {
        self.speed_stability_ns != 0.0
    }

    /// Velocity against the air, north, east, down, m/s.
    #[inline]
    pub(crate) fn against_m_s(&self, [north, east, down]: [f64; 3]) -> [f64; 3] {
        [north - self.wind_m_s[0], east - self.wind_m_s[1], down]
    }

    /// Force on the vehicle, body axes, N, at a velocity against the air in the same axes, m/s.
    #[inline]
    pub(crate) fn push_n(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let airframe = 0.5 * DENSITY_KG_M3 * self.drag_area_m2 * (x * x + y * y + z * z).sqrt();
        let in_plane = airframe + self.rotor_drag_ns_m;
        [-in_plane * x, -in_plane * y, -airframe * z]
    }

    /// Torque about the body's axes, N m, at a velocity against the air along its x and y axes, m/s: it lifts the side
    /// that leads.
    #[inline]
    pub(crate) fn torque_body_nm(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        [-self.speed_stability_ns * y, self.speed_stability_ns * x, 0.0]
    }

    /// Lift at a height over lift far from the ground: `1 / (1 - (R / 4z)^2)`.
    #[inline]
    pub(crate) fn lift_factor(&self, height_m: f64) -> f64 {
        let squared = self.ground_radius_squared_m2;
        let nearest_squared = NEAREST_RADII * NEAREST_RADII * squared;
        let height_squared = if height_m > 0.0 { height_m * height_m } else { 0.0 };
        let apart = 16.0 * height_squared.max(nearest_squared);
        if squared > 0.0 { apart / (apart - squared) } else { 1.0 }
    }
}
