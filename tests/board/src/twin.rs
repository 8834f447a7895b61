//! The host's core, fed with what the board's core was fed, and compared with it to the bit.

use std::collections::VecDeque;

use shared_control::config::{Config, Controller};
use shared_control::flight_core::{FlightCore, State, StepOutput, TorqueSource};
use shared_control::learning::adoption::LearntModel;
use shared_control::learning::lesson::{Lesson, Taught};
use shared_control::learning::proposal::Proposal;
use shared_control::link::Mode;
use shared_control::mpc::{HORIZON, Mpc, MpcState};
use shared_control::onboard_log::{Recorder, Stage};
use shared_control::params::Params;
use shared_control::radio::RadioFrame;
use shared_control::record::trace::StepTrace;
use shared_control::sensing::imu::AxisMap;
use shared_control::setup::{self, Setup};
use shared_control::signals::{Plan, PlanRequest, StepInput};
use shared_control::vehicle::VehicleParameters;

use crate::devices::SecondGyro;

/// How the plans fared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Planned {
    /// Plans of the board that the host made again, equal to the bit.
    pub repeated: u64,
    /// Of these, such that arrived too late for their step.
    pub late: u64,
    /// Questions to which the board made no plan, because the one before was still being made.
    pub not_made: u64,
    /// Steps whose question before was not answered in time.
    pub missed: u64,
    /// Steps in the air that flew by a plan.
    pub flown: u64,
    /// Steps in the air that flew by the cascade for want of a plan.
    pub without: u64,
    /// Steps in the air that flew by the cascade because the plan was not solved.
    pub unsolved: u64,
}

/// Steps within which the board makes a controller of a lesson.
const LESSONS: usize = 800;
/// Of a step's record, at least.
const RECORD_MAX: usize = 1024;

/// Configuration, state, and plans that may still arrive.
#[derive(Clone)]
pub struct Twin {
    config: Config,
    gyro: SecondGyro,
    state: State,
    mpc: Mpc<HORIZON>,
    mpc_state: MpcState<HORIZON>,
    questions: VecDeque<PlanRequest>,
    steps: u64,
    planned: Planned,
    /// Another configuration, which the next step begins with.
    next: Option<(Config, Mpc<HORIZON>)>,
    params: Params,
    /// The model that flies, what the board may have been taught of late, and what the next step begins with of that.
    flown: LearntModel,
    lessons: VecDeque<Lesson>,
    taught: Option<(Taught, Mpc<HORIZON>)>,
    recorder: Box<Recorder<RECORD_MAX>>,
    recorded: Vec<u8>,
}

impl Twin {
    /// Before the first step, as the board is configured and fitted.
    ///
    /// # Panics
    /// If it can't be flown with.
    pub fn new(params: &Params, gyro: SecondGyro) -> Self {
        let (config, mpc) = prepared(params, gyro);
        let (state, mpc_state, questions) = (State::default(), MpcState::new(), VecDeque::new());
        let (recorder, recorded, planned) = (Box::default(), Vec::new(), Planned::default());
        let (params, flown, lessons) = (*params, first_model(params), VecDeque::new());
        #[rustfmt::skip]
        let twin = Self {
            config, gyro, state, mpc, mpc_state, questions, steps: 0, planned, next: None, params, flown, lessons,
            taught: None, recorder, recorded,
        };
        twin
    }

    /// Starts again with what is stored, as the board does after a reset.
    ///
    /// # Panics
    /// As [`Twin::new`].
    pub fn restart(&mut self, params: &Params) {
        (self.config, self.mpc) = prepared(params, self.gyro);
        (self.state, self.mpc_state) = (State::default(), MpcState::new());
        (self.params, self.flown) = (*params, first_model(params));
        self.questions.clear();
    }

    /// The board takes other choices with its next step.
    ///
    /// # Panics
    /// As [`Twin::new`].
    pub fn take_up(&mut self, params: &Params) {
        self.next = Some(prepared(params, self.gyro));
        (self.params, self.flown) = (*params, first_model(params));
    }

    /// The board takes with its next step what it has made of the lesson after this one.
    ///
    /// # Panics
    /// If nothing follows from that lesson, or what follows may not fly.
    pub fn learn(&mut self, step: u32) {
        let lesson = self.lessons.iter().find(|lesson| lesson.step == step).expect("a lesson of late");
        let learnt = lesson.learnt().expect("something was learnt");
        let (params, first) = (self.params, setup::flown_vehicle(&self.params));
        let model = self.flown.corrected(&learnt).expect("another model");
        let tuning_of = |vehicle: &VehicleParameters| setup::tuning(&params, vehicle);
        let proposal = Proposal::new(&model, &first, tuning_of, f32::from(params.loop_rate_hz)).unwrap();
        let mpc = Mpc::prepare_shorter(params.control_horizon.into(), &proposal.mpc()).unwrap();
        proposal.prove(mpc.unconstrained_gain(), &first, &learnt, || ()).expect("it may fly");
        (self.flown, self.taught) = (model, Some((proposal.taught(step), mpc)));
    }

