//! Euler angles Z-Y-X and unit quaternions (w, x, y, z), world from body.

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
