//! One flight of the free F450 in which a motor fails, or none.

use shared_control::config::{Config, Controller, Tuning};
use shared_control::flight_core::{FlightCore, State};
use shared_control::motor_loss::Stage;
use shared_control::signals::{ArmingRequest, Setpoint, StepInput};
use sil_host::axis::Axis;
use sil_host::control_setup::{core_config, vehicle_parameters};
use sil_host::effects::{Effect, GyroScale, InertiaError, RotorInertia, ThrustScale};
use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::{Plant, Truth};
use sil_host::sensors::Sensors;
use sil_host::sensors::random::RandomStream;

/// Yaw torque of the air over the rate, N m s/rad: Mueller and D'Andrea (ICRA 2014) measured 2.75e-3 on a vehicle of
/// 0.5 kg and 0.17 m of arm; in proportion to mass and the arm's square.
pub const YAW_DRAG_NM_S: f64 = 0.0117;
/// Motor's bell and propeller, `models/f450-free.toml`.
const ROTOR_INERTIA_KG_M2: f64 = 5.44e-5;
/// How long a gust lasts: Dryden's length of horizontal turbulence at 6 m (MIL-F-8785C 3.7.3.4: h / (0.177 +
/// 0.000823 h)^1.2 in feet) over a mean wind of 5 m/s.
const GUST_S: f64 = 8.7;
/// A step of the control loop has three samples.
const SAMPLES_PER_STEP: u64 = 3;
const STEP_US: u64 = 2500;
/// At rest, then armed, then carried by its motors, µs.
const ARMED_US: u64 = 1_800_000;
const HOVERS_US: u64 = 1_900_000;
const FREE_US: u64 = 2_000_000;

/// What the vehicle does when it happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flown {
    /// Nothing.
    Hover,
    /// Roll and pitch by turns to 20 degrees.
    Steps,
    /// Hover in gusts.
    Gusts {
        /// Their torque about each horizontal axis of the world, standard deviation, N m.
        deviation_nm: f64,
    },
}

/// How a motor fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Failure {
    /// None does.
    None,
    /// Its command becomes 0, and it spins down.
    SpinsDown,
    /// That share of lift and reaction torque is lost, within a time, s.
    Lift {
        /// 0 to 1.
        lost: f64,
        /// From the whole to the rest, s.
        within_s: f64,
    },
}

/// An IMU in a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuiltIn {
    /// From the centre of gravity, body axes, m.
    pub at_m: [f64; 3],
    /// Yaw rate that its gyro says, over the true one.
    pub yaw_scale: f64,
}

impl BuiltIn {
    /// As no IMU is: in the axis of the spin and without error.
    pub const IDEAL: BuiltIn = BuiltIn { at_m: [0.0; 3], yaw_scale: 1.0 };
    /// Where a board on top of a frame has it, with half a battery's width of luck; the MPU-6000's scale may be 3 % off
    /// (product specification 6.1).
    pub const USUAL: BuiltIn = BuiltIn { at_m: [0.02, 0.01, -0.02], yaw_scale: 1.02 };
}

/// A flight.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Of noise, gusts, the motor, the instant and the model's errors.
    pub seed: u64,
    /// What is flown.
    pub flown: Flown,
    /// What fails.
    pub failure: Failure,
    /// Yaw drag over [`YAW_DRAG_NM_S`].
    pub yaw_drag: f64,
    /// Inertia of the rotors over that of the F450's, which the core believes.
    pub rotor_inertia: f64,
    /// Inertia and lift are up to this share off.
    pub model_error: f64,
    /// The IMU as it is built in.
    pub imu: BuiltIn,
    /// Whether the core knows of lost motors.
    pub noticed: bool,
    /// After the failure, s.
    pub duration_s: f64,
}

