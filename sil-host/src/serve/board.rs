//! A board in this process: the parts of the core that the firmware wires together, in its order, between bytes of a
//! link and a simulated vehicle.

mod exchange;
mod learner;

use std::collections::VecDeque;

use mavlink::dialects::common::MavSeverity;
use shared_control::config::ConfigError;
use shared_control::flight_core::{FlightCore, State};
use shared_control::link::hil::HilSample;
use shared_control::link::signing::{SigningRecord, SigningSetup};
use shared_control::link::telemetry::FIGURES;
use shared_control::link::{Answer, Chore, Commander, Guard, LinkSettings, Order, Receiver, Telemetry, VehicleStatus};
use shared_control::mpc::MpcError;
use shared_control::params::{Params, RECORD_LEN};
use shared_control::radio::StickCurves;
use shared_control::setup::Setup;
use shared_control::signals::{ArmingBlocks, Plan, RawImuSample, StepInput};

use learner::Learner;

use super::board_log::BoardLog;
use super::log_shelf::LogShelf;
use crate::planner::Planner;

/// Orders that wait for a step: as many as the firmware's queue holds.
const ORDERS_MAX: usize = 16;
/// The firmware's buffer for one transfer.
const SEND_BYTES: usize = 280;
/// Of a network, which carries far more: what a board's fastest line does, 921,600 baud.
const LINE_BYTES_S: u32 = 92_160;
/// Housekeepings from a restart's acknowledgement to the restart, as in the firmware: 0.1 s.
const RESTART_AFTER: u8 = 10;

/// Where parameters last.
pub trait ParameterStore {
    /// Keeps a record; false if that failed.
    fn keep(&mut self, record: &[u8; RECORD_LEN]) -> bool;
}

/// Where the key and the clock of signed frames last.
pub trait SigningStore {
    /// What was kept last.
    fn kept(&self) -> SigningRecord;
    /// Keeps a record; false if that failed.
    fn keep(&mut self, record: &SigningRecord) -> bool;
}

/// What lasts from one start of a board to the next.
pub struct Memory {
    /// Parameters.
    pub parameters: Box<dyn ParameterStore>,
    /// Key and clock of signed frames.
    pub signing: Box<dyn SigningStore>,
    /// Logs of flights.
    pub logs: LogShelf,
}

/// What no board can start with.
#[derive(Debug, thiserror::Error)]
pub enum OutOfOrder {
    /// A parameter.
    #[error("parameters: {0}")]
    Config(ConfigError),
    /// The MPC.
    #[error("MPC: {0}")]
    Planner(#[from] MpcError),
}

/// Who gives the core its time, where it is not the board's own clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GivenRates {
    /// Steps per second.
    pub loop_hz: f32,
    /// Samples of the IMU per second, one in each step at least.
    pub imu_hz: f32,
}

/// What it does to its motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// Commands to motors 1 to 4.
    pub commands: [f64; 4],
    /// Do they turn?
    pub turning: bool,
}

/// The board.
pub struct SimulatedBoard {
    setup: Setup,
    given: Option<GivenRates>,
    state: State,
    planner: Option<Planner>,
    plan: Option<Plan>,
    commander: Commander,
    telemetry: Telemetry,
    status: VehicleStatus,
    input: StepInput,
    orders: VecDeque<Order>,
    chores: VecDeque<Chore>,
    sent: Vec<u8>,
    /// What is in use, and what the next start finds.
    flown: Params,
    stored: Params,
    /// What the ground's sticks mean.
    curves: StickCurves,
    store: Box<dyn ParameterStore>,
    guard: Guard,
    signing: Box<dyn SigningStore>,
    log: BoardLog,
    learner: Option<Learner>,
    restart_in: Option<u8>,
    /// Orders that found no room.
    pub orders_dropped: u32,
}

impl SimulatedBoard {
    /// Starts with these choices.
    ///
    /// # Errors
    /// [`OutOfOrder`] where they cannot be flown.
    pub fn start(params: &Params, memory: Memory) -> Result<Self, OutOfOrder> {
        Self::start_at(params, memory, None)
    }

