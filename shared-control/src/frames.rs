//! Frames, and the only functions that change between them.
//!
//! ```text
//!   world NED            body FRD                 Euler Z-Y-X
//!   x north              x forward                yaw psi about z, then
//!   y east               y right                  pitch theta about y (nose up positive), then
//!   z down               z down                   roll phi about x (right side down positive)
//! ```
//! nalgebra's own constructors from angles compute in `f64` on this core and are not used.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::elementary::{asin, atan2, sin_cos, sqrt};

/// Euler angles Z-Y-X, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EulerAngles {
    /// About the body's x axis.
    pub roll_rad: f32,
    /// About the y axis between.
    pub pitch_rad: f32,
    /// About the world's z axis.
    pub yaw_rad: f32,
}

/// Rotation that takes body vectors to world vectors, from Euler angles.
pub fn q_world_from_euler(angles: EulerAngles) -> UnitQuaternion<f32> {
    let (sr, cr) = sin_cos(0.5 * angles.roll_rad);
    let (sp, cp) = sin_cos(0.5 * angles.pitch_rad);
    let (sy, cy) = sin_cos(0.5 * angles.yaw_rad);
    normalized(Quaternion::new(
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ))
}

/// Euler angles of a rotation. At +-90 degrees of pitch roll and yaw are one angle; the split is then arbitrary.
pub fn euler_from_q(q_world_from_body: &UnitQuaternion<f32>) -> EulerAngles {
    let q = q_world_from_body.quaternion();
    let (w, x, y, z) = (q.w, q.i, q.j, q.k);
    EulerAngles {
        roll_rad: atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        pitch_rad: asin(2.0 * (w * y - z * x)),
        yaw_rad: atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    }
}

/// Rotation by a rotation vector (axis times angle, rad), exact for any length that a step can bring.
pub fn q_from_rotation_vector(rotation_rad: &Vector3<f32>) -> UnitQuaternion<f32> {
    let angle = sqrt(rotation_rad.dot(rotation_rad));
    // below this the sine's series has one term in f32
    let (scale, w) = if angle < 1e-3 {
        (0.5, 1.0 - 0.125 * angle * angle)
    } else {
        let (s, c) = sin_cos(0.5 * angle);
        (s / angle, c)
    };
    normalized(Quaternion::from_parts(w, rotation_rad * scale))
}

/// The rotation nearest to a quaternion; identity where it has no direction.
pub fn normalized(q: Quaternion<f32>) -> UnitQuaternion<f32> {
    let norm = sqrt(q.w * q.w + q.i * q.i + q.j * q.j + q.k * q.k);
    if norm > 1e-12 && norm < 1e12 {
        UnitQuaternion::new_unchecked(q * (1.0 / norm))
    } else {
        UnitQuaternion::identity()
    }
}

/// Direction of the world's down axis, seen from the body.
pub fn down_in_body(q_world_from_body: &UnitQuaternion<f32>) -> Vector3<f32> {
    q_world_from_body.inverse() * Vector3::z()
}

/// Euler angle rates [roll, pitch, yaw], rad/s, from the body's rotation rate.
///
/// Singular at +-90 degrees of pitch; the cosine is kept away from zero so that the result stays finite.
pub fn euler_rates(angles: EulerAngles, rate_body_rad_s: &Vector3<f32>) -> [f32; 3] {
    let (sin_roll, cos_roll) = sin_cos(angles.roll_rad);
    let (sin_pitch, cos_pitch) = sin_cos(angles.pitch_rad);
    let cos_pitch = if cos_pitch < 0.05 { 0.05 } else { cos_pitch };
    let across = sin_roll * rate_body_rad_s.y + cos_roll * rate_body_rad_s.z;
    [
        rate_body_rad_s.x + across * sin_pitch / cos_pitch,
        cos_roll * rate_body_rad_s.y - sin_roll * rate_body_rad_s.z,
        across / cos_pitch,
    ]
}

