//! What effects make of a motion before bias, noise and counts.

use super::attitude::{euler_rad, quaternion_world_from_body};
use super::vibration::Vibration;

/// The links from motion to reading that effects can change: misalignment, then the gyro's scale, then its bias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SensorChain {
    /// Angle of the IMU about the body's z axis, rad; positive turns its x axis from forward to right.
    pub(crate) yaw_rad: f64,
    /// Reported over felt rate (x, y, z).
    pub(crate) gyro_scale: [f64; 3],
    /// Reported rate at rest (x, y, z), rad/s.
    pub(crate) gyro_bias_rad_s: [f64; 3],
    /// By how much reported attitude lags, s.
    pub(crate) attitude_delay_s: f64,
    /// What the rotors do to the IMU; of the whole chip, before it is turned.
    pub(crate) vibration: Vibration,
}

impl Default for SensorChain {
    fn default() -> Self {
        Self {
            yaw_rad: 0.0,
            gyro_scale: [1.0; 3],
            gyro_bias_rad_s: [0.0; 3],
            attitude_delay_s: 0.0,
            vibration: Vibration::default(),
        }
    }
}

impl SensorChain {
    /// What the gyro reports of a body rate.
    pub(crate) fn gyro_rad_s(&self, rate_body_rad_s: [f64; 3]) -> [f64; 3] {
        let felt = self.turned(rate_body_rad_s);
        core::array::from_fn(|axis| self.gyro_scale[axis] * felt[axis] + self.gyro_bias_rad_s[axis])
    }

    /// A body vector in the axes of the turned IMU.
    pub(crate) fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        if self.yaw_rad == 0.0 {
            return [x, y, z];
        }
        let (sin, cos) = libm::sincos(self.yaw_rad);
        [x * cos + y * sin, y * cos - x * sin, z]
    }

    /// Roll, pitch and yaw of the turned IMU: those of R_wb Rz(yaw).
    pub(crate) fn attitude_rad(&self, roll_pitch_yaw_rad: [f64; 3]) -> [f64; 3] {
        if self.yaw_rad == 0.0 {
            return roll_pitch_yaw_rad;
        }
        let [w, x, y, z] = quaternion_world_from_body(roll_pitch_yaw_rad);
        let (sin, cos) = libm::sincos(0.5 * self.yaw_rad);
        // the product with (cos, 0, 0, sin) from the right
        euler_rad([w * cos - z * sin, x * cos + y * sin, y * cos - x * sin, w * sin + z * cos])
    }

    /// The way back from reported angles and rates to those of the body, but for the delay.
    pub(crate) fn undone(&self, angle_rad: [f64; 3], rate_rad_s: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let felt = core::array::from_fn(|axis| (rate_rad_s[axis] - self.gyro_bias_rad_s[axis]) / self.gyro_scale[axis]);
        let back = Self { yaw_rad: -self.yaw_rad, ..Self::default() };
        (back.attitude_rad(angle_rad), back.turned(felt))
    }
}
