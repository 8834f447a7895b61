//! A minute of flight: hover, and steps of 20 degrees in roll and pitch, by the cascade as the board is configured.

use shared_control::config::Config;
use shared_control::flight_core::{FlightCore, State};
use shared_control::params::{Params, Rig};
use shared_control::setup::Setup;
use shared_control::signals::{ArmingRequest, RawImuSample, Setpoint, StepInput};
use sil_host::model::{self, VehicleModel};
use sil_host::plant::Plant;
use sil_host::sensors::Sensors;
use sil_host::sensors::imu::{ACCEL_COUNTS_PER_M_S2, GYRO_COUNTS_PER_RAD_S, sensor_from_body};

use super::vibration::Vibration;

const TICK_US: u64 = 500;
const SAMPLE_US: u64 = 1000;
const STEP_US: u64 = 2500;
/// At rest, so that the gyro is calibrated, and armed; then the motors run up.
const ARM_US: u64 = 2_000_000;
const THROTTLE_US: u64 = 2_100_000;
const RELEASE_US: u64 = 2_200_000;
const FLIGHT_US: u64 = 60_000_000;
/// Roll and pitch, degrees, each for [`SEGMENT_US`], again and again; hover between.
const POSITIONS_DEG: [(f32, f32); 4] = [(20.0, 0.0), (0.0, -20.0), (-20.0, 0.0), (0.0, 20.0)];
const SEGMENT_US: u64 = 2_000_000;

/// The vehicle, its sensors with all that is wrong about them, and its core.
pub struct ShakenFlight {
    plant: Plant,
    sensors: Sensors,
    vibration: Vibration,
    drift_counts: f64,
    /// What rounding has kept back of the drift.
    drift_left: f64,
    config: Config,
    state: State,
    hover_throttle: f32,
}

impl ShakenFlight {
    /// On the ground.
    ///
    /// # Panics
    /// If the nominal vehicle can't be flown.
    pub fn new(rig: Rig, vibration_m_s2: f64, drift_deg_s: f64) -> Self {
        let model = VehicleModel::nominal(match rig {
            Rig::Gimbal => model::Rig::Gimbal,
            Rig::Free => model::Rig::Free,
        });
        let params = Params { rig, ..Params::DEFAULT };
        let plant = Plant::new(&model);
        let [hover_rad_s, ..] = plant.truth().motor_speed_rad_s;
        Self {
            plant,
            sensors: Sensors::new(&model.noise, 1),
            vibration: Vibration::new(vibration_m_s2, hover_rad_s),
            drift_counts: drift_deg_s.to_radians() * GYRO_COUNTS_PER_RAD_S,
            drift_left: 0.0,
            config: Setup::new(&params).expect("the board's defaults").config,
            state: State::default(),
            hover_throttle: model.base_command as f32,
        }
    }

    /// Flies; the angle between the true and the estimated vertical at each step since it was let go, degrees.
    pub fn errors_deg(mut self) -> Vec<f64> {
        let mut errors_deg = Vec::new();
        let mut input = StepInput::default();
        for now_us in (0..RELEASE_US + FLIGHT_US).step_by(TICK_US as usize) {
            if now_us.is_multiple_of(SAMPLE_US) {
                // never more than three a step
                let _ = input.imu.push(self.sample(now_us));
            }
            if now_us.is_multiple_of(STEP_US) {
                (input.time_us, input.setpoint, input.arming) = (now_us, self.setpoint(now_us), request(now_us));
                let output = FlightCore::fast(&self.config, &mut self.state, &input);
                FlightCore::follow(&self.config, &mut self.state, &output);
                input.imu.clear();
                self.plant.set_commands(output.mix.commands.0.map(f64::from));
                if now_us >= RELEASE_US {
                    let q = output.estimate.q_world_from_body;
                    errors_deg.push(tilt_between_deg(self.plant.truth().q_world_from_body, [q.w, q.i, q.j, q.k]));
                }
            }
            if now_us >= RELEASE_US {
                self.plant.advance(TICK_US as f64 * 1e-6);
            }
        }
        errors_deg
    }

    fn sample(&mut self, now_us: u64) -> RawImuSample {
        let mut sample = self.sensors.imu(&self.plant, now_us);
        if now_us < RELEASE_US {
            return sample;
        }
        let speeds_rad_s = self.plant.truth().motor_speed_rad_s;
        let shaking_m_s2 = self.vibration.sample_m_s2(speeds_rad_s, SAMPLE_US as f64 * 1e-6);
        for (counts, more_m_s2) in sample.accel_counts.iter_mut().zip(sensor_from_body(shaking_m_s2)) {
            // `as` stays at the ends of the range, as the chip does
            *counts = (f64::from(*counts) + more_m_s2 * ACCEL_COUNTS_PER_M_S2).round() as i16;
        }
        // parts of a count add up
        let drift = self.drift_left + self.drift_counts;
        self.drift_left = drift - drift.round();
        for counts in &mut sample.gyro_counts {
            *counts = counts.saturating_add(drift.round() as i16);
        }
        sample
    }

    fn setpoint(&self, now_us: u64) -> Setpoint {
        if now_us < THROTTLE_US {
            return Setpoint::default();
        }
        let segment = (now_us.saturating_sub(RELEASE_US) / SEGMENT_US) as usize;
        let (roll_deg, pitch_deg) =
            if segment % 2 == 1 { POSITIONS_DEG[segment / 2 % POSITIONS_DEG.len()] } else { (0.0, 0.0) };
        let throttle = self.hover_throttle;
        Setpoint { roll_rad: roll_deg.to_radians(), pitch_rad: pitch_deg.to_radians(), throttle, ..Setpoint::default() }
    }
}

fn request(now_us: u64) -> ArmingRequest {
    if now_us == ARM_US { ArmingRequest::Arm } else { ArmingRequest::None }
}

/// Angle between the verticals of two attitudes (w, x, y, z), degrees.
fn tilt_between_deg(truth: [f64; 4], estimate: [f32; 4]) -> f64 {
    let down = |[w, x, y, z]: [f64; 4]| [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z];
    let (a, b) = (down(truth), down(estimate.map(f64::from)));
    let cosine: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_between_verticals_does_not_see_the_heading() {
        let (sin, cos) = libm::sincos(0.25);
        let roll = [cos, sin, 0.0, 0.0];
        assert!((tilt_between_deg(roll, [1.0, 0.0, 0.0, 0.0]) - 0.5_f64.to_degrees()).abs() < 1e-4);
        let yaw = [cos as f32, 0.0, 0.0, sin as f32];
        assert!(tilt_between_deg([1.0, 0.0, 0.0, 0.0], yaw) < 0.05);
    }

    /// Calm and without drift the attitude of a held vehicle that takes off is right to what its noise leaves.
    #[test]
    fn on_the_rig_in_calm_the_attitude_is_right() {
        let errors_deg = ShakenFlight::new(Rig::Gimbal, 0.0, 0.0).errors_deg();
        assert_eq!(errors_deg.len(), (FLIGHT_US / STEP_US) as usize);
        let worst_deg = errors_deg.into_iter().fold(0.0, f64::max);
        assert!(worst_deg < 1.0, "{worst_deg}");
    }
}
