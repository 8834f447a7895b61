//! What a vehicle that spins feels of the air, in the mean over a whole turn.
//!
//! A low-pass of the force in body axes turns what stands still in the world: by 41 degrees at 16 rad/s. And an IMU
//! that does not sit in the axis of the spin feels the spin: 5 m/s^2 at 2 cm, for ever along the same axis of the body.
//! In the world, summed over a whole turn, the first is not turned and the second is gone.

use nalgebra::{UnitQuaternion, Vector3};

use crate::elementary::{limit, magnitude};
use crate::record::state_words::StateWords;
use crate::sensing::imu::ImuStep;

/// From this rate about the body's z on it is a spin, rad/s: a turn takes a second and a half.
const SPINS_FROM_RAD_S: f32 = 4.0;
const TURN_RAD: f32 = 2.0 * core::f32::consts::PI;

/// A turn so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WholeTurn {
    /// Integral of the force across the thrust, world, m/s.
    force_m_s: Vector3<f32>,
    /// The same of the velocity, m.
    way_m: Vector3<f32>,
    turned_rad: f32,
    lasted_s: f32,
}

/// A whole turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mean {
    /// Specific force across the thrust, world, m/s^2.
    pub force_m_s2: Vector3<f32>,
    /// Velocity across the thrust, world, m/s.
    pub velocity_m_s: Vector3<f32>,
    /// How long it took, s.
    pub lasted_s: f32,
}

impl WholeTurn {
    pub(super) fn record(&self, words: &mut StateWords) {
        let Self { force_m_s, way_m, turned_rad, lasted_s } = self;
        words.vector(force_m_s);
        words.vector(way_m);
        words.numbers(&[*turned_rad, *lasted_s]);
    }

    /// One step at an attitude and a velocity, world, m/s. Where it completes a turn, that; what is over begins the
    /// next, since of a turn that is not whole to the step the spin would leave what the wind makes.
    pub(super) fn take(
        &mut self,
        q_world_from_body: &UnitQuaternion<f32>,
        velocity_m_s: &Vector3<f32>,
        imu: &ImuStep,
    ) -> Option<Mean> {
        let turned_rad = magnitude(imu.rotation_rad.z);
        if turned_rad <= SPINS_FROM_RAD_S * imu.duration_s {
            *self = Self::default();
            return None;
        }
        let thrust = q_world_from_body * Vector3::z();
        let across = |vector: Vector3<f32>| vector - thrust * thrust.dot(&vector);
        let step = Self {
            force_m_s: across(q_world_from_body * (imu.specific_force_m_s2 * imu.duration_s)),
            way_m: across(velocity_m_s * imu.duration_s),
            turned_rad,
            lasted_s: imu.duration_s,
        };
        let lacking_rad = TURN_RAD - self.turned_rad;
        if turned_rad < lacking_rad {
            self.add(&step, 1.0);
            return None;
        }
        let share = limit(lacking_rad / turned_rad, 0.0, 1.0);
        self.add(&step, share);
        let Self { force_m_s, way_m, lasted_s, .. } = core::mem::take(self);
        self.add(&step, 1.0 - share);
        let each = 1.0 / lasted_s;
        Some(Mean { force_m_s2: force_m_s * each, velocity_m_s: way_m * each, lasted_s })
    }

    /// Does it spin?
    pub(super) fn goes_on(&self) -> bool {
        self.lasted_s > 0.0
    }

    fn add(&mut self, step: &Self, share: f32) {
        self.force_m_s += step.force_m_s * share;
        self.way_m += step.way_m * share;
        self.turned_rad += step.turned_rad * share;
        self.lasted_s += step.lasted_s * share;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::q_from_rotation_vector;

    /// A vehicle spins at 16 rad/s, level; wind pushes it northwards by 2 m/s^2, and the IMU sits 2 cm ahead and 1 cm
    /// to the left of the axis. The mean over a turn is the wind's.
    #[test]
    fn of_a_whole_turn_the_wind_is_left() {
        let (spin_rad_s, step_s) = (16.0f32, 0.0025f32);
        let (mut turn, mut angle_rad, mut turns) = (WholeTurn::default(), 0.0f32, 0);
        for _ in 0..2000 {
            let q = q_from_rotation_vector(&Vector3::new(0.0, 0.0, angle_rad + 0.5 * spin_rad_s * step_s));
            let wind = q.inverse() * Vector3::new(2.0, 0.0, 0.0);
            let place = Vector3::new(0.02, -0.01, 0.0) * (-spin_rad_s * spin_rad_s);
            let imu = ImuStep {
                samples: 3,
                duration_s: step_s,
                after_gap: false,
                rotation_rad: Vector3::new(0.0, 0.0, spin_rad_s * step_s),
                rate_body_rad_s: Vector3::zeros(),
                specific_force_m_s2: wind + place + Vector3::new(0.0, 0.0, -9.8),
                steady_force_m_s2: Vector3::zeros(),
                vibration_m_s2: Vector3::zeros(),
            };
            angle_rad += spin_rad_s * step_s;
            let mean = turn.take(&q, &Vector3::new(-3.0, 1.0, 5.0), &imu);
            assert!(turn.goes_on());
            let Some(mean) = mean else { continue };
            turns += 1;
            assert!((mean.force_m_s2 - Vector3::new(2.0, 0.0, 0.0)).norm() < 0.002, "{mean:?}");
            assert!((mean.velocity_m_s - Vector3::new(-3.0, 1.0, 0.0)).norm() < 1e-4);
            assert!((mean.lasted_s - TURN_RAD / spin_rad_s).abs() < 1e-5);
        }
        assert_eq!(turns, 12);
    }
}
