//! The control core on the board: its configuration, its state, and the input of its next step.

use core::sync::atomic::{AtomicU32, Ordering};

use shared_control::config::Config;
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::link::{Answer, Chore, Commander, Order, VehicleStatus};
use shared_control::signals::{ImuBatch, Plan, PlanRequest, StepInput};

use super::clock::TimeBase;
use super::counters;
use super::imu::TimedSample;
use super::queue::{Consumer, Producer, Queue};

/// Room for orders that arrive within one step, and for what they bring about within one housekeeping.
const QUEUE_LENGTH: usize = 16;
/// From the link to the loop.
pub type OrderQueue = Queue<Order, QUEUE_LENGTH>;
/// From the loop to the link.
pub type AnswerQueue = Queue<Answer, QUEUE_LENGTH>;
/// From the loop to housekeeping.
pub type ChoreQueue = Queue<Chore, QUEUE_LENGTH>;

/// Number of the last step, for the record of a fault.
static LAST_STEP: AtomicU32 = AtomicU32::new(0);

/// Steps made since start.
pub fn last_step() -> u32 {
    LAST_STEP.load(Ordering::Relaxed)
}

/// The loop's ends of its queues.
pub struct Ends {
    /// Samples of both IMUs.
    pub samples: [Consumer<'static, TimedSample>; 2],
    /// What the ground wants.
    pub orders: Consumer<'static, Order>,
    /// What came of it.
    pub answers: Producer<'static, Answer>,
    /// What is to be done outside the loop.
    pub chores: Producer<'static, Chore>,
}

/// Everything that the loop owns.
pub struct Control {
    config: Config,
    state: State,
    clock: TimeBase,
    commander: Commander,
    ends: Ends,
    input: StepInput,
    /// The last `follow` asked for a plan.
    plan_asked: bool,
}

impl Control {
    /// Before the first step.
    pub fn new(config: Config, commander: Commander, ends: Ends) -> Self {
        let (state, clock, input) = (State::default(), TimeBase::default(), StepInput::default());
        Self { config, state, clock, commander, ends, input, plan_asked: false }
    }

    /// Gathers the input, makes the step.
    pub fn fast(&mut self, plan: Option<Plan>) -> StepOutput {
        self.gather(plan);
        if self.plan_asked && plan.is_none_or(|plan| plan.step != self.state.step) {
            counters::LATE_PLANS.add();
        }
        let output = FlightCore::fast(&self.config, &mut self.state, &self.input);
        LAST_STEP.store(output.step, Ordering::Relaxed);
        output
    }

    /// What comes after the outputs are written.
    pub fn follow(&mut self, output: &StepOutput) -> Option<PlanRequest> {
        let answer = self.commander.answer(&output.arming);
        self.pass_on(answer, None);
        let request = FlightCore::follow(&self.config, &mut self.state, output);
        self.plan_asked = request.is_some();
        request
    }

    /// Input of the last step.
    pub fn input(&self) -> &StepInput {
        &self.input
    }

    /// What telemetry may tell of a step.
    pub fn status(&self, output: &StepOutput) -> VehicleStatus {
        VehicleStatus { battery_v: self.input.battery_v, ..VehicleStatus::new(&self.config, output) }
    }

    fn gather(&mut self, plan: Option<Plan>) {
        let time_us = self.clock.now_us();
        self.input.time_us = time_us;
        let [first, second] = &mut self.ends.samples;
        gather_samples(&self.clock, first, &mut self.input.imu);
        gather_samples(&self.clock, second, &mut self.input.imu_second);
        // bounded, whatever arrives meanwhile
        for _ in 0..QUEUE_LENGTH {
            let Some(order) = self.ends.orders.dequeue() else { break };
            let (answer, chore) = self.commander.order(&order, time_us);
            self.pass_on(answer, chore);
        }
        self.commander.commands(time_us).fill(&mut self.input);
        self.input.plan = plan;
    }

    fn pass_on(&mut self, answer: Option<Answer>, chore: Option<Chore>) {
        let no_room = answer.is_some_and(|answer| self.ends.answers.enqueue(answer).is_err());
        let nor_here = chore.is_some_and(|chore| self.ends.chores.enqueue(chore).is_err());
        if no_room || nor_here {
            counters::ANSWERS_DROPPED.add();
        }
    }
}

/// What does not fit waits for the next step.
fn gather_samples(clock: &TimeBase, samples: &mut Consumer<'static, TimedSample>, batch: &mut ImuBatch) {
    batch.clear();
    while !batch.is_full()
        && let Some(sample) = samples.dequeue()
    {
        // never full here
        let _ = batch.push(sample.at(clock.extend(sample.counter_us)));
    }
}
