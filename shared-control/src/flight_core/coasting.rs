//! Through a gap in the samples in flight: the model goes on where the vehicle was last seen, until samples come again
//! or the gap is too long to be flown through blind.
//!
//! The observer of [`crate::torque_observer`] knows the torque of the motors on its way through their lag, and the
//! disturbance; its prediction of the rates stands in for the gyro, so that the rate loop does not push on against a
//! reading that stands still. When samples come again the estimator makes up for the rotation by itself.

use nalgebra::{UnitQuaternion, Vector3};

use super::euler_motion::EulerMotion;
use crate::config::Config;
use crate::record::state_words::StateWords;
use crate::sensing::estimator::turned;
use crate::sensing::imu::all_finite;
use crate::sensing::imu_health::{ImuFault, ImuHealth};
use crate::sensing::imu_select::ImuFindings;
use crate::signals::AttitudeEstimate;
use crate::torque_observer::ObserverState;

/// Longest time without a sample that a flight is continued for, µs. What the model does not know (a gust of 5 rad/s^2)
/// makes 0.2 rad/s and a quarter of a degree in that time.
pub const COAST_MAX_US: u64 = 40_000;

/// What it remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coasting {
    /// When a sample came last.
    seen_us: u64,
    /// Attitude a step ago.
    q_world_from_body: UnitQuaternion<f32>,
    /// The last step flew without a sample.
    pub(super) coasts: bool,
}

impl Default for Coasting {
    fn default() -> Self {
        Self { seen_us: 0, q_world_from_body: UnitQuaternion::identity(), coasts: false }
    }
}

impl Coasting {
    pub(super) fn record(&self, words: &mut StateWords) {
        let Self { seen_us, q_world_from_body, coasts } = self;
        words.time_us(*seen_us);
        words.rotation(q_world_from_body);
        words.word(u32::from(*coasts));
    }

    /// Attitude and health to fly this step by: those of the IMU, or in a gap the model's. Only missing samples are
    /// stood in for; readings that are wrong are not.
    pub(super) fn bridge(
        &mut self,
        config: &Config,
        observer: &ObserverState,
        imu: &ImuFindings,
        airborne: bool,
        time_us: u64,
    ) -> (AttitudeEstimate, ImuHealth) {
        let missing =
            imu.force_m_s2.is_none() && matches!(imu.health, ImuHealth::Good | ImuHealth::Bad(ImuFault::Stale));
        let within = time_us.saturating_sub(self.seen_us) <= COAST_MAX_US && time_us >= self.seen_us;
        self.coasts = airborne && missing && within;
        if !self.coasts {
            if imu.force_m_s2.is_some() {
                self.seen_us = time_us;
            }
            self.q_world_from_body = imu.estimate.q_world_from_body;
            return (imu.estimate, imu.health);
        }
        let before = AttitudeEstimate { q_world_from_body: self.q_world_from_body, ..imu.estimate };
        let predicted = EulerMotion::of(config, &before).predicted_rate_body_rad_s(config, observer);
        let rate_body_rad_s = if all_finite(&predicted) { predicted } else { Vector3::zeros() };
        self.q_world_from_body = turned(&self.q_world_from_body, &(rate_body_rad_s * config.step_s()));
        let q_world_from_body = self.q_world_from_body;
        (AttitudeEstimate { q_world_from_body, rate_body_rad_s, valid: true, ..imu.estimate }, ImuHealth::Good)
    }
}
