//! The state of a vehicle in free flight: place, velocity, attitude as a unit quaternion, body rate. Equations:
//! [`FreeBody`].

use crate::vehicle::{Air, FreeBody, rotated};

/// Position NED (m), velocity NED (m/s), quaternion world from body (w, x, y, z), body rate (rad/s).
pub(super) type FreeState = [f64; 13];

/// What effects add in free flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Loads {
    /// Torque about the body axes, N m.
    pub(super) torque_body_nm: [f64; 3],
    /// Force along the body axes, N.
    pub(super) push_body_n: [f64; 3],
}

/// Rate of change of the state under the sum of the lifts (N) and the body torque (N m).
#[inline]
pub(super) fn derivative(body: &FreeBody, state: &FreeState, lift_sum_n: f64, torque_body_nm: [f64; 3]) -> FreeState {
    let [_, _, _, vx, vy, vz, w, x, y, z, p, q, r] = *state;
    // third column of R(q): the body's z axis in the world
    let z_body = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
    let thrust = body.thrust_m_s2(lift_sum_n);
    let turning = body.angular_acceleration_rad_s2([p, q, r], torque_body_nm);
    [
        vx,
        vy,
        vz,
        thrust * z_body[0],
        thrust * z_body[1],
        thrust * z_body[2] + body.gravity_m_s2,
        0.5 * (-x * p - y * q - z * r),
        0.5 * (w * p + y * r - z * q),
        0.5 * (w * q + z * p - x * r),
        0.5 * (w * r + x * q - y * p),
        turning[0],
        turning[1],
        turning[2],
    ]
}

/// The same with what effects add.
pub(super) fn extended_derivative(
    body: &FreeBody,
    state: &FreeState,
    lift_sum_n: f64,
    torque_body_nm: [f64; 3],
    loads: &Loads,
) -> FreeState {
    let torque: [f64; 3] = core::array::from_fn(|axis| torque_body_nm[axis] + loads.torque_body_nm[axis]);
    let mut change = derivative(body, state, lift_sum_n, torque);
    let quaternion = [state[6], state[7], state[8], state[9]];
    let pushed_m_s2 = rotated(quaternion, body.specific_force_m_s2(0.0, loads.push_body_n));
    for axis in 0..3 {
        change[3 + axis] += pushed_m_s2[axis];
    }
    change
}

/// What the air does to a vehicle in a state.
pub(super) fn loads_of_air(air: &Air, state: &FreeState) -> Loads {
    if !air.drags() && !air.turns() {
        return Loads::default();
    }
    let [_, _, _, vx, vy, vz, w, x, y, z, ..] = *state;
    // the conjugate turns the world into the body
    let along = rotated([w, -x, -y, -z], air.against_m_s([vx, vy, vz]));
    Loads { torque_body_nm: air.torque_body_nm([along[0], along[1]]), push_body_n: air.push_n(along) }
}

/// Brings the quaternion back to length one after a step; the free state leads the array.
#[inline]
pub(super) fn normalise<const N: usize>(state: &mut [f64; N]) {
    const { assert!(N >= 13) };
    let [w, x, y, z] = [state[6], state[7], state[8], state[9]];
    let scale = 1.0 / (w * w + x * x + y * y + z * z).sqrt();
    for component in &mut state[6..10] {
        *component *= scale;
    }
}