    fn start_at(params: &Params, memory: Memory, given: Option<GivenRates>) -> Result<Self, OutOfOrder> {
        let Memory { parameters: store, signing, logs } = memory;
        // the simulated vehicle is all around this board already
        let params = &Params { hil: false, ..*params };
        let (setup, planner) = exchange::made_of(params, given)?;
        let settings = LinkSettings::of(params, LINE_BYTES_S);
        let blocks = ArmingBlocks {
            esc_calibration: params.esc_calibration,
            vehicle_unusable: setup.vehicle_fault.is_some(),
            ..ArmingBlocks::default()
        };
        let mut telemetry = Telemetry::new(&settings, params).with_signing(signing.kept());
        let mut guard = Guard::open();
        // nothing is let in before the key is known
        let is_kept = |_: &SigningRecord| false;
        guard.follow(&telemetry.update_signing((0, guard.refused), 0, is_kept));
        Ok(Self {
            learner: Learner::new(params, &setup),
            setup,
            given,
            state: State::default(),
            planner,
            plan: None,
            // there is neither radio nor safety button here
            commander: Commander::new(&settings, blocks),
            telemetry,
            status: VehicleStatus::at_start(params.controller),
            input: StepInput::default(),
            orders: VecDeque::new(),
            chores: VecDeque::new(),
            sent: Vec::new(),
            flown: *params,
            stored: *params,
            curves: settings.curves,
            store,
            guard,
            signing,
            log: BoardLog::new(logs),
            restart_in: None,
            orders_dropped: 0,
        })
    }

    /// Has the restart that was ordered come?
    pub fn wants_restart(&self) -> bool {
        self.restart_in == Some(0)
    }

    /// Starts anew, with what is stored.
    ///
    /// # Errors
    /// As [`SimulatedBoard::start`].
    pub fn restart(&mut self) -> Result<(), OutOfOrder> {
        self.restart_at(self.given)
    }

    /// The same at other rates; none for those of its parameters.
    ///
    /// # Errors
    /// As [`SimulatedBoard::start`], and for rates that the core cannot keep.
    pub fn restart_at(&mut self, given: Option<GivenRates>) -> Result<(), OutOfOrder> {
        let memory = Memory {
            parameters: std::mem::replace(&mut self.store, Box::new(Forgetful)),
            signing: std::mem::replace(&mut self.signing, Box::new(Unsigned)),
            logs: std::mem::replace(&mut self.log, BoardLog::new(LogShelf::in_memory())).into_shelf(),
        };
        let sent = std::mem::take(&mut self.sent);
        let dropped = self.orders_dropped;
        *self = Self { sent, orders_dropped: dropped, ..Self::start_at(&self.stored, memory, given)? };
        Ok(())
    }

    /// Identity on the link, for whoever takes bytes apart.
    pub fn link_settings(&self) -> LinkSettings {
        LinkSettings::of(&self.flown, LINE_BYTES_S)
    }

    /// Length of a step, µs.
    pub fn step_us(&self) -> u64 {
        (1e6 / self.setup.config.loop_rate_hz).round() as u64
    }

    /// State after the last step.
    pub fn status(&self) -> &VehicleStatus {
        &self.status
    }

    /// Takes a byte that came to one of its links; what it orders is obeyed in the next step. `is_local`: the sender
    /// sits at this computer, and may set up signing.
    pub fn hear(&mut self, receiver: &mut Receiver, byte: u8, is_local: bool) {
        receiver.use_curves(&self.curves);
        match receiver.receive(byte, &mut self.guard) {
            Some(Order::SetUpSigning(_)) if !is_local => {}
            Some(Order::SetUpSigning(setup)) => self.order(Order::SetUpSigning(SigningSetup { is_local, ..setup })),
            Some(order) => self.order(order),
            None => {}
        }
    }

    /// Takes an order; it is obeyed in the next step.
    pub fn order(&mut self, order: Order) {
        if self.orders.len() < ORDERS_MAX {
            self.orders.push_back(order);
        } else {
            self.orders_dropped += 1;
        }
    }

