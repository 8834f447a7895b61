//! Rig A, the thesis' testbed: the body turns about a roll rod inside a pitch ring; yaw is locked and the pivot fixed.
//!
//! Generalised coordinates phi (roll), theta (pitch); kinetic energy `T = 1/2 I_xx phi'^2 + 1/2 J(phi) theta'^2`:
//! - `J(phi) = I_ring + I_yy cos^2 phi + I_zz sin^2 phi`
//! - `I_xx phi'' = tau_x + 1/2 J'(phi) theta'^2 + Q_phi`
//! - `J(phi) theta'' = tau_y cos phi - tau_z sin phi - J'(phi) phi' theta' + Q_theta`
//! - gyro: `p = phi'`, `q = theta' cos phi`, `r = -theta' sin phi`

use crate::effects::{BodyChange, Effect, GimbalMotion, Instant};

/// The gimbal's inertias, ready for the equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gimbal {
    ixx: f64,
    per_ixx: f64,
    /// J(phi) = j_level + j_tilt sin^2 phi
    j_level: f64,
    j_tilt: f64,
    /// I_xy, which couples roll and pitch; 0 in the nominal body.
    product_xy: f64,
}

/// Roll, pitch (rad) and their rates (rad/s).
pub(crate) type GimbalState = [f64; 4];

impl Gimbal {
    pub(crate) fn new(inertia_kg_m2: [f64; 3], ring_inertia_kg_m2: f64, change: &BodyChange) -> Self {
        let [ixx, iyy, izz] = inertia_kg_m2;
        let [roll_scale, pitch_scale, _] = change.inertia_scale;
        let ixx = roll_scale * ixx;
        Self {
            ixx,
            per_ixx: 1.0 / ixx,
            j_level: pitch_scale * (ring_inertia_kg_m2 + iyy),
            j_tilt: pitch_scale * (izz - iyy),
            product_xy: change.product_xy_kg_m2,
        }
    }

    /// Rates and accelerations under the body torque (x, y, z), N m.
    #[inline]
    pub(crate) fn derivative(&self, state: &GimbalState, torque_body_nm: [f64; 3]) -> GimbalState {
        let [tau_x, tau_y, tau_z] = torque_body_nm;
        let (sin_roll, cos_roll) = libm::sincos(state[0]);
        self.accelerated(state, sin_roll, cos_roll, [tau_x, tau_y * cos_roll - tau_z * sin_roll])
    }

    /// The same with what effects add.
    pub(crate) fn extended_derivative(
        &self,
        state: &GimbalState,
        torque_body_nm: [f64; 3],
        effects: &[Effect],
        instant: Instant,
    ) -> GimbalState {
        let [roll, pitch, roll_rate, pitch_rate] = *state;
        let [tau_x, tau_y, tau_z] = torque_body_nm;
        let (sin_roll, cos_roll) = libm::sincos(roll);
        let (sin_pitch, cos_pitch) = libm::sincos(pitch);
        let (angle_rad, rate_rad_s) = ([roll, pitch], [roll_rate, pitch_rate]);
        let motion = GimbalMotion { sin_roll, cos_roll, sin_pitch, cos_pitch, angle_rad, rate_rad_s, instant };
        let mut moment = [tau_x, tau_y * cos_roll - tau_z * sin_roll];
        for effect in effects {
            let [roll_nm, pitch_nm] = effect.extension().gimbal_moment_nm(&motion);
            moment[0] += roll_nm;
            moment[1] += pitch_nm;
        }
        self.accelerated(state, sin_roll, cos_roll, moment)
    }

    /// Lagrange's equations under generalised moments (roll, pitch), N m.
    #[inline]
    fn accelerated(&self, state: &GimbalState, sin_roll: f64, cos_roll: f64, moment_nm: [f64; 2]) -> GimbalState {
        let [_, _, roll_rate, pitch_rate] = *state;
        let j = self.j_level + self.j_tilt * sin_roll * sin_roll;
        let j_slope = 2.0 * self.j_tilt * sin_roll * cos_roll;
        let roll_nm = moment_nm[0] + 0.5 * j_slope * pitch_rate * pitch_rate;
        let pitch_nm = moment_nm[1] - j_slope * roll_rate * pitch_rate;
        if self.product_xy == 0.0 {
            return [roll_rate, pitch_rate, roll_nm * self.per_ixx, pitch_nm / j];
        }
        // kinetic energy has P cos phi phi' theta' besides: see the effect `inertia_coupling`
        let pitch_nm = pitch_nm + self.product_xy * sin_roll * roll_rate * roll_rate;
        let coupling = self.product_xy * cos_roll;
        let per_determinant = 1.0 / (self.ixx * j - coupling * coupling);
        [
            roll_rate,
            pitch_rate,
            (j * roll_nm - coupling * pitch_nm) * per_determinant,
            (self.ixx * pitch_nm - coupling * roll_nm) * per_determinant,
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
