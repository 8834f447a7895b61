//! Rig B, free flight: a rigid body under gravity, lift along -z of the body, and what the air does.
//!
//! - `v' = g + R f`, f the specific force: what an accelerometer at the centre of gravity reads
//! - `I w' = tau - w x I w`, I with the entry I_xy = P, which is 0 in the nominal body

use super::BodyChange;

/// Mass and inertia, ready for the equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeBody {
    inertia: [f64; 3],
    per_inertia: [f64; 3],
    /// P
    product_xy: f64,
    per_mass: f64,
    /// Divided once: compilers divide ahead, in a rig by whatever it has in gravity's place, and a fit takes half as
    /// long again.
    per_weight_1_n: f64,
    /// Acceleration of gravity, m/s².
    pub(crate) gravity_m_s2: f64,
}

impl FreeBody {
    /// Of principal moments, kg m², and a mass, kg.
    pub(crate) fn new(inertia_kg_m2: [f64; 3], mass_kg: f64, gravity_m_s2: f64, change: &BodyChange) -> Self {
        let inertia: [f64; 3] = core::array::from_fn(|axis| change.inertia_scale[axis] * inertia_kg_m2[axis]);
        let per_mass = 1.0 / (change.mass_scale * mass_kg);
        Self {
            inertia,
            per_inertia: inertia.map(|moment| 1.0 / moment),
            product_xy: change.product_xy_kg_m2,
            per_mass,
            per_weight_1_n: per_mass / gravity_m_s2,
            gravity_m_s2,
        }
    }

    /// p', q', r', rad/s², under a torque about the body's axes, N m.
    #[inline]
    pub(crate) fn angular_acceleration_rad_s2(&self, [p, q, r]: [f64; 3], torque_nm: [f64; 3]) -> [f64; 3] {
        let [ixx, iyy, izz] = self.inertia;
        if self.product_xy == 0.0 {
            return [
                (torque_nm[0] - (izz - iyy) * q * r) * self.per_inertia[0],
                (torque_nm[1] - (ixx - izz) * r * p) * self.per_inertia[1],
                (torque_nm[2] - (iyy - ixx) * p * q) * self.per_inertia[2],
            ];
        }
        let product = self.product_xy;
        let momentum = [ixx * p + product * q, product * p + iyy * q, izz * r];
        let left = [
            torque_nm[0] - (q * momentum[2] - r * momentum[1]),
            torque_nm[1] - (r * momentum[0] - p * momentum[2]),
            torque_nm[2] - (p * momentum[1] - q * momentum[0]),
        ];
        let per_determinant = 1.0 / (ixx * iyy - product * product);
        [
            (iyy * left[0] - product * left[1]) * per_determinant,
            (ixx * left[1] - product * left[0]) * per_determinant,
            left[2] * self.per_inertia[2],
        ]
    }

    /// Specific force along the body's z axis of lifts alone, m/s².
    #[inline]
    pub(crate) fn thrust_m_s2(&self, lift_sum_n: f64) -> f64 {
        -lift_sum_n * self.per_mass
    }

    /// Specific force, body axes, m/s²: lift, and what pushes besides, N.
    #[inline]
    pub(crate) fn specific_force_m_s2(&self, lift_sum_n: f64, push_body_n: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = push_body_n.map(|force_n| force_n * self.per_mass);
        [x, y, z + self.thrust_m_s2(lift_sum_n)]
    }

    /// One over the vehicle's weight, 1/N.
    pub(crate) fn per_weight_1_n(&self) -> f64 {
        self.per_weight_1_n
    }
}
