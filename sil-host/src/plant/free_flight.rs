//! Rig B, free flight: a rigid body in a north-east-down world (thesis 2.1 to 2.3, with gravity downward; the
//! thesis prints (2.1) with the sign of a z-up world).
//!
//! - `x' = v`, `v' = g z_down + R(q) f_body / m`
//! - `q' = 1/2 q (0, w)`
//! - `I w' = tau - w x I w`, I diagonal
//!
//! The only force besides gravity is lift, along -z of the body.

use super::effects::Effect;

/// Mass and inertia, ready for the equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeBody {
    inertia: [f64; 3],
    per_inertia: [f64; 3],
    per_mass: f64,
    gravity_m_s2: f64,
}

/// What an effect in free flight may depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeMotion {
    /// Sum of the lifts over the weight: 1 at hover.
    pub(crate) lift_over_weight: f64,
}

/// Position NED (m), velocity NED (m/s), quaternion world from body (w, x, y, z), body rate (rad/s).
pub(crate) type FreeState = [f64; 13];

impl FreeBody {
    pub(crate) fn new(inertia_kg_m2: [f64; 3], mass_kg: f64, gravity_m_s2: f64) -> Self {
        Self {
            inertia: inertia_kg_m2,
            per_inertia: inertia_kg_m2.map(|moment| 1.0 / moment),
            per_mass: 1.0 / mass_kg,
            gravity_m_s2,
        }
    }

    /// Rate of change of the state under the sum of the lifts (N) and the body torque (N m).
    #[inline]
    pub(crate) fn derivative(
        &self,
        state: &FreeState,
        lift_sum_n: f64,
        torque_body_nm: [f64; 3],
        effects: &[Effect],
    ) -> FreeState {
        let [_, _, _, vx, vy, vz, w, x, y, z, p, q, r] = *state;
        let mut torque = torque_body_nm;
        if !effects.is_empty() {
            let motion = FreeMotion { lift_over_weight: lift_sum_n * self.per_mass / self.gravity_m_s2 };
            for effect in effects {
                let [x_nm, y_nm, z_nm] = effect.body_torque_nm(&motion);
                torque[0] += x_nm;
                torque[1] += y_nm;
                torque[2] += z_nm;
            }
        }
        // third column of R(q): the body's z axis in the world
        let z_body = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
        let thrust = -lift_sum_n * self.per_mass;
        let [ixx, iyy, izz] = self.inertia;
        [
            vx,
            vy,
            vz,
            thrust * z_body[0],
            thrust * z_body[1],
            thrust * z_body[2] + self.gravity_m_s2,
            0.5 * (-x * p - y * q - z * r),
            0.5 * (w * p + y * r - z * q),
            0.5 * (w * q + z * p - x * r),
            0.5 * (w * r + x * q - y * p),
            (torque[0] - (izz - iyy) * q * r) * self.per_inertia[0],
            (torque[1] - (ixx - izz) * r * p) * self.per_inertia[1],
            (torque[2] - (iyy - ixx) * p * q) * self.per_inertia[2],
        ]
    }

    /// Specific force at the centre of gravity, body axes, m/s²: lift is all that is felt.
    pub(crate) fn specific_force_body_m_s2(&self, lift_sum_n: f64) -> [f64; 3] {
        [0.0, 0.0, -lift_sum_n * self.per_mass]
    }
}

/// Brings the quaternion back to length one after a step.
#[inline]
pub(crate) fn normalise(state: &mut FreeState) {
    let [w, x, y, z] = [state[6], state[7], state[8], state[9]];
    let scale = 1.0 / (w * w + x * x + y * y + z * z).sqrt();
    for component in &mut state[6..10] {
        *component *= scale;
    }
}

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