/// What came of it; times since the failure, s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// The right motor was suspected, or found lost.
    pub suspected_s: Option<f64>,
    /// A motor was found lost.
    pub lost_s: Option<f64>,
    /// It was that one.
    pub right: bool,
    /// Largest tilt, degrees.
    pub tilt_deg: f64,
    /// Since when it has been within 30 degrees.
    pub upright_s: f64,
    /// Largest tilt in the last five seconds, degrees.
    pub late_tilt_deg: f64,
    /// Largest error of roll or pitch against what is flown, degrees.
    pub deviation_deg: f64,
    /// Largest change of the heading in the first two seconds, degrees.
    pub heading_deg: f64,
    /// Rate of the spin at the end, rad/s.
    pub spin_rad_s: f64,
    /// Suspicions raised before the failure, and for how long, s.
    pub suspicions: u32,
    /// For how long one was held, s.
    pub suspected_for_s: f64,
    /// Root mean square tilt before the failure, degrees.
    pub calm_tilt_deg: f64,
}

/// Of the least command of a motor in flight what it is told on the ground: the board's `MOT_SPIN_ARM_PCT` (10 %) over
/// its `MOT_SPIN_MIN_PCT` (15 %).
const GROUND_SHARE: f32 = 0.1 / 0.15;

/// The vehicle, and the core that takes it for the nominal one.
pub struct Vehicle {
    nominal: VehicleModel,
    config: Config,
}

impl Vehicle {
    /// With or without the feature, and the least command of a motor in flight.
    ///
    /// # Panics
    /// If the nominal vehicle can't be flown.
    pub fn new(noticed: bool, flight_idle_command: f32) -> Self {
        let nominal = VehicleModel::nominal(Rig::Free);
        let tuning = Tuning {
            motor_loss: noticed,
            ground_idle_command: flight_idle_command * GROUND_SHARE,
            flight_idle_command,
            ..Tuning::for_vehicle(&vehicle_parameters(&nominal))
        };
        let config = core_config(&nominal, &tuning, 400, 1200, Controller::Cascade).expect("the nominal vehicle flies");
        Self { nominal, config }
    }

    fn drawn(&self, case: &Case, draws: &mut RandomStream) -> VehicleModel {
        let mut scale = || 1.0 + case.model_error * (2.0 * draws.uniform() - 1.0);
        let effects = vec![
            Effect::RotorInertia(RotorInertia { inertia_kg_m2: case.rotor_inertia * ROTOR_INERTIA_KG_M2 }),
            Effect::InertiaError(InertiaError { axis: Axis::Roll, scale: scale() }),
            Effect::InertiaError(InertiaError { axis: Axis::Pitch, scale: scale() }),
            Effect::ThrustScale(ThrustScale { scale: scale() }),
            Effect::GyroScale(GyroScale { axis: Axis::Yaw, scale: case.imu.yaw_scale }),
        ];
        VehicleModel { effects, ..self.nominal.clone() }
    }

    /// Flies it.
    pub fn fly(&self, case: &Case) -> Outcome {
        self.fly_until(case, false)
    }

    /// The same, all of it counting as before the failure, of which there is none.
    pub fn fly_whole(&self, case: &Case) -> Outcome {
        self.fly_until(case, true)
    }

