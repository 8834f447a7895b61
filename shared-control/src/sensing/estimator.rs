//! Attitude and gyro bias from gyro and accelerometer: a complementary filter on the rotation group.
//!
//! Mahony, Hamel, Pflimlin, "Nonlinear complementary filters on the special orthogonal group", IEEE TAC 53(5), 2008,
//! equation 32 (explicit filter with bias): with the down direction measured (d = -f / |f|) and predicted
//! (d^ = R^T z), e = d x d^,
//!
//! ```text
//!   R' = R [gyro - b + k_P w e]x          b' = -k_I w e
//! ```
//! Departures: w falls to zero as |f| leaves g (a vehicle that accelerates says nothing about down), the bias is
//! bounded, and the first usable sample sets roll and pitch outright. In flight the accelerometer feels the thrust,
//! which points along the body's own z axis whatever the tilt, so it is followed only as fast as drift needs. At rest,
//! motors off and the gyro quiet, the gyro reads its bias and nothing else: the bias is its mean, and level is followed
//! quickly. Heading has no reference here and drifts with the bias about the vertical.

use nalgebra::{UnitQuaternion, Vector3};

use crate::elementary::{asin, atan2, larger, magnitude, sqrt};
use crate::frames::{EulerAngles, down_in_body, normalized, q_from_rotation_vector, q_world_from_euler};
use crate::record::state_words::StateWords;
use crate::sensing::gyro_bias::{GyroBias, GyroBiasConfig};
use crate::sensing::imu::{ImuStep, all_finite, seconds_between};
use crate::signals::AttitudeEstimate;

/// Gains and limits of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorConfig {
    /// Gravity, m/s^2.
    pub gravity_m_s2: f32,
    /// k_P in flight: how fast the accelerometer pulls the attitude, 1/s.
    pub flight_attitude_1_s: f32,
    /// k_I in flight: how fast the bias is learnt, 1/s^2.
    pub flight_bias_1_s2: f32,
    /// k_P at rest, 1/s.
    pub rest_attitude_1_s: f32,
    /// The gyro's bias.
    pub gyro_bias: GyroBiasConfig,
    /// Relative deviation of |f| from g at which the accelerometer is ignored.
    pub accel_gate: f32,
    /// The estimate is invalid when no sample came for this long, s.
    pub stale_after_s: f32,
}

impl EstimatorConfig {
    /// In flight critically damped with 20 s (k_P = 2 / T, k_I = 1 / T^2): a tilt of 30 degrees held for 2 s, all of it
    /// seen as level by the accelerometer, costs 5 degrees at worst; integrated gyro noise of 0.01 rad/s at 1 kHz stays
    /// below 1 mrad. At rest half a second.
    pub const NOMINAL: EstimatorConfig = EstimatorConfig {
        gravity_m_s2: 9.806_65,
        flight_attitude_1_s: 0.1,
        flight_bias_1_s2: 0.0025,
        rest_attitude_1_s: 2.0,
        gyro_bias: GyroBiasConfig::NOMINAL,
        accel_gate: 0.15,
        stale_after_s: 0.05,
    };
}

/// What the filter remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorState {
    q_world_from_body: UnitQuaternion<f32>,
    last_sample_us: Option<u64>,
}

impl Default for EstimatorState {
    fn default() -> Self {
        Self { q_world_from_body: UnitQuaternion::identity(), last_sample_us: None }
    }
}

impl EstimatorState {
    /// Forgets roll and pitch; the next usable sample sets them, as the very first does.
    pub fn level_anew(&mut self) {
        self.last_sample_us = None;
    }

    /// Goes on from another attitude.
    pub fn set_attitude(&mut self, q_world_from_body: UnitQuaternion<f32>) {
        self.q_world_from_body = q_world_from_body;
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { q_world_from_body, last_sample_us } = self;
        words.rotation(q_world_from_body);
        words.optional_time_us(*last_sample_us);
    }
}

