//! How an IMU sits on its vehicle, and what its accelerometer says too much of: found on a vehicle that stands level.
//!
//! A level vehicle feels (0, 0, -g). What its accelerometer says instead is turned there: a board that is not level and
//! an offset across are the same thing to one that stands still, and the same to a pilot. The rest is an offset along
//! the vertical.

use nalgebra::{UnitQuaternion, Vector3};

use crate::elementary::{atan2, magnitude, sqrt};
use crate::frames::{EulerAngles, q_world_from_euler};

/// Largest trim about an axis, rad: 10 degrees, as ArduPilot's AHRS_TRIM.
pub const TRIM_MAX_RAD: f32 = 10.0 / 180.0 * core::f32::consts::PI;
/// Largest offset along the vertical, m/s^2: 0.1 g, where the MPU-6000's product specification (6.2) has 0.08.
pub const OFFSET_MAX_M_S2: f32 = 1.0;
/// Time at rest over which the force is averaged, s, at least.
pub const REST_MIN_S: f32 = 3.0;

/// How an IMU sits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelTrim {
    /// Roll that it shows while the vehicle is level, rad.
    pub roll_rad: f32,
    /// Pitch that it shows while the vehicle is level, rad.
    pub pitch_rad: f32,
    /// What its accelerometer says too much downwards, m/s^2.
    pub down_m_s2: f32,
}

impl LevelTrim {
    /// From the mean force on a vehicle that stands level; none where it is not believable.
    pub fn of_level_vehicle(force_m_s2: &Vector3<f32>, gravity_m_s2: f32) -> Option<Self> {
        let across = sqrt(force_m_s2.y * force_m_s2.y + force_m_s2.z * force_m_s2.z);
        let trim = Self {
            roll_rad: atan2(-force_m_s2.y, -force_m_s2.z),
            pitch_rad: atan2(force_m_s2.x, across),
            down_m_s2: gravity_m_s2 - sqrt(force_m_s2.dot(force_m_s2)),
        };
        let small = |value: f32, most: f32| magnitude(value) <= most;
        let sensible = small(trim.roll_rad, TRIM_MAX_RAD)
            && small(trim.pitch_rad, TRIM_MAX_RAD)
            && small(trim.down_m_s2, OFFSET_MAX_M_S2);
        sensible.then_some(trim)
    }

    /// The same, ready to be applied; none where there is nothing to be done.
    pub fn mounting(&self) -> Option<Mounting> {
        let angles = EulerAngles { roll_rad: self.roll_rad, pitch_rad: self.pitch_rad, yaw_rad: 0.0 };
        let Self { down_m_s2, .. } = *self;
        (*self != Self::default()).then(|| Mounting { body_from_imu: q_world_from_euler(angles), down_m_s2 })
    }
}

/// From an IMU's axes to the vehicle's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    body_from_imu: UnitQuaternion<f32>,
    down_m_s2: f32,
}

impl Mounting {
    /// A rate about the vehicle's axes.
    pub fn rate(&self, rate_rad_s: Vector3<f32>) -> Vector3<f32> {
        self.body_from_imu * rate_rad_s
    }

    /// A force along the vehicle's axes.
    pub fn force(&self, force_m_s2: Vector3<f32>) -> Vector3<f32> {
        self.body_from_imu * force_m_s2 - Vector3::new(0.0, 0.0, self.down_m_s2)
    }

    /// The reverse of [`Self::force`]: what the IMU had said.
    pub fn force_of_imu(&self, force_m_s2: Vector3<f32>) -> Vector3<f32> {
        self.body_from_imu.inverse() * (force_m_s2 + Vector3::new(0.0, 0.0, self.down_m_s2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GRAVITY_M_S2: f32 = 9.81;

    proptest! {
        /// Any board within the limits: the trim that is found brings a level vehicle's force to where it belongs, and
        /// the way back is the way back.
        #[test]
        fn what_is_found_levels_the_vehicle(roll in -0.17f32..0.17, pitch in -0.17f32..0.17, off in -0.9f32..0.9) {
            let angles = EulerAngles { roll_rad: roll, pitch_rad: pitch, yaw_rad: 0.0 };
            let said = q_world_from_euler(angles).inverse() * Vector3::new(0.0, 0.0, off - GRAVITY_M_S2);
            let trim = LevelTrim::of_level_vehicle(&said, GRAVITY_M_S2).unwrap();
            prop_assert!((trim.roll_rad - roll).abs() < 1e-5 && (trim.pitch_rad - pitch).abs() < 1e-5, "{trim:?}");
            prop_assert!((trim.down_m_s2 - off).abs() < 1e-4, "{trim:?}");
            let Some(mounting) = trim.mounting() else { return Ok(()) };
            let level = mounting.force(said);
            prop_assert!((level - Vector3::new(0.0, 0.0, -GRAVITY_M_S2)).norm() < 1e-4, "{level}");
            prop_assert!((mounting.force_of_imu(level) - said).norm() < 1e-4);
            let turning = Vector3::new(1.0, -2.0, 3.0);
            prop_assert!((mounting.rate(turning) - q_world_from_euler(angles) * turning).norm() < 1e-4);
        }
    }

    #[test]
    fn nonsense_is_no_level_vehicle() {
        let found = |force: [f32; 3]| LevelTrim::of_level_vehicle(&force.into(), GRAVITY_M_S2);
        assert!(found([0.0, 0.0, -9.81]).is_some_and(|trim| trim.mounting().is_none()), "nothing to be done");
        for force in [[0.0, 0.0, 9.81], [0.0, 2.0, -9.6], [-2.0, 0.0, -9.6], [0.0, 0.0, -8.7], [0.0, 0.0, -10.9]] {
            assert_eq!(found(force), None, "{force:?}");
        }
        assert_eq!((found([0.0; 3]), found([f32::NAN; 3])), (None, None));
    }
}
