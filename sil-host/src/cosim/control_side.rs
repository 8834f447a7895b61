//! The discrete-event side: the flight core with its planner, fed as on the board.

use shared_control::config::Config;
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::signals::{ArmingBlocks, ImuBatch, Plan, StepInput};

use crate::cosim::contract::{Events, Monitored};
use crate::cosim::idle_learning::{IdleLearning, Prepared};
use crate::planner::Planner;

/// Core, state and planner of one flight.
#[derive(Clone)]
pub struct ControlSide {
    config: Config,
    state: State,
    planner: Option<Planner>,
    plan: Option<Plan>,
    change: Option<Box<Change>>,
    learning: Option<Box<IdleLearning>>,
    prepared: Option<Box<Prepared>>,
}

/// Another configuration and MPC, prepared aside, and when they take over.
#[derive(Clone)]
struct Change {
    at_us: u64,
    config: Config,
    planner: Option<Planner>,
}

impl ControlSide {
    /// A core at rest. The planner is needed where the configuration says MPC; without one the cascade flies.
    pub fn new(config: Config, planner: Option<Planner>) -> Self {
        Self { config, state: State::default(), planner, plan: None, change: None, learning: None, prepared: None }
    }

    /// With what idle time makes of what is learnt; the configuration says whether anything is.
    pub fn with_learning(self, learning: IdleLearning) -> Self {
        Self { learning: Some(Box::new(learning)), ..self }
    }

    /// What was made of what was learnt, where that is asked for.
    pub fn learning(&self) -> Option<&IdleLearning> {
        self.learning.as_deref()
    }

    /// Has the configuration and the MPC of another side, prepared already, take over in flight: weights, models, gains
    /// or the controller itself, at the first step from `at_us` on. Nothing is prepared in the loop, and nothing jumps:
    /// what passes from step to step (state, requests, plans, the warm start) is in SI units and means the same to
    /// both.
    pub fn change_at(&mut self, at_us: u64, prepared: ControlSide) {
        let ControlSide { config, planner, .. } = prepared;
        self.change = Some(Box::new(Change { at_us, config, planner }));
    }

    fn take_over(&mut self, change: Change) {
        self.config = change.config;
        match (&mut self.planner, change.planner) {
            (Some(planner), Some(other)) => planner.take_over(other),
            (planner, other) => *planner = other,
        }
    }

    fn learn(&mut self, Prepared { taught, planner, .. }: Prepared) {
        FlightCore::learn(&mut self.config, &mut self.state, &taught);
        if let Some(flying) = &mut self.planner {
            flying.take_over(planner);
        }
    }

    /// One step. The plan that it requests is the next step's.
    pub fn step(&mut self, time_us: u64, monitored: &mut Monitored, events: &Events) -> (StepOutput, Option<Plan>) {
        if let Some(change) = self.change.take_if(|change| change.at_us <= time_us) {
            self.take_over(*change);
        }
        if let Some(prepared) = self.prepared.take_if(|prepared| prepared.at_us <= time_us) {
            self.learn(*prepared);
        }
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
            (Some(request), Some(planner)) => Some(planner.plan(&request, &output.estimate)),
            _ => None,
        };
        self.work_in_idle_time(time_us);
        (output, self.plan)
    }

    fn work_in_idle_time(&mut self, time_us: u64) {
        let Some(learning) = &mut self.learning else { return };
        if let Some(prepared) = learning.work(&self.config, &self.state, time_us) {
            self.prepared = Some(Box::new(prepared));
        }
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