/// One step of the filter with an IMU and that IMU's gyro bias. `time_us` is the step's time; it only decides whether
/// samples stay away.
pub fn update(
    config: &EstimatorConfig,
    state: &mut EstimatorState,
    gyro: &mut GyroBias,
    imu: &ImuStep,
    time_us: u64,
    in_flight: bool,
) -> AttitudeEstimate {
    if imu.is_usable() {
        let down = measured_down(config, &imu.specific_force_m_s2);
        match (state.last_sample_us, imu.after_gap, down) {
            (None, _, None) => {}
            (None, _, Some((down_body, _))) => {
                state.q_world_from_body = level_attitude(&down_body, state);
                state.last_sample_us = Some(time_us);
            }
            // only on the ground: in flight the accelerometer would call the thrust's direction down
            (Some(_), true, Some((down_body, _))) if !in_flight => {
                state.q_world_from_body = level_attitude(&down_body, state);
                gyro.moved();
                state.last_sample_us = Some(time_us);
            }
            (Some(_), _, down) => {
                if in_flight {
                    gyro.moved();
                } else {
                    gyro.average_at_rest(&config.gyro_bias, imu, down.map(|(down_body, _)| down_body));
                }
                predict_and_correct(config, state, gyro, imu, down, in_flight);
                state.last_sample_us = Some(time_us);
            }
        }
    }
    let fresh = match state.last_sample_us {
        // a clock that ran back makes nothing fresh
        Some(last) => time_us >= last && seconds_between(last, time_us) <= config.stale_after_s,
        None => false,
    };
    let rate_body_rad_s = imu.rate_body_rad_s - gyro.bias_rad_s();
    AttitudeEstimate {
        q_world_from_body: state.q_world_from_body,
        rate_body_rad_s: if all_finite(&rate_body_rad_s) { rate_body_rad_s } else { Vector3::zeros() },
        gyro_bias_rad_s: gyro.bias_rad_s(),
        valid: fresh,
    }
}

fn predict_and_correct(
    config: &EstimatorConfig,
    state: &mut EstimatorState,
    gyro: &mut GyroBias,
    imu: &ImuStep,
    down: Option<(Vector3<f32>, f32)>,
    in_flight: bool,
) {
    let dt_s = imu.duration_s;
    let mut rotation = imu.rotation_rad - gyro.bias_rad_s() * dt_s;
    if let Some((down_body, weight)) = down {
        let error = down_body.cross(&down_in_body(&state.q_world_from_body));
        let gain_1_s = if in_flight { config.flight_attitude_1_s } else { config.rest_attitude_1_s };
        rotation += error * (gain_1_s * weight * dt_s);
        if in_flight {
            gyro.correct(&config.gyro_bias, error * (-config.flight_bias_1_s2 * weight * dt_s));
        }
    }
    state.q_world_from_body = turned(&state.q_world_from_body, &rotation);
}

/// An attitude after a rotation, rad, about the body's axes.
pub fn turned(q_world_from_body: &UnitQuaternion<f32>, rotation_rad: &Vector3<f32>) -> UnitQuaternion<f32> {
    normalized((q_world_from_body * q_from_rotation_vector(rotation_rad)).into_inner())
}

/// Direction of down in the body frame as the accelerometer has it, and how much it may be believed (0..1); none
/// where the specific force is too far from gravity.
pub fn measured_down(config: &EstimatorConfig, specific_force: &Vector3<f32>) -> Option<(Vector3<f32>, f32)> {
    let norm = sqrt(specific_force.dot(specific_force));
    let deviation = magnitude(norm / config.gravity_m_s2 - 1.0);
    let weight = larger(0.0, 1.0 - deviation / config.accel_gate);
    (norm > 0.0 && weight > 0.0).then(|| (specific_force * (-1.0 / norm), weight))
}

/// Roll and pitch from the down direction, heading as it was.
fn level_attitude(down_body: &Vector3<f32>, state: &EstimatorState) -> UnitQuaternion<f32> {
    q_world_from_euler(EulerAngles {
        roll_rad: atan2(down_body.y, down_body.z),
        pitch_rad: asin(-down_body.x),
        yaw_rad: crate::frames::euler_from_q(&state.q_world_from_body).yaw_rad,
    })
}

#[cfg(test)]
mod tests;
