//! A quadrotor of 0.03 to 3 kg, as they are built, with motors that differ and a balance that is not quite right.

use shared_control::config::Controller;
use sil_host::axis::Axis;
use sil_host::controller_file::ControllerChoice;
use sil_host::effects::{ActuationDelay, Effect, GyroBias, TorqueBias, WeakMotor};
use sil_host::log::Log;
use sil_host::model::{Mounting, SensorNoise, VehicleModel};
use sil_host::scenario::{Scenario, Waypoint};
use sil_host::sensors::random::RandomStream;
use sil_host::synthesis::Synthesis;
use sil_host::vehicle::propulsion::{GenericRotor, Propulsion};

/// Rows per second that logs have.
const RATES_HZ: [u32; 5] = [100, 200, 400, 500, 1000];
/// The controller's rate, Hz, unless a log is faster.
const CONTROL_HZ: u32 = 400;
/// Length of a flight, s.
const DURATION_S: f64 = 30.0;
const GRAVITY_M_S2: f64 = 9.81;

/// A vehicle of the campaign.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Of the draw, the flight and its noise.
    pub seed: u64,
    /// The vehicle as it is.
    pub model: VehicleModel,
    /// Rows per second of its log.
    pub rate_hz: u32,
    /// True where the log's body axes are forward-left-up.
    pub is_flu: bool,
    /// True where the log's body axes are those of a plus: along two of the arms.
    pub is_plus: bool,
    /// For each of our motors, under which number the log has it, from 0.
    pub order: [usize; 4],
    /// How long it is flown, s.
    pub duration_s: f64,
}

impl Drawn {
    /// The draw of a seed.
    pub fn new(seed: u64) -> Drawn {
        let mut stream = RandomStream::new(seed, "identified vehicle");
        let mut uniform = |low: f64, high: f64| low + (high - low) * stream.uniform();
        // from a Crazyflie to a heavy camera drone, evenly in the logarithm
        let mass_kg = 0.03 * libm::pow(100.0, uniform(0.0, 1.0));
        let arm_m = 0.19 * libm::cbrt(mass_kg) * uniform(0.8, 1.2);
        let ixx = mass_kg * arm_m * arm_m * uniform(0.18, 0.38);
        let iyy = ixx * uniform(0.85, 1.3);
        let izz = (ixx + iyy) * uniform(0.82, 0.94);
        let base_command = uniform(0.38, 0.58);
        // the speed's line meets zero a little below command 0
        let (slope, below) = (2000.0, uniform(0.02, 0.3));
        let hover_rad_s = slope * (below + base_command);
        let lift_n_s2 = 0.25 * mass_kg * GRAVITY_M_S2 / (hover_rad_s * hover_rad_s);
        let rotor = GenericRotor {
            speed_offset_rad_s: slope * below,
            speed_slope_rad_s: slope,
            time_constant_s: uniform(0.02, 0.06),
            lift_n_s2,
            reaction_torque_nm_s2: lift_n_s2 * arm_m * uniform(0.06, 0.14),
        };
        let mut effects: Vec<Effect> = vec![ActuationDelay { delay_s: uniform(0.0, 0.012) }.into()];
        effects.extend((1..=4).map(|motor| Effect::from(WeakMotor { motor, scale: uniform(0.93, 1.07) })));
        for axis in Axis::ALL {
            // a hundredth of what the motors could do about it, and what a gyro drifts in a flight
            let lever_m = [arm_m, arm_m, 0.1 * arm_m][axis.index()];
            let torque_nm = 0.01 * mass_kg * GRAVITY_M_S2 * lever_m * uniform(-1.0, 1.0);
            effects.push(TorqueBias { axis, torque_nm }.into());
            effects.push(GyroBias { axis, bias_rad_s: uniform(-0.005, 0.005) }.into());
        }
        let model = VehicleModel {
            name: format!("drawn vehicle {seed}"),
            gravity_m_s2: GRAVITY_M_S2,
            arm_m,
            base_command,
            inertia_kg_m2: [ixx, iyy, izz],
            mounting: Mounting::Free { mass_kg },
            rotor_drag_ns_m: 0.0,
            known_rotor_drag_1_s: VehicleModel::USUAL_ROTOR_DRAG_1_S,
            propulsion: Propulsion::Generic(rotor),
            noise: SensorNoise {
                gyro_rad_s: 0.01,
                accel_m_s2: 0.1,
                attitude_rad: 0.002,
                velocity_m_s: SensorNoise::USUAL_VELOCITY_M_S,
                height_m: SensorNoise::USUAL_HEIGHT_M,
            },
            arms: None,
            tolerances: Vec::new(),
            effects,
        };
        let rate_hz = RATES_HZ[(uniform(0.0, 5.0) as usize).min(4)];
        let is_flu = uniform(0.0, 1.0) < 0.5;
        let mut order = [0, 1, 2, 3];
        for place in (1..4).rev() {
            order.swap(place, (uniform(0.0, place as f64 + 1.0) as usize).min(place));
        }
        let is_plus = uniform(0.0, 1.0) < 0.5;
        Drawn { seed, model, rate_hz, is_flu, is_plus, order, duration_s: DURATION_S }
    }

    /// The log of its flight, in this project's columns.
    ///
    /// # Panics
    /// It can't be flown.
    pub fn log(&self) -> Log {
        let choice = ControllerChoice {
            rate_hz: CONTROL_HZ.max(self.rate_hz),
            ..ControllerChoice::nominal(Controller::Cascade)
        };
        let synthesis = Synthesis {
            choice,
            scenario: self.flight(),
            duration_s: self.duration_s,
            log_rate_hz: self.rate_hz,
            blind: true,
            seed: self.seed,
            ..Synthesis::of(self.model.clone())
        };
        synthesis.log().expect("a vehicle that the cascade can fly")
    }

    /// A second each of some attitude, some turning and some height: all that moves a quadrotor, in no order.
    fn flight(&self) -> Scenario {
        let mut stream = RandomStream::new(self.seed, "identification flight");
        let mut pick = |of: [f64; 3]| of[((3.0 * stream.uniform()) as usize).min(2)];
        let waypoint = |second: usize| Waypoint {
            roll_rad: pick([-20.0, 0.0, 20.0]).to_radians(),
            pitch_rad: pick([-20.0, 0.0, 20.0]).to_radians(),
            yaw_rate_rad_s: pick([-60.0, 0.0, 60.0]).to_radians(),
            climb_m: Some(pick([-1.0, 0.0, 1.0])),
            ..Waypoint::level(second as f64)
        };
        let waypoints = (0..self.duration_s as usize).map(waypoint).collect();
        Scenario { name: "identification".to_owned(), duration_s: self.duration_s, waypoints }
    }
}