    fn fly_until(&self, case: &Case, whole: bool) -> Outcome {
        let mut draws = RandomStream::new(case.seed, "motor loss");
        let motor = (4.0 * draws.uniform()) as usize;
        let fails_us = FREE_US + 1_500_000 + (1e6 * draws.uniform()) as u64 / 833 * 833;
        let model = self.drawn(case, &mut draws);
        let mut plant = Plant::new(&model);
        let sensors = Sensors::new(&model.noise, case.seed).with_effects(&model.effects);
        let mut sensors = sensors.with_imu_at(case.imu.at_m);
        let (mut state, mut watch) = (State::default(), Watch::new(motor, if whole { u64::MAX } else { fails_us }));
        let mut gust = Gust::new(&mut draws);
        let mut input = StepInput::default();
        let end_us = fails_us + (1e6 * case.duration_s) as u64;
        for sample in 0.. {
            let now_us = sample * STEP_US / SAMPLES_PER_STEP;
            if now_us >= end_us {
                break;
            }
            if now_us >= FREE_US {
                let since_s = now_us as f64 * 1e-6 - fails_us as f64 * 1e-6;
                if let (Failure::Lift { lost, within_s }, true) = (case.failure, since_s >= 0.0) {
                    let mut left = [1.0; 4];
                    left[motor] = 1.0 - lost * if within_s > 0.0 { (since_s / within_s).min(1.0) } else { 1.0 };
                    plant.set_lift_left(left);
                }
                let truth = plant.truth();
                let mut torque_nm = [0.0; 3];
                if let Flown::Gusts { deviation_nm } = case.flown {
                    let gust_nm = gust.next(&mut draws).map(|deviations| deviations * deviation_nm);
                    torque_nm = in_body(&truth.q_world_from_body, gust_nm);
                }
                torque_nm[2] -= case.yaw_drag * YAW_DRAG_NM_S * truth.rate_body_rad_s[2];
                plant.set_disturbance_torque_body_nm(torque_nm);
                plant.advance(1e-6 * (STEP_US / SAMPLES_PER_STEP) as f64);
            }
            let reading =
                if now_us < FREE_US { sensors.imu_at_rest(9.81, now_us) } else { sensors.imu(&plant, now_us) };
            let _ = input.imu.push(reading);
            if sample % SAMPLES_PER_STEP != 0 {
                continue;
            }
            input.time_us = now_us;
            input.arming = if now_us == ARMED_US { ArmingRequest::Arm } else { ArmingRequest::None };
            input.setpoint = setpoint(case.flown, now_us, model.base_command);
            let output = FlightCore::fast(&self.config, &mut state, &input);
            FlightCore::follow(&self.config, &mut state, &output);
            input.imu.clear();
            if now_us >= FREE_US {
                let mut commands = output.mix.commands.0.map(f64::from);
                if case.failure == Failure::SpinsDown && now_us >= fails_us {
                    commands[motor] = 0.0;
                }
                plant.set_commands(commands);
                watch.see(now_us, &plant.truth(), &state);
            }
        }
        watch.outcome(end_us)
    }
}

/// Wind that pushes the rotors' drag over the centre of gravity, along the mean wind and across it, by Dryden's spectra
/// (MIL-F-8785C 3.7.1.2): along, white noise behind one lag; across, behind two and a lead of root 3 of it. In standard
/// deviations.
struct Gust {
    along: f64,
    across: [f64; 2],
}

impl Gust {
    /// Somewhere in it: the lags hold what they hold in the long run.
    fn new(draws: &mut RandomStream) -> Self {
        let once = draws.normal() / 2f64.sqrt();
        let twice = once / 2.0 + draws.normal() / 8f64.sqrt();
        Self { along: draws.normal(), across: [once, twice] }
    }

    fn next(&mut self, draws: &mut RandomStream) -> [f64; 3] {
        let share = 1e-6 * (STEP_US / SAMPLES_PER_STEP) as f64 / GUST_S;
        let noise = (2.0 / share).sqrt();
        self.along += share * (noise * draws.normal() - self.along);
        // a part that is lagged once, and the same lagged again, in the shares of (1 + root 3 T s) / (1 + T s)^2
        let [once, twice] = &mut self.across;
        *once += share * (noise / 2f64.sqrt() * draws.normal() - *once);
        *twice += share * (*once - *twice);
        let root = 3f64.sqrt();
        [self.along, root * *once + (1.0 - root) * *twice, 0.0]
    }
}

fn in_body([w, x, y, z]: &[f64; 4], [north, east, down]: [f64; 3]) -> [f64; 3] {
    // transposed rotation matrix times the vector
    [
        (1.0 - 2.0 * (y * y + z * z)) * north + 2.0 * (x * y + w * z) * east + 2.0 * (x * z - w * y) * down,
        2.0 * (x * y - w * z) * north + (1.0 - 2.0 * (x * x + z * z)) * east + 2.0 * (y * z + w * x) * down,
        2.0 * (x * z + w * y) * north + 2.0 * (y * z - w * x) * east + (1.0 - 2.0 * (x * x + y * y)) * down,
    ]
}

