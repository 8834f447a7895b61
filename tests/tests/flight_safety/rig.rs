//! The board's parts around a plant, without the board: commander, core, planner, in the order of the firmware.

use std::collections::VecDeque;

use shared_control::config::{Config, Controller};
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::link::{Commander, LinkSettings, Order};
use shared_control::mpc::{HORIZON, Mpc, MpcState};
use shared_control::params::Params;
pub use shared_control::params::Rig;
use shared_control::params::vehicle::VehicleNumbers;
use shared_control::setup::Setup;
use shared_control::signals::{ArmingBlocks, Plan, Setpoint, StepInput};
use shared_control::supervisor::Arming;
use sil_host::model::{self, Mounting, VehicleModel};
use sil_host::plant::Plant;
use sil_host::sensors::Sensors;
use sil_host::sensors::imu::quantise;
use sil_host::sensors::random::RandomStream;

use super::outside::{self, Air, Ground};

/// A step of the loop.
pub const STEP_US: u64 = 2500;
const SAMPLE_US: u64 = 1000;
/// Sticks move at 25 Hz, heartbeats come once a second.
const STICK_US: u64 = 40_000;
const HEARTBEAT_US: u64 = 1_000_000;
/// Both clocks tick at multiples of this.
const TICK_US: u64 = 500;
/// Rotors' drag over the mass, 1/s: a third less than the core takes it for.
const ROTOR_DRAG_1_S: f64 = 0.3;
const STILL: [f64; 3] = [0.0, 0.0, -9.81];

/// A vehicle that is higher than that has not met the ground for good.
const FLIES_AGAIN_M: f64 = 0.5;

/// What holds the vehicle.
#[derive(Clone, Copy, PartialEq)]
enum Held {
    Nothing,
    /// The ground: it feels its weight, level and at rest.
    Ground,
    /// Something that does not let go, as it is.
    Tree,
}

/// A vehicle, what its owner knows of it, and what is around it.
#[derive(Clone, Debug)]
pub struct Scene {
    pub model: VehicleModel,
    pub controller: Controller,
    /// What the owner set for hovering over what hovers.
    pub hover_throttle_factor: f64,
    /// Offset of the accelerometer, body, m/s^2.
    pub accel_bias_m_s2: [f64; 3],
    pub ground: Ground,
    pub air: Air,
    pub seed: u64,
}

impl Scene {
    /// In calm air, far from the ground.
    pub fn calm(rig: Rig, controller: Controller) -> Self {
        let model = VehicleModel::nominal(match rig {
            Rig::Gimbal => model::Rig::Gimbal,
            Rig::Free => model::Rig::Free,
        })
        .with_rotor_drag(ROTOR_DRAG_1_S);
        Self {
            model,
            controller,
            hover_throttle_factor: 1.0,
            accel_bias_m_s2: [0.0; 3],
            ground: Ground::NONE,
            air: Air::STILL,
            seed: 1,
        }
    }
}

/// How a vehicle met the ground.
#[derive(Clone, Copy, Debug)]
pub struct Touched {
    pub at_us: u64,
    /// Speed downwards, m/s.
    pub speed_m_s: f64,
}

/// A vehicle with its core.
pub struct RigFlight {
    plant: Plant,
    /// None for a vehicle on its rig.
    mass_kg: Option<f64>,
    ground: Ground,
    air: Air,
    gusts: RandomStream,
    gust_m_s: [f64; 3],
    touched: Option<Touched>,
    sensors: Sensors,
    held: Held,
    commander: Commander,
    config: Config,
    state: State,
    mpc: Mpc<HORIZON>,
    mpc_state: MpcState<HORIZON>,
    plan: Option<Plan>,
    now_us: u64,
    samples: VecDeque<shared_control::signals::RawImuSample>,
    stick: Setpoint,
    silent: bool,
    blind_until_us: u64,
    battery_v: Option<f32>,
    output: Option<StepOutput>,
    flown: Setpoint,
}

impl RigFlight {
    /// Armed at rest, then held until the motors carry it, and let go; it hovers.
    pub fn in_the_air(rig: Rig, controller: Controller) -> Self {
        Self::in_scene(&Scene::calm(rig, controller))
    }