    /// Makes the board's step again.
    ///
    /// # Panics
    /// If any bit of its input, output, plan or state differs.
    pub fn repeat(&mut self, board: &StepTrace) {
        let input = board.input();
        let asked = self.questions.back().is_some_and(|question| question.step == self.state.step);
        self.planned.missed += u64::from(asked && input.plan.is_none_or(|plan| plan.step != self.state.step));
        self.repeat_plan(&input);
        if let Some((config, mpc)) = self.next.take() {
            assert!(FlightCore::exchange(&mut self.config, &mut self.state, &config), "exchanged in the air");
            self.mpc = mpc;
        }
        if let Some((taught, mpc)) = self.taught.take() {
            FlightCore::learn(&mut self.config, &mut self.state, &taught);
            self.mpc = mpc;
        }
        let output = FlightCore::fast(&self.config, &mut self.state, &input);
        let question = FlightCore::follow(&self.config, &mut self.state, &output);
        self.questions.extend(question);
        if self.config.learning.is_some() {
            self.lessons.truncate(LESSONS - 1);
            self.lessons.push_front(self.state.lesson());
        }
        let mut host = StepTrace::EMPTY;
        host.record(&input, &output, &self.state);
        // samples beyond the count are left over from earlier steps on the board
        (host.sample, host.sample_second) = (board.sample, board.sample_second);
        assert_eq!(&host, board, "step {}", board.step);
        self.record(&input, &output);
        self.steps += 1;
        match output.source {
            TorqueSource::Mpc => self.planned.flown += 1,
            TorqueSource::CascadeNoPlan => self.planned.without += 1,
            TorqueSource::CascadeUnsolved(_) => self.planned.unsolved += 1,
            _ => {}
        }
    }

    /// What a log would hold of the step, flown without a radio and in the usual mode.
    fn record(&mut self, input: &StepInput, output: &StepOutput) {
        self.recorder.record(&self.config, input, output, (&RadioFrame::default(), Mode::Stabilise));
        let mut record = [0; RECORD_MAX];
        let count = self.recorder.take(&mut record);
        self.recorded.extend_from_slice(&record[..count]);
        if self.recorder.stage() == Stage::Ended {
            self.recorder.close();
        }
    }

    /// What logs would hold of all steps so far, without their heads.
    pub fn recorded(&self) -> &[u8] {
        &self.recorded
    }

    /// Each plan that the board made arrives in some input; the questions before its own were not answered.
    fn repeat_plan(&mut self, input: &StepInput) {
        let Some(plan) = input.plan else { return };
        while let Some(question) = self.questions.pop_front() {
            if question.step != plan.step {
                self.planned.not_made += 1;
                continue;
            }
            let own = FlightCore::plan(&self.mpc, &mut self.mpc_state, &question);
            assert_eq!(bits(&own), bits(&plan), "plan of step {}", plan.step);
            self.planned.repeated += 1;
            // the step that takes it has not been counted yet
            self.planned.late += u64::from(plan.step != self.state.step);
            return;
        }
        panic!("a plan for step {}, which asked for none", plan.step);
    }

    /// Steps made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// How the plans fared.
    pub fn planned(&self) -> Planned {
        self.planned
    }

    /// Does the MPC fly?
    pub fn has_mpc(&self) -> bool {
        self.config.controller == Controller::Mpc
    }
}

fn first_model(params: &Params) -> LearntModel {
    LearntModel::first(&setup::flown_vehicle(params))
}

fn prepared(params: &Params, gyro: SecondGyro) -> (Config, Mpc<HORIZON>) {
    let Setup { mut config, mpc, .. } = Setup::new(params).unwrap();
    if gyro == SecondGyro::L3gd20h {
        config.sensing.imu_second.gyro_axes = AxisMap::PIXHAWK1_L3GD20H;
    }
    (config, Mpc::prepare_shorter(params.control_horizon.into(), &mpc).unwrap())
}

fn bits(plan: &Plan) -> (u32, [u32; 3], u16, String) {
    (plan.step, plan.torque_nm.map(f32::to_bits), plan.iterations, format!("{:?}", plan.status))
}