/// Rotation rate of the body, rad/s, from Euler angle rates [roll, pitch, yaw].
pub fn rate_body_from_euler_rates(angles: EulerAngles, euler_rate_rad_s: [f32; 3]) -> Vector3<f32> {
    let (sin_roll, cos_roll) = sin_cos(angles.roll_rad);
    let (sin_pitch, cos_pitch) = sin_cos(angles.pitch_rad);
    let [roll, pitch, yaw] = euler_rate_rad_s;
    Vector3::new(
        roll - sin_pitch * yaw,
        cos_roll * pitch + sin_roll * cos_pitch * yaw,
        -sin_roll * pitch + cos_roll * cos_pitch * yaw,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn angles() -> impl Strategy<Value = EulerAngles> {
        (-3.1f32..3.1, -1.5f32..1.5, -3.1f32..3.1).prop_map(|(roll_rad, pitch_rad, yaw_rad)| EulerAngles {
            roll_rad,
            pitch_rad,
            yaw_rad,
        })
    }

    proptest! {
        #[test]
        fn euler_angles_survive_the_quaternion(e in angles()) {
            let back = euler_from_q(&q_world_from_euler(e));
            // f32 rounding, amplified by 1/cos(pitch) <= 14 near the pole
            prop_assert!((back.roll_rad - e.roll_rad).abs() < 2e-5);
            prop_assert!((back.pitch_rad - e.pitch_rad).abs() < 2e-5);
            prop_assert!((back.yaw_rad - e.yaw_rad).abs() < 2e-5);
        }

        #[test]
        fn rates_survive_both_ways(e in angles(), p in -5f32..5.0, q in -5f32..5.0, r in -5f32..5.0) {
            prop_assume!(e.pitch_rad.abs() < 1.4);
            let body = Vector3::new(p, q, r);
            let back = rate_body_from_euler_rates(e, euler_rates(e, &body));
            prop_assert!((back - body).norm() < 2e-4);
        }

        #[test]
        fn rotation_matrix_is_the_thesis_equation_2_3(e in angles()) {
            let (sr, cr) = sin_cos(e.roll_rad);
            let (sp, cp) = sin_cos(e.pitch_rad);
            let (sy, cy) = sin_cos(e.yaw_rad);
            let forward = q_world_from_euler(e) * Vector3::x();
            let right = q_world_from_euler(e) * Vector3::y();
            let down = q_world_from_euler(e) * Vector3::z();
            prop_assert!((forward - Vector3::new(cp * cy, cp * sy, -sp)).norm() < 1e-6);
            prop_assert!((right - Vector3::new(sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp)).norm() < 1e-6);
            prop_assert!((down - Vector3::new(cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp)).norm() < 1e-6);
        }

        #[test]
        fn small_rotations_add_up_to_a_large_one(x in -3f32..3.0, y in -3f32..3.0, z in -3f32..3.0) {
            let whole = q_from_rotation_vector(&Vector3::new(x, y, z));
            let part = q_from_rotation_vector(&(Vector3::new(x, y, z) * (1.0 / 1024.0)));
            let mut sum = UnitQuaternion::identity();
            for _ in 0..1024 { sum = normalized((sum * part).into_inner()); }
            // 1024 products, each rounding at 6e-8, errors adding at worst linearly
            prop_assert!((sum.into_inner() - whole.into_inner()).norm() < 6e-5);
        }
    }

    /// Against the closed form in double precision, from no rotation at all to beyond the change of formula.
    #[test]
    fn a_small_rotation_is_exact_to_rounding() {
        for step in 0..200 {
            let angle = 1e-5 * step as f32;
            let q = q_from_rotation_vector(&Vector3::new(0.0, angle, 0.0)).into_inner();
            let half = 0.5 * f64::from(angle);
            assert!((f64::from(q.w) - libm::cos(half)).abs() < 1.3e-7, "{angle}: {q}");
            assert!((f64::from(q.j) - libm::sin(half)).abs() <= 1.8e-7 * half, "{angle}: {q}");
            assert_eq!((q.i, q.k), (0.0, 0.0));
        }
    }

    /// The heading's rate is no more than 20 times the body's, up to the pole and beyond it.
    #[test]
    fn euler_rates_stay_bounded_at_the_pole() {
        for pitch_rad in [1.55, core::f32::consts::FRAC_PI_2, 1.6, -1.55, -1.6] {
            let [roll, pitch, yaw] = euler_rates(EulerAngles { pitch_rad, ..Default::default() }, &Vector3::z());
            assert!((yaw - 20.0).abs() < 1e-4 && pitch == 0.0, "{pitch_rad}");
            assert!((roll - 20.0 * sin_cos(pitch_rad).0).abs() < 1e-4, "{pitch_rad}");
        }
    }

    #[test]
    fn a_quaternion_without_direction_is_the_identity() {
        for q in [Quaternion::new(0.0, 0.0, 0.0, 0.0), Quaternion::new(f32::NAN, 0.0, 0.0, 0.0)] {
            assert_eq!(normalized(q), UnitQuaternion::identity());
        }
    }
}