    /// The same anywhere.
    pub fn in_scene(scene: &Scene) -> Self {
        let (model, controller) = (&scene.model, scene.controller);
        let (rig, mass_kg) = match model.mounting {
            Mounting::Gimbal { .. } => (Rig::Gimbal, None),
            Mounting::Free { mass_kg } => (Rig::Free, Some(mass_kg)),
        };
        let hover_throttle_permille = (scene.hover_throttle_factor * model.base_command * 1000.0).round() as u16;
        let vehicle = VehicleNumbers::F450;
        let params = Params { rig, controller, hover_throttle_permille, vehicle, ..Params::DEFAULT };
        let setup = Setup::new(&params).unwrap();
        let sensors = Sensors::new(&model.noise, scene.seed).with_effects(&model.effects);
        let mut flight = Self {
            plant: Plant::new(model),
            mass_kg,
            ground: scene.ground,
            air: scene.air,
            gusts: RandomStream::new(scene.seed, "gusts"),
            gust_m_s: [0.0; 3],
            touched: None,
            sensors: sensors.with_bias([0.0; 3], scene.accel_bias_m_s2),
            held: Held::Ground,
            commander: Commander::new(&LinkSettings::NOMINAL, ArmingBlocks::default()),
            config: setup.config,
            state: State::default(),
            mpc: Mpc::prepare_shorter(params.control_horizon.into(), &setup.mpc).unwrap(),
            mpc_state: MpcState::new(),
            plan: None,
            now_us: 0,
            samples: VecDeque::new(),
            stick: Setpoint::default(),
            silent: false,
            blind_until_us: 0,
            battery_v: None,
            output: None,
            flown: Setpoint::default(),
        };
        flight.fly_for(2.0);
        flight.commander.order(&Order::Arm, flight.now_us);
        flight.fly_for(0.1);
        assert_eq!(flight.arming(), Arming::Armed);
        flight.throttle_stick(model.base_command as f32);
        flight.fly_for(0.1);
        flight.held = Held::Nothing;
        flight.fly_for(0.5);
        flight
    }

    /// One step of the loop.
    pub fn step(&mut self) -> StepOutput {
        loop {
            self.tick_link();
            if self.now_us.is_multiple_of(SAMPLE_US) && self.now_us >= self.blind_until_us {
                self.sample();
            }
            let step_is_due = self.now_us.is_multiple_of(STEP_US);
            let output = step_is_due.then(|| self.control());
            if self.held == Held::Nothing {
                self.push();
                self.plant.advance(TICK_US as f64 * 1e-6);
            }
            self.now_us += TICK_US;
            if let Some(output) = output {
                self.output = Some(output);
                return output;
            }
        }
    }

    /// Ground and air about a free vehicle.
    fn push(&mut self) {
        let Some(mass_kg) = self.mass_kg else { return };
        let truth = self.plant.truth();
        self.gust_m_s = self.gust_m_s.map(|gust_m_s| self.air.next_gust_m_s(gust_m_s, TICK_US, &mut self.gusts));
        let height_m = outside::height_m(&self.ground, &truth);
        let of_air_n = outside::of_air(&self.air, mass_kg, &truth, self.gust_m_s, height_m);
        let (of_ground_n, torque_body_nm) = outside::of_ground(&self.ground, mass_kg, &truth);
        if height_m > FLIES_AGAIN_M {
            self.touched = None;
        } else if self.touched.is_none() && of_ground_n != [0.0; 3] {
            self.touched = Some(Touched { at_us: self.now_us, speed_m_s: truth.velocity_ned_m_s[2] });
        }
        self.plant.set_disturbance_torque_body_nm(torque_body_nm);
        self.plant.set_disturbance_force_body_n(std::array::from_fn(|axis| of_air_n[axis] + of_ground_n[axis]));
    }

    fn tick_link(&mut self) {
        if self.silent {
            return;
        }
        if self.now_us.is_multiple_of(HEARTBEAT_US) {
            self.commander.order(&Order::Heartbeat, self.now_us);
        }
        if self.now_us.is_multiple_of(STICK_US) {
            self.commander.order(&Order::Fly(self.stick), self.now_us);
        }
    }

    fn sample(&mut self) {
        let mut sample = self.sensors.imu(&self.plant, self.now_us);
        if self.held == Held::Ground {
            sample = quantise(self.now_us, [0.0; 3], STILL);
        } else if self.held == Held::Tree {
            let truth = self.plant.truth();
            let (sin, cos) = truth.roll_rad.sin_cos();
            sample = quantise(self.now_us, [0.0; 3], [0.0, -9.81 * sin, -9.81 * cos]);
        }
        self.samples.push_back(sample);
    }

