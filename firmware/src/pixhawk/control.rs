//! The control core on the board: its configuration, its state, and the input of its next step.

use core::sync::atomic::{AtomicU32, Ordering};

use heapless::Vec;
use rtic::Mutex;
use rtic::mutex_prelude::*;
use shared_control::config::Config;
use shared_control::flight_core::{FlightCore, State, StepOutput};
use shared_control::io_chip::IoReport;
use shared_control::link::frame::{CRC_LEN, FrameWriter, HEADER_LEN};
use shared_control::link::hil::{self, HilTick};
use shared_control::link::{Answer, COMPONENT_ID, Chore, Commander, LinkSettings, Order, VehicleStatus};
use shared_control::signals::{ImuBatch, Plan, PlanRequest, StepInput};

use super::battery::Battery;
use super::clock::TimeBase;
use super::counters;
use super::exchange::{self, Next, Offer};
use super::flight_log::FlightRecorder;
use super::imu::TimedSample;
use super::io_port::REPORTS;
use super::learner::Slate;
use super::planning::Planning;
use super::queue::{Consumer, Producer, Queue};

/// Room for orders that arrive within one step, and for what they bring about within one housekeeping.
const QUEUE_LENGTH: usize = 16;
/// With hardware in the loop, from the link to the loop: one at a time in lock-step, and what is sent again.
pub type TickQueue = Queue<HilTick, 4>;
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
    /// Voltage, where there is a battery and not a simulated one.
    pub battery: Option<Battery>,
    /// Ticks with their samples, with hardware in the loop.
    pub ticks: Option<Consumer<'static, HilTick>>,
    /// What the IO chip has told.
    pub reports: Consumer<'static, IoReport>,
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
    io: IoReport,
    radio_flies: bool,
    hil_answers: FrameWriter,
    hil_answer: HilAnswer,
    /// Beats of the timer since the last message, with hardware in the loop.
    waited: u32,
}

/// A quarter of a second at 400 Hz, a second at 100.
const BEATS_WITHOUT_MESSAGE: u32 = 100;

/// Bytes of `HIL_ACTUATOR_CONTROLS`, whose payload has 81.
const HIL_ANSWER_LEN: usize = HEADER_LEN + 81 + CRC_LEN;
/// An answer to a tick with hardware in the loop; not signed.
pub type HilAnswer = Vec<u8, HIL_ANSWER_LEN>;

impl Control {
    /// Before the first step.
    pub fn new(config: Config, commander: Commander, ends: Ends) -> Self {
        let (state, clock, input) = (State::default(), TimeBase::START, StepInput::default());
        let hil_answers = FrameWriter::new(LinkSettings::NOMINAL.system_id, COMPONENT_ID);
        let hil_answer = HilAnswer::new();
        let (io, radio_flies) = (IoReport::default(), commander.radio_flies());
        Self { config, state, clock, commander, ends, input, io, radio_flies, hil_answers, hil_answer, waited: 0 }
    }

    /// Is it the timer that makes the steps?
    pub fn is_timed(&self) -> bool {
        self.ends.ticks.is_none()
    }

    /// With hardware in the loop: does another tick wait?
    pub fn has_more(&self) -> bool {
        self.ends.ticks.as_ref().is_some_and(Consumer::is_ready)
    }

    /// Takes what is offered in the place of what is in use, or refuses it: in flight nothing changes but by what was
    /// learnt. Not while a plan is under way, so that the one that comes next is all of one kind. A comparison where
    /// nothing is offered.
    pub fn consider(&mut self, offer: &mut impl Mutex<T = Offer>, planning: &mut impl Mutex<T = Planning>) {
        (offer, planning).lock(|offer, planning| {
            let Some(next) = offer.next.as_ref().filter(|_| !planning.is_under_way()) else { return };
            offer.taken = match next {
                Next::Chosen(exchange) => exchange.take_up(&mut self.config, &mut self.state, &mut self.commander),
                Next::Learnt(taught) => {
                    FlightCore::learn(&mut self.config, &mut self.state, taught);
                    true
                }
            };
            offer.next = None;
            if offer.taken {
                planning.swap(&mut offer.mpc);
                self.radio_flies = self.commander.radio_flies();
            }
        });
    }

    /// Makes the step whose input is gathered.
    pub fn fast(&mut self, plan: Option<Plan>) -> StepOutput {
        self.input.plan = plan;
        let output = FlightCore::fast(&self.config, &mut self.state, &self.input);
        counters::LATE_PLANS.set(output.planning.deadline_misses);
        LAST_STEP.store(output.step, Ordering::Relaxed);
        output
    }

