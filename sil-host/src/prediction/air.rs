//! What moves a free vehicle from its place: lift, weight, and the air about it; written for the diagnosis and apart from the plant's.
//!
//! `v' = g + R f`, f the specific force in body axes, which is what an accelerometer at the centre of gravity reads: lifts along -z over the
//! mass, rotor drag against the air in the body's xy plane, the airframe's drag against the air's whole velocity (docs/effects.md, free flight;
//! sources in the catalogue of `plant::effects`). The lift itself grows near the ground (Cheeseman and Bennett, ARC R&M 3021, 1955).

/// Of dry air at sea level, kg/m^3 (ISO 2533).
const DENSITY_KG_M3: f64 = 1.225;
/// Nearer to the ground than half a radius the image formula ends.
const NEAREST_RADII: f64 = 0.5;

/// The air, and what the vehicle is to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Air {
    /// True over nominal mass.
    pub(crate) mass_scale: f64,
    /// Rotor drag over airspeed, N s/m.
    pub(crate) rotor_drag_ns_m: f64,
    /// Velocity of the air, north and east, m/s.
    pub(crate) wind_m_s: [f64; 2],
    /// Drag coefficient times area of the airframe, m^2.
    pub(crate) drag_area_m2: f64,
    /// Square of the radius with which the rotors feel the ground, m^2; 0 where they feel none.
    pub(crate) ground_radius_squared_m2: f64,
}

impl Air {
    /// Still, thin and far from the ground.
    pub(crate) const NOMINAL: Air = Air {
        mass_scale: 1.0,
        rotor_drag_ns_m: 0.0,
        wind_m_s: [0.0; 2],
        drag_area_m2: 0.0,
        ground_radius_squared_m2: 0.0,
    };

    /// True if nothing that is felt hangs on place or velocity: they go their way, and act on nothing.
    pub(crate) fn is_void(&self) -> bool {
        self.rotor_drag_ns_m == 0.0 && self.drag_area_m2 == 0.0 && self.ground_radius_squared_m2 == 0.0
    }

    /// Lift at a height over lift far from the ground.
    pub(crate) fn lift_factor(&self, height_m: f64) -> f64 {
        let squared = self.ground_radius_squared_m2;
        let nearest_squared = NEAREST_RADII * NEAREST_RADII * squared;
        let height_squared = if height_m > 0.0 { height_m * height_m } else { 0.0 };
        let apart = 16.0 * height_squared.max(nearest_squared);
        if squared > 0.0 { apart / (apart - squared) } else { 1.0 }
    }

    /// Specific force in body axes, m/s^2, of a vehicle of a nominal mass whose rotors lift so much in all.
    pub(crate) fn specific_force_m_s2(
        &self,
        mass_kg: f64,
        lift_n: f64,
        attitude: &Attitude,
        velocity_ned_m_s: [f64; 3],
    ) -> [f64; 3] {
        let [north, east, down] = velocity_ned_m_s;
        let [x, y, z] = attitude.in_body([north - self.wind_m_s[0], east - self.wind_m_s[1], down]);
        let airframe = 0.5 * DENSITY_KG_M3 * self.drag_area_m2 * (x * x + y * y + z * z).sqrt();
        let in_plane = airframe + self.rotor_drag_ns_m;
        [-in_plane * x, -in_plane * y, -airframe * z - lift_n].map(|force_n| force_n / (self.mass_scale * mass_kg))
    }
}

/// Roll, pitch and yaw as sines and cosines.
pub(crate) struct Attitude {
    pub(crate) roll: (f64, f64),
    pub(crate) pitch: (f64, f64),
    yaw: (f64, f64),
}

impl Attitude {
    /// Of Euler angles Z-Y-X, rad.
    pub(crate) fn of(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> Attitude {
        Attitude { roll: libm::sincos(roll_rad), pitch: libm::sincos(pitch_rad), yaw: libm::sincos(yaw_rad) }
    }

    /// A vector north, east, down in the axes of the body: turned back about z, then y, then x.
    pub(crate) fn in_body(&self, [north, east, down]: [f64; 3]) -> [f64; 3] {
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch), (sin_yaw, cos_yaw)) = (self.roll, self.pitch, self.yaw);
        let (ahead, aside) = (cos_yaw * north + sin_yaw * east, cos_yaw * east - sin_yaw * north);
        let (x, below) = (cos_pitch * ahead - sin_pitch * down, sin_pitch * ahead + cos_pitch * down);
        [x, cos_roll * aside + sin_roll * below, cos_roll * below - sin_roll * aside]
    }

    /// The way back.
    pub(crate) fn in_world(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch), (sin_yaw, cos_yaw)) = (self.roll, self.pitch, self.yaw);
        let (aside, below) = (cos_roll * y - sin_roll * z, sin_roll * y + cos_roll * z);
        let (ahead, down) = (cos_pitch * x + sin_pitch * below, cos_pitch * below - sin_pitch * x);
        [cos_yaw * ahead - sin_yaw * aside, sin_yaw * ahead + cos_yaw * aside, down]
    }
}
