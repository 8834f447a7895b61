//! Rig A, the thesis' testbed: the body turns about a roll rod inside a pitch ring; yaw is locked and the pivot fixed.
//!
//! Generalised coordinates phi (roll), theta (pitch); kinetic energy `T = 1/2 I_xx phi'^2 + 1/2 J(phi) theta'^2`:
//! - `J(phi) = I_ring + I_yy cos^2 phi + I_zz sin^2 phi`
//! - `I_xx phi'' = tau_x + 1/2 J'(phi) theta'^2 + Q_phi`
//! - `J(phi) theta'' = tau_y cos phi - tau_z sin phi - J'(phi) phi' theta' + Q_theta`
//! - gyro: `p = phi'`, `q = theta' cos phi`, `r = -theta' sin phi`

use super::effects::Effect;

/// The gimbal's inertias, ready for the equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gimbal {
    per_ixx: f64,
    /// J(phi) = j_level + j_tilt sin^2 phi
    j_level: f64,
    j_tilt: f64,
}

/// What an effect on the gimbal may depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GimbalMotion {
    pub(crate) sin_roll: f64,
    pub(crate) cos_roll: f64,
    pub(crate) sin_pitch: f64,
    pub(crate) cos_pitch: f64,
}

/// Roll, pitch (rad) and their rates (rad/s).
pub(crate) type GimbalState = [f64; 4];

impl Gimbal {
    pub(crate) fn new(inertia_kg_m2: [f64; 3], ring_inertia_kg_m2: f64) -> Self {
        let [ixx, iyy, izz] = inertia_kg_m2;
        Self { per_ixx: 1.0 / ixx, j_level: ring_inertia_kg_m2 + iyy, j_tilt: izz - iyy }
    }

    /// Rates and accelerations under the body torque (x, y, z), N m.
    #[inline]
    pub(crate) fn derivative(&self, state: &GimbalState, torque_body_nm: [f64; 3], effects: &[Effect]) -> GimbalState {
        let [roll, pitch, roll_rate, pitch_rate] = *state;
        let [tau_x, tau_y, tau_z] = torque_body_nm;
        let (sin_roll, cos_roll) = libm::sincos(roll);
        let mut moment = [tau_x, tau_y * cos_roll - tau_z * sin_roll];
        if !effects.is_empty() {
            let (sin_pitch, cos_pitch) = libm::sincos(pitch);
            let motion = GimbalMotion { sin_roll, cos_roll, sin_pitch, cos_pitch };
            for effect in effects {
                let [roll_nm, pitch_nm] = effect.gimbal_moment_nm(&motion);
                moment[0] += roll_nm;
                moment[1] += pitch_nm;
            }
        }
        let j = self.j_level + self.j_tilt * sin_roll * sin_roll;
        let j_slope = 2.0 * self.j_tilt * sin_roll * cos_roll;
        [
            roll_rate,
            pitch_rate,
            (moment[0] + 0.5 * j_slope * pitch_rate * pitch_rate) * self.per_ixx,
            (moment[1] - j_slope * roll_rate * pitch_rate) / j,
        ]
    }
}

/// Body rates (p, q, r), rad/s.
pub(crate) fn rate_body_rad_s(state: &GimbalState) -> [f64; 3] {
    let [roll, _, roll_rate, pitch_rate] = *state;
    let (sin_roll, cos_roll) = libm::sincos(roll);
    [roll_rate, pitch_rate * cos_roll, -pitch_rate * sin_roll]
}

/// Specific force at the pivot, body axes, m/s²: the pivot rests, so gravity's reaction is all there is.
pub(crate) fn specific_force_body_m_s2(state: &GimbalState, gravity_m_s2: f64) -> [f64; 3] {
    let (sin_roll, cos_roll) = libm::sincos(state[0]);
    let (sin_pitch, cos_pitch) = libm::sincos(state[1]);
    [gravity_m_s2 * sin_pitch, -gravity_m_s2 * cos_pitch * sin_roll, -gravity_m_s2 * cos_pitch * cos_roll]
}