    /// What it has to say since the last time.
    pub fn take_sent(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.sent)
    }

    /// A sample of the IMU.
    pub fn sample(&mut self, sample: RawImuSample) {
        // ten at most at 100 Hz: there is room for sixteen
        let _ = self.input.imu.push(sample);
    }

    /// The same in SI units and body axes, as a simulator has it: rounded to what the IMU would have sent.
    pub fn sample_in_units(&mut self, sample: &HilSample) {
        self.sample(sample.raw(&self.setup.config.sensing.imu));
    }

    /// A step of the loop.
    pub fn step(&mut self, time_us: u64, battery_v: Option<f64>) -> Driven {
        self.input.time_us = time_us;
        while let Some(order) = self.orders.pop_front() {
            let (answer, chore) = self.commander.order(&order, time_us);
            self.pass_on(answer, chore);
        }
        self.commander.commands(time_us).fill(&mut self.input);
        self.input.battery_v = battery_v.map(|volts| volts as f32);
        self.input.plan = self.plan.take();
        self.learn(time_us);
        let output = FlightCore::fast(&self.setup.config, &mut self.state, &self.input);
        let answer = self.commander.answer(&output.arming);
        self.pass_on(answer, None);
        let request = FlightCore::follow(&self.setup.config, &mut self.state, &output);
        if let (Some(request), Some(planner)) = (request, &mut self.planner) {
            // not timed: the same flight is to give the same bytes
            self.plan = Some(planner.plan(&request, &output.estimate));
        }
        self.work_in_idle_time(time_us);
        let (mode, link_losses) = (self.commander.mode(), self.commander.link_losses);
        self.log.record(&self.setup.config, &self.input, &output, (&self.status.io.radio, mode));
        self.status =
            VehicleStatus { mode, link_losses, ..VehicleStatus::new(&self.setup.config, &self.input, &output) };
        self.input.imu.clear();
        Driven { commands: output.mix.commands.0.map(f64::from), turning: output.arming.motors_turn() }
    }

    /// What has time: chores, and reports that are due.
    pub fn keep_house(&mut self, time_us: u64) {
        while let Some(chore) = self.chores.pop_front() {
            self.attend_to(chore, time_us);
        }
        self.bring_into_use(time_us);
        let seen = (self.guard.latest_seen(), self.guard.refused);
        let signing = &mut self.signing;
        // whoever has lost the key deletes its file: nobody may change it unsigned
        let terms = self.telemetry.update_signing(seen, time_us, |record| signing.keep(record));
        self.guard.follow(&terms);
        let planning = self.status.planning;
        let mut figures = [("", 0); FIGURES];
        let [state, number, lack] = self.status.motors.figures();
        figures[..7].copy_from_slice(&[
            ("plan_iter", planning.iterations.into()),
            ("plan_us", planning.duration_us),
            ("plan_late", planning.deadline_misses),
            ("fallbacks", planning.fallbacks),
            state,
            number,
            lack,
        ]);
        self.telemetry.figures(figures);
        if self.log.write(&self.flown).is_err() {
            self.telemetry.text(MavSeverity::MAV_SEVERITY_WARNING, "log not written: memory failed");
        }
        let mut due = heapless::Vec::<u8, SEND_BYTES>::new();
        self.telemetry.poll(time_us, &self.status, &mut due);
        self.telemetry.send_files(time_us, &self.status, self.log.shelf(), &mut due);
        self.sent.extend_from_slice(&due);
        if let Some(updates) = &mut self.restart_in {
            *updates = updates.saturating_sub(1);
        }
    }

    fn pass_on(&mut self, answer: Option<Answer>, chore: Option<Chore>) {
        if let Some(answer) = answer {
            self.telemetry.answer(answer);
        }
        if chore.as_ref().is_some_and(Chore::changes_parameters) {
            self.commander.await_change();
        }
        self.chores.extend(chore);
    }

    fn attend_to(&mut self, chore: Chore, time_us: u64) {
        let (store, stored) = (&mut self.store, &mut self.stored);
        let keep = |record: &[u8; RECORD_LEN]| {
            let kept = store.keep(record);
            if kept && let Ok(params) = shared_control::params::decode(record) {
                *stored = params;
            }
            kept
        };
        match chore {
            // no fault of this board is recorded
            Chore::ClearFaultRecord => {}
            Chore::StoreConfiguration => self.telemetry.store_configuration(keep),
            Chore::Parameters(request) => self.telemetry.serve_parameters(&request, &self.status, keep),
            Chore::CalibrateLevel => self.telemetry.calibrate_level(&self.status, keep),
            Chore::Tell(inquiry) => self.telemetry.tell(&inquiry),
            Chore::Files(request) => self.telemetry.take_file_request(&request),
            Chore::Logs(request) => self.telemetry.take_log_request(&request, self.log.shelf()),
            Chore::SetUpSigning(setup) => {
                let signing = &mut self.signing;
                self.telemetry.set_up_signing(&setup, (&self.status, time_us), |record| signing.keep(record));
            }
            Chore::Restart => self.restart_in = Some(RESTART_AFTER),
        }
    }
}

/// Stands in for a board's memory while it starts anew.
struct Forgetful;

impl ParameterStore for Forgetful {
    fn keep(&mut self, _: &[u8; RECORD_LEN]) -> bool {
        false
    }
}

/// A board that keeps no key; none lasts longer than it runs.
#[derive(Debug)]
pub struct Unsigned;

impl SigningStore for Unsigned {
    fn kept(&self) -> SigningRecord {
        SigningRecord::default()
    }

    fn keep(&mut self, _: &SigningRecord) -> bool {
        false
    }
}
