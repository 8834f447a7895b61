//! The board's parts around a plant, without the board: commander, core, planner, in the order of the firmware.

use std::collections::VecDeque;

use shared_control::config::{Config, Controller};
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::link::{Commander, LinkSettings, Order};
use shared_control::mpc::{HORIZON, Mpc, MpcState};
use shared_control::params::Params;
pub use shared_control::params::Rig;
use shared_control::setup::Setup;
use shared_control::signals::{ArmingBlocks, Plan, Setpoint, StepInput};
use shared_control::supervisor::Arming;
use sil_host::model::{self, VehicleModel};
use sil_host::plant::Plant;
use sil_host::sensors::Sensors;
use sil_host::sensors::imu::quantise;

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

/// What holds the vehicle.
#[derive(Clone, Copy, PartialEq)]
enum Held {
    Nothing,
    /// The ground: it feels its weight, level and at rest.
    Ground,
    /// Something that does not let go, as it is.
    Tree,
}

/// A vehicle with its core.
pub struct RigFlight {
    plant: Plant,
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
    output: Option<StepOutput>,
    flown: Setpoint,
}

impl RigFlight {
    /// Armed at rest, then held until the motors carry it, and let go; it hovers.
    pub fn in_the_air(rig: Rig, controller: Controller) -> Self {
        let model = VehicleModel::nominal(match rig {
            Rig::Gimbal => model::Rig::Gimbal,
            Rig::Free => model::Rig::Free,
        })
        .with_rotor_drag(ROTOR_DRAG_1_S);
        let hover = (model.base_command * 1000.0).round() as u16;
        let params = Params { rig, controller, hover_throttle_permille: hover, ..Params::DEFAULT };
        let setup = Setup::new(&params).unwrap();
        let mut flight = Self {
            plant: Plant::new(&model),
            sensors: Sensors::new(&model.noise, 1),
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
            output: None,
            flown: Setpoint::default(),
        };
        flight.fly_for(2.0);
        flight.commander.order(&Order::Arm, flight.now_us);
        flight.fly_for(0.1);
        assert_eq!(flight.arming(), Arming::Armed);
        flight.throttle_stick(f32::from(hover) / 1000.0);
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
                self.plant.advance(TICK_US as f64 * 1e-6);
            }
            self.now_us += TICK_US;
            if let Some(output) = output {
                self.output = Some(output);
                return output;
            }
        }
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
        let mut input = StepInput { time_us: self.now_us, plan: self.plan.take(), ..StepInput::default() };
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

    /// Throttle stick.
    pub fn throttle_stick(&mut self, throttle: f32) {
        self.stick.throttle = throttle;
    }

    /// The ground goes away, or comes back.
    pub fn silence(&mut self, silent: bool) {
        self.silent = silent;
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

    pub fn roll_deg(&self) -> f64 {
        self.plant.truth().roll_rad.to_degrees()
    }

    /// Angle between the thrust and the vertical, true.
    pub fn tilt_deg(&self) -> f64 {
        let truth = self.plant.truth();
        (truth.roll_rad.cos() * truth.pitch_rad.cos()).clamp(-1.0, 1.0).acos().to_degrees()
    }
}
