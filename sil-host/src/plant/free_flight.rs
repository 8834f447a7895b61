//! Rig B, free flight: a rigid body in a north-east-down world (thesis 2.1 to 2.3, with gravity downward; the
//! thesis prints (2.1) with the sign of a z-up world).
//!
//! - `x' = v`, `v' = g z_down + R(q) f_body / m`
//! - `q' = 1/2 q (0, w)`
//! - `I w' = tau - w x I w`, I diagonal
//!
//! The only force besides gravity is lift, along -z of the body, unless effects add others.

use crate::effects::{BodyChange, Effect, FreeMotion, Instant};
use crate::vehicle::euler_rad;

/// Mass and inertia, ready for the equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeBody {
    inertia: [f64; 3],
    per_inertia: [f64; 3],
    /// I_xy; 0 in the nominal body.
    product_xy: f64,
    per_mass: f64,
    gravity_m_s2: f64,
}

/// Position NED (m), velocity NED (m/s), quaternion world from body (w, x, y, z), body rate (rad/s).
pub(crate) type FreeState = [f64; 13];

/// What effects add in free flight.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Loads {
    /// Torque about the body axes, N m.
    pub(crate) torque_body_nm: [f64; 3],
    /// Force along the body axes, N.
    pub(crate) force_body_n: [f64; 3],
}

impl FreeBody {
    pub(crate) fn new(inertia_kg_m2: [f64; 3], mass_kg: f64, gravity_m_s2: f64, change: &BodyChange) -> Self {
        let inertia: [f64; 3] = core::array::from_fn(|axis| change.inertia_scale[axis] * inertia_kg_m2[axis]);
        Self {
            inertia,
            per_inertia: inertia.map(|moment| 1.0 / moment),
            product_xy: change.product_xy_kg_m2,
            per_mass: 1.0 / (change.mass_scale * mass_kg),
            gravity_m_s2,
        }
    }

    /// Rate of change of the state under the sum of the lifts (N) and the body torque (N m).
    #[inline]
    pub(crate) fn derivative(&self, state: &FreeState, lift_sum_n: f64, torque_body_nm: [f64; 3]) -> FreeState {
        let [_, _, _, vx, vy, vz, w, x, y, z, p, q, r] = *state;
        let torque = torque_body_nm;
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

    /// The same with what effects add.
    pub(crate) fn extended_derivative(
        &self,
        state: &FreeState,
        lift_sum_n: f64,
        torque_body_nm: [f64; 3],
        loads: &Loads,
    ) -> FreeState {
        let torque: [f64; 3] = core::array::from_fn(|axis| torque_body_nm[axis] + loads.torque_body_nm[axis]);
        let mut change = self.derivative(state, lift_sum_n, torque);
        let quaternion = [state[6], state[7], state[8], state[9]];
        let push_ned_n = rotated(quaternion, loads.force_body_n);
        for axis in 0..3 {
            change[3 + axis] += push_ned_n[axis] * self.per_mass;
        }
        if self.product_xy != 0.0 {
            let [.., p, q, r] = *state;
            change[10..].copy_from_slice(&self.coupled_acceleration([p, q, r], torque));
        }
        change
    }

    /// `I w' = tau - w x I w` with the entry I_xy in I.
    fn coupled_acceleration(&self, [p, q, r]: [f64; 3], torque_nm: [f64; 3]) -> [f64; 3] {
        let [ixx, iyy, izz] = self.inertia;
        let pxy = self.product_xy;
        let momentum = [ixx * p + pxy * q, pxy * p + iyy * q, izz * r];
        let left = [
            torque_nm[0] - (q * momentum[2] - r * momentum[1]),
            torque_nm[1] - (r * momentum[0] - p * momentum[2]),
            torque_nm[2] - (p * momentum[1] - q * momentum[0]),
        ];
        let per_determinant = 1.0 / (ixx * iyy - pxy * pxy);
        [
            (iyy * left[0] - pxy * left[1]) * per_determinant,
            (ixx * left[1] - pxy * left[0]) * per_determinant,
            left[2] * self.per_inertia[2],
        ]
    }

    /// What effects add at a state, in air that moves with `wind_ned_m_s`.
    pub(crate) fn loads(
        &self,
        state: &FreeState,
        lift_sum_n: f64,
        effects: &[Effect],
        wind_ned_m_s: [f64; 3],
        instant: Instant,
    ) -> Loads {
        let [_, _, _, vx, vy, vz, w, x, y, z, rate_body_rad_s @ ..] = *state;
        let air_velocity_ned = [vx - wind_ned_m_s[0], vy - wind_ned_m_s[1], vz - wind_ned_m_s[2]];
        let motion = FreeMotion {
            lift_over_weight: lift_sum_n * self.per_mass / self.gravity_m_s2,
            angle_rad: euler_rad([w, x, y, z]),
            rate_body_rad_s,
            // the conjugate turns the world into the body
            air_velocity_body_m_s: rotated([w, -x, -y, -z], air_velocity_ned),
            instant,
        };
        let mut loads = Loads::default();
        for effect in effects {
            let (torque, force) =
                (effect.extension().body_torque_nm(&motion), effect.extension().body_force_n(&motion));
            for axis in 0..3 {
                loads.torque_body_nm[axis] += torque[axis];
                loads.force_body_n[axis] += force[axis];
            }
        }
        loads
    }

    /// Specific force at the centre of gravity, body axes, m/s²: lift, and whatever else pushes but gravity.
    pub(crate) fn specific_force_body_m_s2(&self, lift_sum_n: f64, loads: &Loads) -> [f64; 3] {
        let [x, y, z] = loads.force_body_n.map(|force| force * self.per_mass);
        [x, y, z - lift_sum_n * self.per_mass]
    }
}

/// A vector turned by a unit quaternion (w, x, y, z): v + 2 w (u x v) + 2 u x (u x v).
fn rotated([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let once = cross([x, y, z], v);
    let twice = cross([x, y, z], once);
    core::array::from_fn(|i| v[i] + 2.0 * (w * once[i] + twice[i]))
}

/// Brings the quaternion back to length one after a step; the free state leads the array.
#[inline]
pub(crate) fn normalise<const N: usize>(state: &mut [f64; N]) {
    const { assert!(N >= 13) };
    let [w, x, y, z] = [state[6], state[7], state[8], state[9]];
    let scale = 1.0 / (w * w + x * x + y * y + z * z).sqrt();
    for component in &mut state[6..10] {
        *component *= scale;
    }
}
