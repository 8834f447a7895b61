//! A minute of flight as the board is configured: hover, and what the pilot asks between.

use shared_control::config::Config;
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::mpc::{HORIZON, Mpc, MpcState};
use shared_control::params::{Params, Rig};
use shared_control::setup::Setup;
use shared_control::signals::{ArmingRequest, RawImuSample, Setpoint, StepInput};
use sil_host::effects::{RotorVibration, WeakMotor};
use sil_host::model::{self, VehicleModel};
use sil_host::plant::Plant;
use sil_host::sensors::Sensors;
use sil_host::sensors::imu::GYRO_COUNTS_PER_RAD_S;
use sil_host::sensors::random::RandomStream;

const TICK_US: u64 = 500;
const SAMPLE_US: u64 = 1000;
const STEP_US: u64 = 2500;
/// At rest, so that the gyro is calibrated, and armed; then the motors run up.
const ARM_US: u64 = 2_000_000;
const THROTTLE_US: u64 = 2_100_000;
const RELEASE_US: u64 = 2_200_000;
/// Drag of the free vehicle's rotors over its mass, 1/s: what Faessler, Franchi and Scaramuzza (RA-L 3(2), 2018)
/// identified, 0.4 to 0.5, and what the estimator begins with; the vehicle's own differs by up to 30 %.
const ROTOR_DRAG_1_S: f64 = 0.45;
/// Rate over acceleration of the vibration, rad/s per m/s^2, where rotors push at the ends of their arms: l m w/(I w^2)
/// of the F450 about roll at its hover in free flight.
const RATE_PER_ACCELERATION_S_M: f64 = 0.226 * core::f64::consts::FRAC_1_SQRT_2 * 1.2 / (0.0115 * 516.0) / 4.0;

/// What the pilot asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Manoeuvre {
    /// Hover and steps of 20 degrees in roll and pitch, by turns, 2 s each.
    Steps,
    /// Hover for so long, then 30 degrees of roll for 3 s; the end of the flight.
    HeldTilt {
        /// Seconds.
        after_s: f64,
    },
}

/// Roll and pitch, degrees, each for [`SEGMENT_US`], again and again; hover between.
const POSITIONS_DEG: [(f32, f32); 4] = [(20.0, 0.0), (0.0, -20.0), (-20.0, 0.0), (0.0, 20.0)];
const SEGMENT_US: u64 = 2_000_000;
const STEPS_S: f64 = 60.0;
const HELD_DEG: f32 = 30.0;
const HELD_S: f64 = 3.0;

/// What is wrong with vehicle and sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trouble {
    /// Peak of the vibration at hover, m/s^2.
    pub vibration_m_s2: f64,
    /// Drift of each gyro axis from take-off on, deg/s.
    pub drift_deg_s: f64,
    /// The free vehicle's rotor drag over what the estimator begins with; within 30 % of it where none is given.
    pub drag_factor: Option<f64>,
    /// Of noise, the signs of the drift and, free, how far the rotors' drag is from what is known of it.
    pub seed: u64,
}

/// The vehicle, its sensors with all that is wrong about them, and its core.
pub struct ShakenFlight {
    plant: Plant,
    sensors: Sensors,
    drift_counts: [f64; 3],
    /// What rounding has kept back of the drift.
    drift_left: [f64; 3],
    config: Config,
    mpc: Mpc<HORIZON>,
    state: State,
    hover_throttle: f32,
    manoeuvre: Manoeuvre,
}

impl ShakenFlight {
    /// On the ground, flown by the cascade without notches.
    ///
    /// # Panics
    /// If the nominal vehicle can't be flown.
    pub fn new(rig: Rig, manoeuvre: Manoeuvre, trouble: &Trouble) -> Self {
        Self::flown_by(&Params { rig, gyro_notches: false, ..Params::DEFAULT }, manoeuvre, trouble)
    }

