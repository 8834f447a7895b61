//! The control core on the board: its configuration, its state, and the input of its next step.

use core::sync::atomic::{AtomicU32, Ordering};

use heapless::spsc::Consumer;
use shared_control::config::{Config, ConfigError, Tuning};
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::signals::{ArmingRequest, Plan, PlanRequest, Setpoint, StepInput};
use shared_control::vehicle::VehicleParameters;

use super::board;
use super::clock::TimeBase;
use super::imu::TimedSample;

/// Number of the last step, for the record of a fault.
static LAST_STEP: AtomicU32 = AtomicU32::new(0);

/// Steps made since start.
pub fn last_step() -> u32 {
    LAST_STEP.load(Ordering::Relaxed)
}

/// What whoever commands the vehicle wants.
#[derive(Clone, Copy, Default)]
pub struct Command {
    /// Attitude and throttle.
    pub setpoint: Setpoint,
    /// Arm or disarm; taken by one step.
    pub arming: ArmingRequest,
    /// Battery voltage, V.
    pub battery_v: Option<f32>,
}

impl Command {
    /// The command for one step; its arming request is not given twice.
    pub fn take(&mut self) -> Self {
        let command = *self;
        self.arming = ArmingRequest::None;
        command
    }
}

/// Configuration that is compiled in: the F450 on its gimbal.
pub fn configuration() -> Result<(Config, Tuning), ConfigError> {
    let tuning = Tuning::for_motor_lag(VehicleParameters::F450_GIMBAL_MOTOR_LAG_S);
    let config = Config::new(
        &VehicleParameters::F450_GIMBAL,
        &tuning,
        board::LOOP_RATE_HZ as f32,
        board::IMU_RATE_HZ as f32,
        board::CONTROLLER,
    )?;
    Ok((config, tuning))
}

/// Everything that the loop owns.
pub struct Control {
    config: Config,
    state: State,
    clock: TimeBase,
    samples: Consumer<'static, TimedSample>,
    input: StepInput,
    steps_without_imu: u32,
}

impl Control {
    /// Before the first step.
    pub fn new(config: Config, samples: Consumer<'static, TimedSample>) -> Self {
        Self {
            config,
            state: State::default(),
            clock: TimeBase::default(),
            samples,
            input: StepInput::default(),
            steps_without_imu: 0,
        }
    }

    /// Gathers the input, makes the step.
    pub fn fast(&mut self, command: &Command, plan: Option<Plan>) -> StepOutput {
        self.gather(command, plan);
        let output = FlightCore::fast(&self.config, &mut self.state, &self.input);
        LAST_STEP.store(output.step, Ordering::Relaxed);
        output
    }

    /// What comes after the outputs are written.
    pub fn follow(&mut self, output: &StepOutput) -> Option<PlanRequest> {
        FlightCore::follow(&self.config, &mut self.state, &self.input, output)
    }

    /// Input of the last step.
    pub fn input(&self) -> &StepInput {
        &self.input
    }

    fn gather(&mut self, command: &Command, plan: Option<Plan>) {
        self.input.time_us = self.clock.now_us();
        self.input.imu.clear();
        // what does not fit waits for the next step
        while !self.input.imu.is_full()
            && let Some(sample) = self.samples.dequeue()
        {
            let time_us = self.clock.extend(sample.counter_us);
            // never full here
            let _ = self.input.imu.push(sample.at(time_us));
        }
        self.input.setpoint = command.setpoint;
        self.input.battery_v = command.battery_v;
        self.input.plan = plan;
        self.input.arming = if self.imu_is_dead() { ArmingRequest::Disarm } else { command.arming };
    }

    /// True after [`board::STEPS_WITHOUT_IMU_MAX`] steps without a sample.
    fn imu_is_dead(&mut self) -> bool {
        let none = self.input.imu.is_empty();
        self.steps_without_imu = if none { self.steps_without_imu.saturating_add(1) } else { 0 };
        self.steps_without_imu >= board::STEPS_WITHOUT_IMU_MAX
    }
}
