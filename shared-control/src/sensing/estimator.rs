//! Attitude and gyro bias from gyro and accelerometer.
//!
//! The gyro turns the attitude; the accelerometer says where down is. At rest, motors off, that is a complementary
//! filter on the rotation group (Mahony, Hamel, Pflimlin, IEEE TAC 53(5), 2008, equation 32): with the down direction
//! measured (d = -f / |f|) and predicted (d^ = R^T z), e = d x d^,
//!
//! ```text
//!   R' = R [gyro - b + k_P w e]x
//! ```
//! where w falls to zero as |f| leaves g, and the bias b is the gyro's mean. The first usable sample sets roll and
//! pitch outright. While motors turn the accelerometer feels what they do, so that tilt and bias come from what it
//! should feel: [`crate::sensing::levelling`]. Heading has no reference here and drifts with the bias about the
//! vertical.

use nalgebra::{UnitQuaternion, Vector3};

use crate::elementary::{asin, atan2, larger, magnitude, sqrt};
use crate::frames::{EulerAngles, down_in_body, normalized, q_from_rotation_vector, q_world_from_euler};
use crate::record::state_words::StateWords;
use crate::sensing::gyro_bias::{GyroBias, GyroBiasConfig};
use crate::sensing::imu::{ImuStep, all_finite, seconds_between};
use crate::sensing::levelling::{Levelling, LevellingConfig, Support};
use crate::signals::AttitudeEstimate;

/// Gains and limits of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorConfig {
    /// Gravity, m/s^2.
    pub gravity_m_s2: f32,
    /// What is expected of a flight.
    pub levelling: LevellingConfig,
    /// k_P at rest, 1/s.
    pub rest_attitude_1_s: f32,
    /// The gyro's bias.
    pub gyro_bias: GyroBiasConfig,
    /// Relative deviation of |f| from g at which the accelerometer is ignored at rest.
    pub accel_gate: f32,
    /// The estimate is invalid when no sample came for this long, s.
    pub stale_after_s: f32,
}

impl EstimatorConfig {
    /// At rest half a second.
    pub const NOMINAL: EstimatorConfig = EstimatorConfig {
        gravity_m_s2: 9.806_65,
        levelling: LevellingConfig::NOMINAL,
        rest_attitude_1_s: 2.0,
        gyro_bias: GyroBiasConfig::NOMINAL,
        accel_gate: 0.15,
        stale_after_s: 0.05,
    };
}

/// How well the tilt is known after a gap in flight that nothing bridged, rad.
const GAP_TILT_STD_RAD: f32 = 0.1;

/// What the filter remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorState {
    q_world_from_body: UnitQuaternion<f32>,
    last_sample_us: Option<u64>,
    /// Since motors turn.
    levelling: Levelling,
    /// Do they?
    carried: bool,
}

impl Default for EstimatorState {
    fn default() -> Self {
        Self {
            q_world_from_body: UnitQuaternion::identity(),
            last_sample_us: None,
            levelling: Levelling::begin(&LevellingConfig::NOMINAL, LevellingConfig::NOMINAL.tilt_std_rad),
            carried: false,
        }
    }
}

impl EstimatorState {
    /// Forgets roll and pitch; the next usable sample sets them, as the very first does.
    pub fn level_anew(&mut self) {
        self.last_sample_us = None;
    }

    /// Goes on from another attitude, by another gyro.
    pub fn set_attitude(&mut self, q_world_from_body: UnitQuaternion<f32>) {
        self.q_world_from_body = q_world_from_body;
        self.carried = false;
    }

    /// What the levelling knows of the flight.
    pub fn levelling(&self) -> &Levelling {
        &self.levelling
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { q_world_from_body, last_sample_us, levelling, carried } = self;
        words.rotation(q_world_from_body);
        words.optional_time_us(*last_sample_us);
        levelling.record(words);
        words.word(u32::from(*carried));
    }
}

/// One step of the filter with an IMU and that IMU's gyro bias. `time_us` is the step's time; it only decides whether
/// samples stay away. `support` is what carries a vehicle whose motors turn; none at rest.
pub fn update(
    config: &EstimatorConfig,
    state: &mut EstimatorState,
    gyro: &mut GyroBias,
    imu: &ImuStep,
    time_us: u64,
    support: Option<Support>,
) -> AttitudeEstimate {
    if imu.is_usable() {
        let down = measured_down(config, &imu.specific_force_m_s2);
        match (state.last_sample_us, imu.after_gap, down, support) {
            (None, _, None, _) => {}
            (None, _, Some((down_body, _)), _) => {
                state.q_world_from_body = level_attitude(&down_body, state);
                state.last_sample_us = Some(time_us);
            }
            // only on the ground: in flight the accelerometer would call the thrust's direction down
            (Some(_), true, Some((down_body, _)), None) => {
                state.q_world_from_body = level_attitude(&down_body, state);
                gyro.moved();
                state.last_sample_us = Some(time_us);
            }
            (Some(_), _, _, Some(support)) => {
                fly(config, state, gyro, imu, support);
                state.last_sample_us = Some(time_us);
            }
            (Some(_), _, down, None) => {
                rest(config, state, gyro, imu, down);
                state.last_sample_us = Some(time_us);
            }
        }
    }
    state.carried &= support.is_some();
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

fn rest(
    config: &EstimatorConfig,
    state: &mut EstimatorState,
    gyro: &mut GyroBias,
    imu: &ImuStep,
    down: Option<(Vector3<f32>, f32)>,
) {
    gyro.average_at_rest(&config.gyro_bias, imu, down.map(|(down_body, _)| down_body));
    let mut rotation_rad = imu.rotation_rad - gyro.bias_rad_s() * imu.duration_s;
    if let Some((down_body, weight)) = down {
        let error = down_body.cross(&down_in_body(&state.q_world_from_body));
        rotation_rad += error * (config.rest_attitude_1_s * weight * imu.duration_s);
    }
    state.q_world_from_body = turned(&state.q_world_from_body, &rotation_rad);
}

fn fly(config: &EstimatorConfig, state: &mut EstimatorState, gyro: &mut GyroBias, imu: &ImuStep, support: Support) {
    gyro.moved();
    if imu.after_gap {
        state.levelling = Levelling::begin(&config.levelling, GAP_TILT_STD_RAD);
    } else if !state.carried {
        state.levelling = Levelling::begin(&config.levelling, config.levelling.tilt_std_rad);
    }
    state.carried = true;
    let before = state.q_world_from_body;
    let found = state.levelling.update(&config.levelling, config.gravity_m_s2, &before, imu, support);
    state.q_world_from_body = turned(&before, &(imu.rotation_rad - gyro.bias_rad_s() * imu.duration_s));
    if let Some(found) = found {
        let correction = q_from_rotation_vector(&found.tilt_rad);
        state.q_world_from_body = normalized((correction * state.q_world_from_body).into_inner());
        gyro.correct(&config.gyro_bias, found.bias_rad_s);
    }
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