    fn control(&mut self) -> StepOutput {
        let (plan, battery_v) = (self.plan.take(), self.battery_v);
        let mut input = StepInput { time_us: self.now_us, plan, battery_v, ..StepInput::default() };
        input.imu.extend(self.samples.drain(..));
        self.commander.commands(self.now_us).fill(&mut input);
        let output = FlightCore::fast(&self.config, &mut self.state, &input);
        self.commander.answer(&output.arming);
        let request = FlightCore::follow(&self.config, &mut self.state, &output);
        self.plan = request.map(|request| FlightCore::plan(&self.mpc, &mut self.mpc_state, &request));
        self.flown = self.state.flown_setpoint();
        self.plant.set_commands(output.mix.commands.0.map(f64::from));
        output
    }

    /// Flies on for a while.
    pub fn fly_for(&mut self, seconds: f64) {
        let end_us = self.now_us + (seconds * 1e6) as u64;
        while self.now_us < end_us {
            self.step();
        }
    }

    /// Steps until this is so.
    pub fn steps_until(&mut self, steps_max: u64, so: impl Fn(&StepOutput) -> bool) -> u64 {
        (1..=steps_max).find(|_| so(&self.step())).unwrap_or_else(|| panic!("not within {steps_max} steps"))
    }

    /// At this attitude and these rates from now on, however it came to that.
    pub fn throw(&mut self, [roll_deg, pitch_deg]: [f64; 2], rate_body_rad_s: [f64; 3]) {
        let (roll_rad, pitch_rad) = (f64::to_radians(roll_deg), f64::to_radians(pitch_deg));
        // the gyro has seen the way there
        self.plant.set_attitude([roll_rad, pitch_rad, 0.0], rate_body_rad_s);
        self.state.set_attitude(roll_rad as f32, pitch_rad as f32);
    }

    /// Stands on the ground from now on.
    pub fn lay_down(&mut self) {
        self.held = Held::Ground;
    }

    /// Hangs where it is from now on.
    pub fn hang(&mut self) {
        self.held = Held::Tree;
    }

    /// Roll stick, -1 to 1 of its 30 degrees.
    pub fn tilt_stick(&mut self, share: f32) {
        self.stick.roll_rad = share * 30f32.to_radians();
    }

    /// Sticks of acro, rates in rad/s; none for sticks that mean angles.
    pub fn acro_stick(&mut self, rates_rad_s: Option<[f32; 3]>) {
        self.stick.acro_rad_s = rates_rad_s;
    }

    /// Throttle stick.
    pub fn throttle_stick(&mut self, throttle: f32) {
        self.stick.throttle = throttle;
    }

    /// The ground goes away, or comes back.
    pub fn silence(&mut self, silent: bool) {
        self.silent = silent;
    }

    /// The battery's voltage from now on, V.
    pub fn battery(&mut self, battery_v: f32) {
        self.battery_v = Some(battery_v);
    }

    /// No samples for so long.
    pub fn blind_for_us(&mut self, duration_us: u64) {
        self.blind_until_us = self.now_us + duration_us;
    }

    pub fn arming(&self) -> Arming {
        self.output.map_or(Arming::default(), |output| output.arming)
    }

    /// The throttle that is flown.
    pub fn throttle(&self) -> f32 {
        self.flown.throttle
    }

    pub fn sink_throttle(&self) -> f32 {
        self.config.supervisor.sink_throttle
    }

    /// When and how it met the ground, unless it left it again.
    pub fn touched(&self) -> Option<Touched> {
        self.touched
    }

    pub fn now_us(&self) -> u64 {
        self.now_us
    }

    /// True speed downwards, m/s.
    pub fn sinks_m_s(&self) -> f64 {
        self.plant.truth().velocity_ned_m_s[2]
    }

    /// True rates about the body's axes, rad/s.
    pub fn rate_body_rad_s(&self) -> [f64; 3] {
        self.plant.truth().rate_body_rad_s
    }

    pub fn roll_deg(&self) -> f64 {
        self.plant.truth().roll_rad.to_degrees()
    }

    /// Angle between the thrust and the vertical, true.
    pub fn tilt_deg(&self) -> f64 {
        let truth = self.plant.truth();
        (truth.roll_rad.cos() * truth.pitch_rad.cos()).clamp(-1.0, 1.0).acos().to_degrees()
    }
}
