//! What a board does in its idle time with what it has learnt: another model, its controller, the rehearsal, and the
//! time at which it is to take over.

use shared_control::config::{Config, Controller, Tuning};
use shared_control::flight_core::State;
use shared_control::learning::adoption::{LearntModel, Refusal};
use shared_control::learning::confidence::Learnt;
use shared_control::learning::lesson::Taught;
use shared_control::learning::proposal::Proposal;
use shared_control::params::Params;
use shared_control::setup;
use shared_control::vehicle::VehicleParameters;

use crate::controller_file::ControllerChoice;
use crate::planner::Planner;

/// How often it looks, µs.
const LOOK_US: u64 = 100_000;
/// From a look to the change: what the board's idle time takes to make and to rehearse a controller, µs.
const WORK_US: u64 = 250_000;

/// By what the controller for another vehicle is tuned.
#[derive(Clone, Copy, Debug)]
pub enum TunedBy {
    /// A controller by name or file.
    Choice(ControllerChoice),
    /// A board's parameters.
    Parameters(Params),
}

impl TunedBy {
    fn tuning(&self, vehicle: &VehicleParameters) -> Tuning {
        match self {
            Self::Choice(choice) => choice.tuning_for(vehicle),
            Self::Parameters(params) => setup::tuning(params, vehicle),
        }
    }

    fn control_horizon(&self) -> usize {
        match self {
            Self::Choice(choice) => choice.control_horizon,
            Self::Parameters(params) => params.control_horizon.into(),
        }
    }
}

/// Looks at what was learnt, and has it taken over.
#[derive(Clone, Debug)]
pub struct IdleLearning {
    /// What everything began with.
    first: VehicleParameters,
    tuned_by: TunedBy,
    /// What flies, or will.
    flown: LearntModel,
    look_us: u64,
    looks: Vec<Look>,
}

/// A controller to take over.
#[derive(Clone)]
pub struct Prepared {
    /// When, µs.
    pub at_us: u64,
    /// What the loop takes of it.
    pub taught: Taught,
    /// Its MPC.
    pub planner: Planner,
}

/// A look after which something was to change.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// When, µs.
    pub time_us: u64,
    /// What had been learnt.
    pub learnt: Learnt,
    /// The model that it came to.
    pub model: LearntModel,
    /// Why that may not fly; none where it was taken over.
    pub refusal: Option<Refusal>,
}

impl IdleLearning {
    /// For a vehicle as it is known at first.
    pub fn new(first: VehicleParameters, tuned_by: TunedBy) -> Self {
        Self { first, tuned_by, flown: LearntModel::first(&first), look_us: 0, looks: Vec::new() }
    }

    /// What flies, or will.
    pub fn flown(&self) -> &LearntModel {
        &self.flown
    }

    /// All looks that were to change something, in order.
    pub fn looks(&self) -> &[Look] {
        &self.looks
    }

    /// After a step: a controller, where another is to take over. The cascade has no rehearsal, and keeps its model.
    pub fn work(&mut self, config: &Config, state: &State, time_us: u64) -> Option<Prepared> {
        if time_us < self.look_us || config.controller == Controller::Cascade {
            return None;
        }
        self.look_us = time_us + LOOK_US;
        let lesson = state.lesson();
        let learnt = lesson.learnt()?;
        let model = self.flown.corrected(&learnt)?;
        let (prepared, refusal) = match self.prepare(config, &model, (lesson.step, &learnt), time_us) {
            Ok(prepared) => (prepared, None),
            Err(refusal) => (None, Some(refusal)),
        };
        self.looks.push(Look { time_us, learnt, model, refusal });
        self.look_us = time_us + WORK_US + LOOK_US;
        if prepared.is_some() {
            self.flown = model;
        }
        prepared
    }

    fn prepare(
        &self,
        config: &Config,
        model: &LearntModel,
        (step, learnt): (u32, &Learnt),
        time_us: u64,
    ) -> Result<Option<Prepared>, Refusal> {
        let tuning_of = |vehicle: &VehicleParameters| self.tuned_by.tuning(vehicle);
        let Some(proposal) = Proposal::new(model, &self.first, tuning_of, config.loop_rate_hz) else { return Ok(None) };
        // numbers that no MPC can be made for are no vehicle's
        let Ok(planner) = Planner::new(self.tuned_by.control_horizon(), &proposal.mpc()) else { return Ok(None) };
        let Some(law) = planner.unconstrained_gain() else { return Ok(None) };
        proposal.prove(law, &self.first, learnt, || ())?;
        Ok(Some(Prepared { at_us: time_us + WORK_US, taught: proposal.taught(step), planner }))
    }
}
