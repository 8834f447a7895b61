//! Rig A, the thesis' testbed: the body turns about a roll rod inside a pitch ring; yaw is locked and the pivot fixed.
//!
//! Generalised coordinates phi (roll), theta (pitch); kinetic energy `T = 1/2 I_xx phi'^2 + 1/2 J(phi) theta'^2 + P p
//! q`:
//! - `J(phi) = I_ring + I_yy cos^2 phi + I_zz sin^2 phi`
//! - `I_xx phi'' + P cos phi theta'' = tau_x + 1/2 J'(phi) theta'^2 + Q_phi`
//! - `P cos phi phi'' + J(phi) theta'' = tau_y cos phi - tau_z sin phi - J'(phi) phi' theta' + P sin phi phi'^2 +
//!   Q_theta`
//! - gyro: `p = phi'`, `q = theta' cos phi`, `r = -theta' sin phi`
//!
//! P = I_xy is 0 in the nominal body. Roll is handed in as (sine, cosine), angles' rates as [phi', theta'].

use super::BodyChange;

/// The gimbal's inertias, ready for the equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gimbal {
    ixx: f64,
    per_ixx: f64,
    /// J(phi) = j_level + j_tilt sin^2 phi
    j_level: f64,
    j_tilt: f64,
    /// P
    product_xy: f64,
}

impl Gimbal {
    /// Of a body's principal moments and the ring's about pitch, kg m².
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

    /// phi'' and theta'', rad/s², under generalised moments about roll and pitch, N m.
    #[inline]
    pub(crate) fn acceleration_rad_s2(&self, roll: (f64, f64), rate_rad_s: [f64; 2], moment_nm: [f64; 2]) -> [f64; 2] {
        let ((sin_roll, cos_roll), [roll_rate, pitch_rate]) = (roll, rate_rad_s);
        let j = self.j_level + self.j_tilt * sin_roll * sin_roll;
        let j_slope = 2.0 * self.j_tilt * sin_roll * cos_roll;
        let roll_nm = moment_nm[0] + 0.5 * j_slope * pitch_rate * pitch_rate;
        let pitch_nm = moment_nm[1] - j_slope * roll_rate * pitch_rate;
        if self.product_xy == 0.0 {
            return [roll_nm * self.per_ixx, pitch_nm / j];
        }
        let pitch_nm = pitch_nm + self.product_xy * sin_roll * roll_rate * roll_rate;
        let coupling = self.product_xy * cos_roll;
        let per_determinant = 1.0 / (self.ixx * j - coupling * coupling);
        [
            (j * roll_nm - coupling * pitch_nm) * per_determinant,
            (self.ixx * pitch_nm - coupling * roll_nm) * per_determinant,
        ]
    }

    /// The generalised moments of a torque about the body's axes, N m.
    #[inline]
    pub(crate) fn moment_nm((sin_roll, cos_roll): (f64, f64), [tau_x, tau_y, tau_z]: [f64; 3]) -> [f64; 2] {
        [tau_x, tau_y * cos_roll - tau_z * sin_roll]
    }

    /// Body rates (p, q, r), rad/s.
    #[inline]
    pub(crate) fn rate_body_rad_s((sin_roll, cos_roll): (f64, f64), [roll_rate, pitch_rate]: [f64; 2]) -> [f64; 3] {
        [roll_rate, pitch_rate * cos_roll, -pitch_rate * sin_roll]
    }

    /// Of body rates the part that the axes allow.
    pub(crate) fn rate_rad_s((sin_roll, cos_roll): (f64, f64), [p, q, r]: [f64; 3]) -> [f64; 2] {
        [p, q * cos_roll - r * sin_roll]
    }

    /// Specific force at the pivot, body axes, m/s²: the pivot rests, so gravity's reaction is all there is.
    pub(crate) fn specific_force_body_m_s2([roll_rad, pitch_rad]: [f64; 2], gravity_m_s2: f64) -> [f64; 3] {
        let (sin_roll, cos_roll) = libm::sincos(roll_rad);
        let (sin_pitch, cos_pitch) = libm::sincos(pitch_rad);
        [gravity_m_s2 * sin_pitch, -gravity_m_s2 * cos_pitch * sin_roll, -gravity_m_s2 * cos_pitch * cos_roll]
    }
}
