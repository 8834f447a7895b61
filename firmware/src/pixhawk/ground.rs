//! The slow end of the link: reports to the ground, and does what it wants done outside the loop.

use core::fmt::{Display, Write};

use heapless::Vec;
use mavlink::dialects::common::MavSeverity;
use rtic::Mutex;
use shared_control::link::signing::{Refused, Terms};
use shared_control::link::telemetry::Figures;
use shared_control::link::{Answer, Chore, LinkSettings, LogRequest, Telemetry, Text, VehicleStatus};
use shared_control::log_card::LogShelf;
use shared_control::params::{self, Params};
use shared_control::radio::StickCurves;

use super::boot::Start;
use super::configuration::Configuration;
use super::counters::{SETTINGS_LOST, USB_DROPPED};
use super::exchange::{self, Demand, Learning, Made};
use super::fault::{self, FaultRecord};
use super::flight_log::News;
use super::fram::Fram;
use super::link_port::{LinkIn, LinkSender, SendBuffer};
use super::queue::Consumer;
use super::usb_port::{self, UsbPort};

/// Calls of [`Ground::update`] between a restart's acknowledgement and the restart: 0.1 s, so that it leaves the port.
const RESTART_UPDATES: u8 = 10;

/// Bytes sent at once with hardware in the loop; the longest message has 66, and a signature 13.
const HIL_DUE_BYTES: usize = 100;

/// Telemetry with its queues.
pub struct Ground {
    telemetry: Telemetry,
    /// What is due, until the port takes it.
    due: SendBuffer,
    hil: bool,
    answers: Consumer<'static, Answer>,
    chores: Consumer<'static, Chore>,
    news: Consumer<'static, News>,
    memory: Fram,
    /// Updates until the restart that was ordered.
    restart_in: Option<u8>,
    /// So often has it told each of [`SETTINGS_LOST`].
    registers_told: [u32; SETTINGS_LOST.len()],
}

