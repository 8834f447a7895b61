//! The board's side of a link with hardware in the loop, in this process: the parts of the core that the firmware wires
//! together, joined in the same order.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Result, Write};

use shared_control::config::Config;
use shared_control::flight_core::{FlightCore, State};
use shared_control::link::frame::FrameWriter;
use shared_control::link::hil::{self, HilTick};
use shared_control::link::{COMPONENT_ID, Commander, Guard, LinkSettings, Order, Receiver, Telemetry, VehicleStatus};
use shared_control::params::Params;
use shared_control::setup::Setup;
use shared_control::signals::{ArmingBlocks, StepInput};

/// Steps per housekeeping.
const HOUSEKEEPING_STEPS: u32 = 4;
const HOUSEKEEPING_US: u64 = 10_000;

/// A board on a stream.
pub struct BoardTwin {
    receiver: Receiver,
    commander: Commander,
    config: Config,
    state: State,
    input: StepInput,
    /// After the last step.
    pub status: VehicleStatus,
    telemetry: Telemetry,
    answers: FrameWriter,
    /// Wait for their step.
    orders: VecDeque<Order>,
    sent: VecDeque<u8>,
    uptime_us: u64,
    /// Answers that are lost on the way: those to steps of which this says so.
    pub loses: fn(u32) -> bool,
}

impl BoardTwin {
    /// A board with these choices.
    pub fn new(params: &Params, blocks: ArmingBlocks) -> Self {
        let setup = Setup::new(params).unwrap();
        let settings = LinkSettings::NOMINAL;
        Self {
            receiver: Receiver::new(settings),
            commander: Commander::new(&settings, blocks),
            config: setup.config,
            state: State::default(),
            input: StepInput::default(),
            status: VehicleStatus { hil: params.hil, ..VehicleStatus::at_start(params.controller) },
            telemetry: Telemetry::new(&settings, params),
            answers: FrameWriter::new(settings.system_id, COMPONENT_ID),
            orders: VecDeque::new(),
            sent: VecDeque::new(),
            uptime_us: 0,
            loses: |_| false,
        }
    }

    fn order(&mut self, order: Order) {
        if let Order::HilTick(tick) = order {
            self.step(&tick);
            return;
        }
        self.orders.push_back(order);
    }

    fn step(&mut self, tick: &HilTick) {
        tick.fill(&self.config.sensing.imu, &mut self.input);
        for order in self.orders.drain(..) {
            let (answer, _) = self.commander.order(&order, tick.time_us);
            if let Some(answer) = answer {
                self.telemetry.answer(answer);
            }
        }
        self.commander.commands(self.input.time_us).fill(&mut self.input);
        let output = FlightCore::fast(&self.config, &mut self.state, &self.input);
        if !(self.loses)(output.step) {
            let data = hil::actuator_controls(self.input.time_us, &output.arming, &output.mix.commands);
            let mut frame = heapless::Vec::<u8, 128>::new();
            assert!(self.answers.write(&data, &mut frame));
            self.sent.extend(&frame);
        }
        if let Some(answer) = self.commander.answer(&output.arming) {
            self.telemetry.answer(answer);
        }
        FlightCore::follow(&self.config, &mut self.state, &output);
        let hil = self.status.hil;
        self.status = VehicleStatus { hil, ..VehicleStatus::new(&self.config, &self.input, &output) };
        if output.step.is_multiple_of(HOUSEKEEPING_STEPS) {
            self.housekeeping();
        }
    }

    fn housekeeping(&mut self) {
        self.uptime_us += HOUSEKEEPING_US;
        let mut frames = heapless::Vec::<u8, 100>::new();
        self.telemetry.poll(self.uptime_us, &self.status, &mut frames);
        self.sent.extend(&frames);
    }
}

impl Write for BoardTwin {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        for byte in bytes {
            if let Some(order) = self.receiver.receive(*byte, &mut Guard::open()) {
                self.order(order);
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl Read for BoardTwin {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        if self.sent.is_empty() {
            // time goes by
            self.housekeeping();
        }
        if self.sent.is_empty() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.sent.read(buffer)
    }
}
