//! What the log shows of a state: docs/effects.md, "Exactly how they enter".

use crate::prediction::body::{Body, Turning};

/// What the sensors make of the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sensors {
    /// Added to the gyro, (x, y, z), rad/s.
    pub(crate) gyro_bias_rad_s: [f64; 3],
    /// Reported over true rate.
    pub(crate) gyro_scale: [f64; 3],
    /// How old the reported attitude is, s.
    pub(crate) attitude_delay_s: f64,
    /// How far the sensor is turned about the body's z axis, rad.
    pub(crate) yaw_rad: f64,
}

impl Sensors {
    /// The truth.
    pub(crate) const NOMINAL: Sensors =
        Sensors { gyro_bias_rad_s: [0.0; 3], gyro_scale: [1.0; 3], attitude_delay_s: 0.0, yaw_rad: 0.0 };

    /// Reported body rates.
    pub(crate) fn rate_rad_s(&self, body: &Body, state: &Turning) -> [f64; 3] {
        let [p, q, r] = body.rate_body_rad_s(state);
        let turned = if self.yaw_rad == 0.0 {
            [p, q, r]
        } else {
            let (sin, cos) = libm::sincos(self.yaw_rad);
            [cos * p + sin * q, cos * q - sin * p, r]
        };
        core::array::from_fn(|axis| self.gyro_scale[axis] * turned[axis] + self.gyro_bias_rad_s[axis])
    }

    /// Reported specific force of a felt one, m/s^2.
    pub(crate) fn force_m_s2(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.yaw_rad);
        [cos * x + sin * y, cos * y - sin * x, z]
    }

    /// The way back from reported angles and rates to those of the body, but for the delay.
    pub(crate) fn undone(&self, angle_rad: [f64; 3], rate_rad_s: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let [p, q, r] =
            core::array::from_fn(|axis| (rate_rad_s[axis] - self.gyro_bias_rad_s[axis]) / self.gyro_scale[axis]);
        let back = Sensors { yaw_rad: -self.yaw_rad, ..Sensors::NOMINAL };
        let [roll, pitch, yaw] = angle_rad;
        let (sin, cos) = libm::sincos(self.yaw_rad);
        (back.angle_rad(&[roll, pitch, yaw, 0.0, 0.0, 0.0]), [cos * p - sin * q, cos * q + sin * p, r])
    }

    /// Reported angles of the attitude that a state has: Euler angles of `R_world_body R_z(yaw)`.
    pub(crate) fn angle_rad(&self, state: &Turning) -> [f64; 3] {
        let [roll, pitch, yaw, ..] = *state;
        if self.yaw_rad == 0.0 {
            return [roll, pitch, yaw];
        }
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (libm::sincos(roll), libm::sincos(pitch));
        let (sin, cos) = libm::sincos(self.yaw_rad);
        // the third row of the rotation, gravity's direction in the body, tells roll and pitch
        let down = [-sin_pitch, cos_pitch * sin_roll, cos_pitch * cos_roll];
        let turned = [cos * down[0] + sin * down[1], cos * down[1] - sin * down[0], down[2]];
        let reported_pitch = -libm::asin(turned[0].clamp(-1.0, 1.0));
        // the sensor's x axis on the ground, seen from the body's heading
        let heading = libm::atan2(sin * cos_roll, cos * cos_pitch + sin * sin_roll * sin_pitch);
        [libm::atan2(turned[1], turned[2]), reported_pitch, yaw + heading]
    }
}