    /// The same as an owner has chosen.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn flown_by(params: &Params, manoeuvre: Manoeuvre, trouble: &Trouble) -> Self {
        let rig = params.rig;
        let setup = Setup::new(params).expect("choices of the table");
        let mpc = Mpc::prepare_shorter(params.control_horizon.into(), &setup.mpc).expect("any choice of the table");
        let mut model = VehicleModel::nominal(match rig {
            Rig::Gimbal => model::Rig::Gimbal,
            Rig::Free => model::Rig::Free,
        });
        let mut draws = RandomStream::new(trouble.seed, "trouble");
        let [hover_rad_s, ..] = Plant::new(&model).truth().motor_speed_rad_s;
        let drawn_factor = 0.7 + 0.6 * draws.uniform();
        if rig == Rig::Free {
            model = model.with_rotor_drag(trouble.drag_factor.unwrap_or(drawn_factor) * ROTOR_DRAG_1_S);
        }
        let peak_m_s2 = trouble.vibration_m_s2;
        let peak_rad_s = RATE_PER_ACCELERATION_S_M * peak_m_s2;
        model.effects.push(RotorVibration { peak_m_s2, peak_rad_s, at_rad_s: hover_rad_s }.into());
        // no two motors lift alike, else their rotors would turn at one speed and stand to one another as they began
        for motor in 1..=4 {
            model.effects.push(WeakMotor { motor, scale: 1.0 + 0.03 * draws.normal() }.into());
        }
        let mut sign = || if draws.uniform() < 0.5 { -1.0 } else { 1.0 };
        let drift_counts = trouble.drift_deg_s.to_radians() * GYRO_COUNTS_PER_RAD_S;
        Self {
            plant: Plant::new(&model),
            sensors: Sensors::new(&model.noise, trouble.seed).with_effects(&model.effects),
            drift_counts: core::array::from_fn(|_| sign() * drift_counts),
            drift_left: [0.0; 3],
            config: setup.config,
            mpc,
            state: State::default(),
            hover_throttle: model.base_command as f32,
            manoeuvre,
        }
    }

    /// Flies; the angle between the true and the estimated vertical at each step since it was let go, degrees.
    pub fn errors_deg(self) -> Vec<f64> {
        let mut errors_deg = Vec::new();
        self.fly(|plant, output, _| {
            let q = output.estimate.q_world_from_body;
            errors_deg.push(tilt_between_deg(plant.truth().q_world_from_body, [q.w, q.i, q.j, q.k]));
        });
        errors_deg
    }

    /// Flies and shows each step since it was let go: the vehicle, the step, and what the core keeps after it.
    pub fn fly(mut self, mut see: impl FnMut(&Plant, &StepOutput, &State)) {
        let (mut input, mut mpc_state) = (StepInput::default(), MpcState::new());
        for now_us in (0..RELEASE_US + self.flight_us()).step_by(TICK_US as usize) {
            if now_us.is_multiple_of(SAMPLE_US) {
                // never more than three a step
                let _ = input.imu.push(self.sample(now_us));
            }
            if now_us.is_multiple_of(STEP_US) {
                (input.time_us, input.setpoint, input.arming) = (now_us, self.setpoint(now_us), request(now_us));
                let output = FlightCore::fast(&self.config, &mut self.state, &input);
                let request = FlightCore::follow(&self.config, &mut self.state, &output);
                input.plan = request.map(|request| FlightCore::plan(&self.mpc, &mut mpc_state, &request));
                input.imu.clear();
                self.plant.set_commands(output.mix.commands.0.map(f64::from));
                if now_us >= RELEASE_US {
                    see(&self.plant, &output, &self.state);
                }
            }
            if now_us >= RELEASE_US {
                self.plant.advance(TICK_US as f64 * 1e-6);
            }
        }
    }

    fn flight_us(&self) -> u64 {
        let duration_s = match self.manoeuvre {
            Manoeuvre::Steps => STEPS_S,
            Manoeuvre::HeldTilt { after_s } => after_s + HELD_S,
        };
        (duration_s * 1e6) as u64
    }

    fn sample(&mut self, now_us: u64) -> RawImuSample {
        let mut sample = self.sensors.imu(&self.plant, now_us);
        if now_us >= RELEASE_US {
            for axis in 0..3 {
                // parts of a count add up
                let drift = self.drift_left[axis] + self.drift_counts[axis];
                self.drift_left[axis] = drift - drift.round();
                sample.gyro_counts[axis] = sample.gyro_counts[axis].saturating_add(drift.round() as i16);
            }
        }
        sample
    }

    fn setpoint(&self, now_us: u64) -> Setpoint {
        if now_us < THROTTLE_US {
            return Setpoint::default();
        }
        let flown_us = now_us.saturating_sub(RELEASE_US);
        let segment = (flown_us / SEGMENT_US) as usize;
        let (roll_deg, pitch_deg) = match self.manoeuvre {
            Manoeuvre::Steps if segment % 2 == 1 => POSITIONS_DEG[segment / 2 % POSITIONS_DEG.len()],
            Manoeuvre::HeldTilt { after_s } if flown_us as f64 * 1e-6 >= after_s => (HELD_DEG, 0.0),
            Manoeuvre::Steps | Manoeuvre::HeldTilt { .. } => (0.0, 0.0),
        };
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
        let calm = Trouble { vibration_m_s2: 0.0, drift_deg_s: 0.0, drag_factor: None, seed: 1 };
        let errors_deg = ShakenFlight::new(Rig::Gimbal, Manoeuvre::Steps, &calm).errors_deg();
        assert_eq!(errors_deg.len(), (STEPS_S * 1e6) as usize / STEP_US as usize);
        let worst_deg = errors_deg.into_iter().fold(0.0, f64::max);
        assert!(worst_deg < 1.0, "{worst_deg}");
    }
}
