//! The discrete-event side: the flight core with its planner, fed as on the board.

use shared_control::config::Config;
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::signals::{ArmingBlocks, ImuBatch, Plan, StepInput};

use crate::cosim::contract::{Events, Monitored};
use crate::planner::Planner;

/// Core, state and planner of one flight.
#[derive(Clone)]
pub struct ControlSide {
    config: Config,
    state: State,
    planner: Option<Planner>,
    plan: Option<Plan>,
}

impl ControlSide {
    /// A core at rest. The planner is needed where the configuration says MPC; without one the cascade flies.
    pub fn new(config: Config, planner: Option<Planner>) -> Self {
        Self { config, state: State::default(), planner, plan: None }
    }

    /// One step. The plan that it asks for is the next step's.
    pub fn step(&mut self, time_us: u64, monitored: &mut Monitored, events: &Events) -> (StepOutput, Option<Plan>) {
        let input = StepInput {
            time_us,
            imu: core::mem::take(&mut monitored.imu),
            imu_second: ImuBatch::new(),
            setpoint: events.setpoint,
            arming: events.arming,
            battery_v: None,
            link_age_us: None,
            blocks: ArmingBlocks::default(),
            plan: self.plan.take(),
        };
        let output = FlightCore::fast(&self.config, &mut self.state, &input);
        let request = FlightCore::follow(&self.config, &mut self.state, &output);
        self.plan = match (request, &mut self.planner) {
            (Some(request), Some(planner)) => Some(planner.plan(&request)),
            _ => None,
        };
        (output, self.plan)
    }

    /// The shaped reference of the cascade, rad (roll, pitch, yaw).
    pub fn shaped_reference_rad(&self) -> [f32; 3] {
        self.state.shaped_reference_rad()
    }

    /// What answers the requests for plans, where something does.
    pub fn planner(&self) -> Option<&Planner> {
        self.planner.as_ref()
    }

    /// Configuration in use.
    pub fn config(&self) -> &Config {
        &self.config
    }
}
