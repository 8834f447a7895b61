//! Attitude in its forms: Euler angles Z-Y-X (roll, pitch, yaw), their rates, and unit quaternions (w, x, y, z), world
//! from body.

/// Nearer to the vertical than this cosine of pitch the rates of roll and yaw lose their meaning; the formulas stay
/// finite.
const COSINE_MIN: f64 = 1e-3;

/// Roll, pitch, yaw (Z-Y-X), rad, of a unit quaternion world from body.
pub(crate) fn euler_rad([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    [
        libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        libm::asin((2.0 * (w * y - x * z)).clamp(-1.0, 1.0)),
        libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    ]
}

/// Unit quaternion world from body of the Euler angles roll, pitch, yaw (Z-Y-X), rad.
pub(crate) fn quaternion_world_from_body([roll, pitch, yaw]: [f64; 3]) -> [f64; 4] {
    let (sr, cr) = libm::sincos(0.5 * roll);
    let (sp, cp) = libm::sincos(0.5 * pitch);
    let (sy, cy) = libm::sincos(0.5 * yaw);
    [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]
}

/// The cross product.
#[inline]
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A vector turned by a unit quaternion (w, x, y, z): v + 2 w (u x v) + 2 u x (u x v).
#[inline]
pub(crate) fn rotated([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let once = cross([x, y, z], v);
    let twice = cross([x, y, z], once);
    core::array::from_fn(|i| v[i] + 2.0 * (w * once[i] + twice[i]))
}

/// Rates of roll, pitch and yaw, rad/s, from the body's (p, q, r); roll and pitch as (sine, cosine).
#[inline]
pub(crate) fn euler_rates_rad_s(roll: (f64, f64), pitch: (f64, f64), rate_body_rad_s: [f64; 3]) -> [f64; 3] {
    let ((sin_roll, cos_roll), (sin_pitch, cos_pitch), [p, q, r]) = (roll, pitch, rate_body_rad_s);
    let yaw_rate = (q * sin_roll + r * cos_roll) / cos_pitch.abs().max(COSINE_MIN).copysign(cos_pitch);
    [p + sin_pitch * yaw_rate, q * cos_roll - r * sin_roll, yaw_rate]
}

/// Roll, pitch and yaw, each as (sine, cosine).
pub(crate) struct Attitude {
    pub(crate) roll: (f64, f64),
    pub(crate) pitch: (f64, f64),
    yaw: (f64, f64),
}

impl Attitude {
    /// Of Euler angles Z-Y-X, rad.
    pub(crate) fn of([roll_rad, pitch_rad, yaw_rad]: [f64; 3]) -> Attitude {
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