fn setpoint(flown: Flown, now_us: u64, base_command: f64) -> Setpoint {
    let throttle = if now_us >= HOVERS_US { base_command as f32 } else { 0.0 };
    let tilt_rad = [0.35, 0.0, -0.35, 0.0];
    let turn = now_us.saturating_sub(FREE_US) / 500_000;
    let (roll_rad, pitch_rad) = match flown {
        Flown::Steps => (tilt_rad[turn as usize % 4], tilt_rad[(turn / 2 + 1) as usize % 4]),
        Flown::Hover | Flown::Gusts { .. } => (0.0, 0.0),
    };
    Setpoint { roll_rad, pitch_rad, throttle, ..Setpoint::default() }
}

/// Watches a flight.
struct Watch {
    motor: usize,
    fails_us: u64,
    outcome: Outcome,
    was_suspected: bool,
    calm: (f64, f64),
    heading_rad: Option<f64>,
    late: Vec<(u64, f64)>,
}

impl Watch {
    fn new(motor: usize, fails_us: u64) -> Self {
        let outcome = Outcome { right: false, ..Outcome::default() };
        Self { motor, fails_us, outcome, was_suspected: false, calm: (0.0, 0.0), heading_rad: None, late: Vec::new() }
    }

    fn see(&mut self, now_us: u64, truth: &Truth, state: &State) {
        let [w, x, y, z] = truth.q_world_from_body;
        let tilt_deg = libm::acos((1.0 - 2.0 * (x * x + y * y)).clamp(-1.0, 1.0)).to_degrees();
        let found = &mut self.outcome;
        let stage = state.motor_loss();
        let suspected = matches!(stage, Stage::Suspected(_));
        if let (Stage::Lost(motor), None) = (stage, found.lost_s) {
            found.lost_s = Some((now_us as f64 - self.fails_us as f64) * 1e-6);
            found.right = motor == self.motor;
        }
        if now_us < self.fails_us {
            found.suspicions += u32::from(suspected && !self.was_suspected);
            found.suspected_for_s += if suspected { STEP_US as f64 * 1e-6 } else { 0.0 };
            self.was_suspected = suspected;
            self.calm = (self.calm.0 + tilt_deg * tilt_deg, self.calm.1 + 1.0);
            return;
        }
        let since_s = (now_us - self.fails_us) as f64 * 1e-6;
        let right = match stage {
            Stage::Whole => false,
            Stage::Suspected(suspicion) => suspicion.motor == self.motor,
            Stage::Lost(motor) => motor == self.motor,
        };
        if right && found.suspected_s.is_none() {
            found.suspected_s = Some(since_s);
        }
        let heading_rad = libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
        let turned_rad = heading_rad - *self.heading_rad.get_or_insert(heading_rad);
        if since_s < 2.0 {
            found.heading_deg = found.heading_deg.max(libm::asin(libm::sin(turned_rad / 2.0)).abs().to_degrees() * 2.0);
        }
        found.tilt_deg = found.tilt_deg.max(tilt_deg);
        let [roll_rad, pitch_rad, _] = state.shaped_reference_rad().map(f64::from);
        let apart_rad = (truth.roll_rad - roll_rad).abs().max((truth.pitch_rad - pitch_rad).abs());
        found.deviation_deg = found.deviation_deg.max(apart_rad.to_degrees());
        if tilt_deg > 30.0 {
            found.upright_s = since_s;
        }
        found.spin_rad_s = truth.rate_body_rad_s[2];
        self.late.push((now_us, tilt_deg));
    }

    fn outcome(mut self, end_us: u64) -> Outcome {
        let late = self.late.iter().filter(|(at_us, _)| at_us + 5_000_000 >= end_us);
        self.outcome.late_tilt_deg = late.fold(0.0, |largest, (_, tilt_deg)| tilt_deg.max(largest));
        self.outcome.calm_tilt_deg = (self.calm.0 / f64::max(self.calm.1, 1.0)).sqrt();
        self.outcome
    }
}