    /// What comes after the outputs are written.
    pub fn follow(&mut self, output: &StepOutput) -> Option<PlanRequest> {
        let answer = self.commander.answer(&output.arming);
        self.pass_on(answer, None);
        FlightCore::follow(&self.config, &mut self.state, output)
    }

    /// Lets the idle loop have what was learnt up to this step, if it has asked. A comparison where it has not.
    pub fn teach(&self, slate: &mut Slate) {
        if slate.is_wanted() {
            slate.write(self.state.lesson());
        }
    }

    /// Input of the last step.
    pub fn input(&self) -> &StepInput {
        &self.input
    }

    /// Records the step for the log; by itself, so that its buffers are not the step's.
    #[inline(never)]
    pub fn record(&mut self, output: &StepOutput, recorder: &mut FlightRecorder) {
        recorder.record(&self.config, &self.input, output, (&self.io.radio, self.commander.mode()));
    }

    /// What the core remembers.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What telemetry may report of a step.
    pub fn status(&self, output: &StepOutput) -> VehicleStatus {
        let (hil, io, radio_flies) = (!self.is_timed(), self.io, self.radio_flies);
        let (mode, link_losses) = (self.commander.mode(), self.commander.link_losses);
        VehicleStatus {
            hil,
            io,
            radio_flies,
            mode,
            link_losses,
            ..VehicleStatus::new(&self.config, &self.input, output)
        }
    }

    /// The answer to the step's tick, with hardware in the loop.
    pub fn hil_answer(&mut self, output: &StepOutput) -> Option<&HilAnswer> {
        self.ends.ticks.as_ref()?;
        self.hil_answer.clear();
        let data = hil::actuator_controls(self.input.time_us, &output.arming, &output.mix.commands);
        self.hil_answers.write(&data, &mut self.hil_answer).then_some(&self.hil_answer)
    }

    /// May the board's own motors turn? Never with hardware in the loop, whose motors are simulated.
    pub fn motors_turn(&self, output: &StepOutput) -> bool {
        self.is_timed() && output.arming.motors_turn()
    }

    /// Gathers the input of a step. False if none is due: with hardware in the loop there is a tick for each.
    pub fn gather(&mut self) -> bool {
        match &mut self.ends.ticks {
            None => self.gather_samples(),
            Some(ticks) => {
                let Some(tick) = ticks.dequeue() else {
                    self.wait();
                    return false;
                };
                self.waited = 0;
                tick.fill(&self.config.sensing.imu, &mut self.input);
            }
        }
        self.obey();
        self.listen_to_io();
        self.commander.settle(exchange::settled());
        self.commander.commands(self.input.time_us).fill(&mut self.input);
        self.input.battery_v = self.ends.battery.as_ref().map(Battery::voltage_v);
        true
    }

    /// With hardware in the loop, at a beat of the timer without a message. While messages come, orders wait for the
    /// step of theirs, so that a flight can be repeated; when they stay away, somebody may want to end it by parameter.
    fn wait(&mut self) {
        self.waited = self.waited.saturating_add(1);
        if self.waited >= BEATS_WITHOUT_MESSAGE {
            self.obey();
        }
    }

    fn obey(&mut self) {
        let time_us = self.input.time_us;
        // bounded, whatever arrives meanwhile
        for _ in 0..QUEUE_LENGTH {
            let Some(order) = self.ends.orders.dequeue() else { break };
            let (answer, chore) = self.commander.order(&order, time_us);
            self.pass_on(answer, chore);
        }
    }

    fn listen_to_io(&mut self) {
        for _ in 0..REPORTS {
            let Some(report) = self.ends.reports.dequeue() else { break };
            self.commander.take_io(&report, self.input.time_us);
            self.io = report;
        }
    }

    fn gather_samples(&mut self) {
        self.input.time_us = self.clock.now_us();
        let [first, second] = &mut self.ends.samples;
        gather_samples(&self.clock, first, &mut self.input.imu);
        gather_samples(&self.clock, second, &mut self.input.imu_second);
    }

    fn pass_on(&mut self, answer: Option<Answer>, chore: Option<Chore>) {
        let no_room = answer.is_some_and(|answer| self.ends.answers.enqueue(answer).is_err());
        let changes_parameters = chore.as_ref().is_some_and(Chore::changes_parameters);
        let nor_here = chore.is_some_and(|chore| self.ends.chores.enqueue(chore).is_err());
        if no_room || nor_here {
            counters::ANSWERS_DROPPED.add();
        }
        if changes_parameters && !nor_here {
            self.commander.await_change();
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