impl Ground {
    /// Begins with what happened before.
    pub fn new(
        settings: &LinkSettings,
        (params, mut memory): (&Params, Fram),
        (answers, chores, news): (Consumer<'static, Answer>, Consumer<'static, Chore>, Consumer<'static, News>),
    ) -> Self {
        let telemetry = Telemetry::new(settings, params).with_signing(memory.read_signing());
        let (due, hil, restart_in, registers_told) = (SendBuffer::new(), params.hil, None, [0; _]);
        Self { telemetry, due, hil, answers, chores, news, memory, restart_in, registers_told }
    }

    /// Tells a person something that should not have happened, or that explains the start.
    pub fn tell(&mut self, words: impl Display) {
        self.telemetry.warn(words);
    }

    /// Tells why the board has started, what came before, and what is out of the ordinary about the configuration.
    pub fn tell_start(&mut self, start: &Start, configuration: &Configuration) {
        self.tell(start.reset_cause);
        if start.supply_was_low {
            self.tell("waited for a supply above 2.9 V");
        }
        if let Some(record) = start.record {
            self.tell(record.words());
        }
        if let Some(fault) = configuration.fault {
            self.tell(fault);
        }
        if let Err(fault) = configuration.setup.radio {
            self.tell(fault);
        }
        if let Some(fault) = configuration.setup.vehicle_fault {
            self.tell(fault);
        }
        if !configuration.setup.pulses_keep_phase() {
            self.tell("PWM_RATE_HZ and LOOP_RATE_HZ unrelated: jitter");
        }
    }

    /// Tells a person what has happened as it should.
    fn inform(&mut self, words: &dyn Display) {
        let mut text = Text::new();
        // 50 letters at most
        let _ = write!(text, "{words}");
        self.telemetry.text(MavSeverity::MAV_SEVERITY_INFO, &text);
    }

    /// Takes what the board has measured of itself, to be sent in turns.
    pub fn figures(&mut self, figures: Figures) {
        self.telemetry.figures(figures);
    }

    /// To be called at least every 40 ms, the period of the fastest message. What TELEM1 sends USB sends, too, and
    /// files and logs go to the port that was asked for them last.
    pub fn update(
        &mut self,
        (time_us, status): (u64, &VehicleStatus),
        logs: &mut LogShelf,
        (usb, files_over_usb): (&mut UsbPort, bool),
    ) {
        while let Some(answer) = self.answers.dequeue() {
            self.telemetry.answer(answer);
        }
        while let Some(chore) = self.chores.dequeue() {
            self.attend_to(chore, (time_us, status), logs);
        }
        while let Some(news) = self.news.dequeue() {
            self.tell_news(news);
        }
        self.tell_registers();
        let is_new = self.due.is_empty();
        if is_new {
            self.make_due((time_us, status), logs, files_over_usb);
        }
        if usb.is_open() {
            let mut out = Vec::<u8, { usb_port::SEND_BYTES }>::new();
            if is_new {
                // the larger buffer is empty
                let _ = out.extend_from_slice(&self.due);
            }
            if files_over_usb && usb.is_free() {
                self.telemetry.fill_with_files(time_us, status, logs, &mut out);
            }
            if !out.is_empty() && !usb.send(&out) {
                USB_DROPPED.add();
            }
        }
        match &mut self.restart_in {
            Some(0) => fault::restart(),
            Some(updates) => *updates -= 1,
            None => {}
        }
    }

    /// Takes what has come signed, and says what is let in from now on.
    pub fn sign(&mut self, seen: (u64, Refused), time_us: u64) -> Terms {
        self.telemetry.update_signing(seen, time_us, |record| self.memory.store_signing(record))
    }

    /// Passes on which parameters are wanted in use, and says which have come into it.
    pub fn bring_into_use(
        &mut self,
        (time_us, status): (u64, &VehicleStatus),
        demand: &mut impl Mutex<T = Demand>,
        link: &mut impl Mutex<T = LinkIn>,
    ) {
        match demand.lock(|demand| demand.made.take()) {
            None => {}
            Some(Made::InUse(params, senseless)) => {
                self.telemetry.parameters_in_use(&params, &senseless);
                let curves = StickCurves::new(&params.pilot);
                link.lock(|link| link.use_curves(&curves));
            }
            Some(Made::NotUsable) => self.telemetry.parameters_not_usable(),
        }
        match demand.lock(|demand| demand.learnt.take()) {
            None => {}
            Some(Learning::Flown(model)) => self.inform(&model),
            Some(Learning::Refused(refusal)) => self.inform(&refusal),
        }
        let wanted = self.telemetry.parameters_wanted(time_us).copied();
        demand.lock(|demand| demand.wanted = wanted);
        exchange::settle(self.telemetry.parameters_settled(status));
    }

    /// Does the memory hold a whole record of parameters?
    pub fn memory_is_whole(&mut self) -> bool {
        params::load(&self.memory.read()).1.is_none()
    }

    /// Lets the port send what is due, if it is free.
    pub fn hand_over(&mut self, sender: &mut LinkSender) {
        if !self.due.is_empty() && sender.send(&self.due) {
            self.due.clear();
        }
    }

    /// Tells what became of the sensors' settings since the last call.
    fn tell_registers(&mut self) {
        for (place, (counter, words)) in SETTINGS_LOST.iter().enumerate() {
            let count = counter.get();
            if core::mem::replace(&mut self.registers_told[place], count) != count {
                self.tell(words);
            }
        }
    }

    /// Tells how the log fares.
    fn tell_news(&mut self, news: News) {
        match news {
            News::Begun(number) => self.inform(&format_args!("log {number} on the SD card")),
            News::LeftOut(steps) => self.tell(format_args!("SD card too slow: {steps} steps not in log")),
            News::Failed(error) => self.tell(error.words()),
        }
    }

    fn make_due(&mut self, about: (u64, &VehicleStatus), logs: &mut LogShelf, files_over_usb: bool) {
        let Self { telemetry, due, .. } = self;
        if self.hil {
            // a step's answer may have to wait until this has left, so it is short: 1.1 ms at 921,600 baud
            let mut few = Vec::<u8, HIL_DUE_BYTES>::new();
            write_due(telemetry, about, logs, files_over_usb, &mut few);
            // the larger buffer is empty
            let _ = due.extend_from_slice(&few);
        } else {
            write_due(telemetry, about, logs, files_over_usb, due);
        }
    }

    fn attend_to(&mut self, chore: Chore, (time_us, status): (u64, &VehicleStatus), logs: &mut LogShelf) {
        match chore {
            Chore::ClearFaultRecord => FaultRecord::clear(),
            Chore::StoreConfiguration => self.telemetry.store_configuration(|record| self.memory.store(record)),
            Chore::Parameters(request) => {
                self.telemetry.serve_parameters(&request, status, |record| self.memory.store(record));
            }
            Chore::CalibrateLevel => self.telemetry.calibrate_level(status, |record| self.memory.store(record)),
            Chore::Tell(inquiry) => self.telemetry.tell(&inquiry),
            Chore::Files(request) => self.telemetry.take_file_request(&request),
            Chore::Logs(request) => {
                if request == LogRequest::Erase {
                    self.tell("logs stay on the SD card: empty it elsewhere");
                }
                self.telemetry.take_log_request(&request, logs);
            }
            Chore::SetUpSigning(setup) => {
                self.telemetry.set_up_signing(&setup, (status, time_us), |record| self.memory.store_signing(record));
            }
            Chore::Restart => self.restart_in = Some(RESTART_UPDATES),
        }
    }
}

fn write_due<const N: usize>(
    telemetry: &mut Telemetry,
    (time_us, status): (u64, &VehicleStatus),
    logs: &mut LogShelf,
    files_over_usb: bool,
    out: &mut Vec<u8, N>,
) {
    telemetry.poll(time_us, status, out);
    if !files_over_usb {
        telemetry.send_files(time_us, status, logs, out);
    }
}
