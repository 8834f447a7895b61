//! What the vehicle says of itself, at rates that leave half of 57,600 baud free.

use mavlink::dialects::common::{MavCmd, MavSeverity, NAMED_VALUE_INT_DATA, STATUSTEXT_DATA};
use nalgebra::Vector3;

use super::frame::FrameWriter;
use super::messages::{
    arming_words, attitude, command_ack, heartbeat, io_words, radio_channels, servo_output, sys_status, wrapped_ms,
};
use super::orders_and_answers::{Answer, ParameterRequest, Text};
use super::parameters::Parameters;
use super::settings::{COMPONENT_ID, LinkSettings};
use super::vehicle_status::VehicleStatus;
use crate::io_chip::IoState;
use crate::params::level::LevelParams;
use crate::params::{Params, RECORD_LEN};
use crate::sensing::imu::STANDARD_GRAVITY_M_S2;
use crate::sensing::imu_select::ImuUnit;
use crate::sensing::level_trim::LevelTrim;
use crate::supervisor::{Arming, Refusal};

/// Period of `HEARTBEAT`, µs.
pub const HEARTBEAT_PERIOD_US: u64 = 1_000_000;
/// Period of `ATTITUDE`, µs.
pub const ATTITUDE_PERIOD_US: u64 = 40_000;
/// Period of `SERVO_OUTPUT_RAW`, µs.
pub const SERVO_PERIOD_US: u64 = 100_000;
/// Period of `SYS_STATUS`, µs.
pub const SYS_STATUS_PERIOD_US: u64 = 500_000;
/// Period of `RC_CHANNELS`, µs, once a receiver was heard.
pub const RADIO_PERIOD_US: u64 = 250_000;
/// Shortest time between two `STATUSTEXT`, µs.
pub const TEXT_PERIOD_US: u64 = 100_000;

/// Time from one `NAMED_VALUE_INT` to the next, µs; they take turns.
pub const FIGURE_PERIOD_US: u64 = 250_000;

/// Figures that there is room for.
pub const FIGURES: usize = 14;

/// What a board measures of itself: names of at most 10 characters, and values.
pub type Figures = [(&'static str, u32); FIGURES];

/// Texts that may wait; what comes beyond is dropped and counted.
const TEXTS_MAX: usize = 16;
const ANSWERS_MAX: usize = 8;

/// Writes messages when they are due.
#[derive(Clone, Debug)]
pub struct Telemetry {
    writer: FrameWriter,
    answers: heapless::Deque<Answer, ANSWERS_MAX>,
    texts: heapless::Deque<(MavSeverity, Text), TEXTS_MAX>,
    parameters: Parameters,
    told: Option<Arming>,
    told_unit: ImuUnit,
    told_io: IoState,
    /// Was the radio heard when that was told last?
    told_radio: bool,
    told_acro: bool,
    told_battery_low: bool,
    figures: Figures,
    next_figure: usize,
    heartbeat: Due,
    attitude: Due,
    servo: Due,
    sys_status: Due,
    radio: Due,
    text: Due,
    figure: Due,
    /// Texts and answers for which there was no room.
    pub dropped: u32,
}

impl Telemetry {
    /// A sender that has sent nothing; with the parameters that it can report.
    pub fn new(settings: &LinkSettings, params: &Params) -> Self {
        Self {
            writer: FrameWriter::new(settings.system_id, COMPONENT_ID),
            answers: heapless::Deque::new(),
            texts: heapless::Deque::new(),
            parameters: Parameters::new(params),
            told: None,
            told_unit: ImuUnit::default(),
            told_io: IoState::default(),
            told_radio: false,
            told_acro: false,
            told_battery_low: false,
            figures: [("", 0); FIGURES],
            next_figure: 0,
            heartbeat: Due::every(HEARTBEAT_PERIOD_US),
            attitude: Due::every(ATTITUDE_PERIOD_US),
            servo: Due::every(SERVO_PERIOD_US),
            sys_status: Due::every(SYS_STATUS_PERIOD_US),
            radio: Due::every(RADIO_PERIOD_US),
            text: Due::every(TEXT_PERIOD_US),
            figure: Due::every(FIGURE_PERIOD_US),
            dropped: 0,
        }
    }

    /// Takes an answer to be sent. A refusal is also put into words.
    pub fn answer(&mut self, answer: Answer) {
        if let Answer::Refused(_, refusal) | Answer::ParameterRefused(_, refusal) | Answer::RadioRefused(refusal) =
            answer
        {
            self.text(MavSeverity::MAV_SEVERITY_WARNING, refusal.words());
        }
        if let Answer::ParameterRefused(field, _) = answer {
            self.parameters.tell(field);
            return;
        }
        self.count_dropped(self.answers.is_full());
        let _ = self.answers.push_back(answer);
    }

    /// Takes what the board has measured of itself; one without a name is not sent.
    pub fn figures(&mut self, figures: Figures) {
        self.figures = figures;
    }

    /// Serves the parameters; `store` as in [`Parameters::serve`].
    pub fn serve_parameters(&mut self, request: &ParameterRequest, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) {
        if let Some(words) = self.parameters.serve(request, store) {
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, &words);
        }
    }

    /// Stores the choices as they are, and says what came of it.
    pub fn store_configuration(&mut self, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) {
        let kept = self.parameters.store(store);
        let words = if kept { "configuration stored" } else { "configuration not stored: memory failed" };
        self.text(MavSeverity::MAV_SEVERITY_NOTICE, words);
    }

    /// Stores how the IMUs sit on a vehicle that stands still and level, and says what came of it.
    pub fn calibrate_level(&mut self, status: &VehicleStatus, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) {
        const COMMAND: MavCmd = MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION;
        let [first, second] = status.rest_force_m_s2;
        let trim = |force_m_s2: Vector3<f32>| LevelTrim::of_level_vehicle(&force_m_s2, STANDARD_GRAVITY_M_S2);
        let Some(force_m_s2) = first else { return self.answer(Answer::Refused(COMMAND, Refusal::VehicleMoves)) };
        let Some(found) = trim(force_m_s2) else { return self.answer(Answer::Refused(COMMAND, Refusal::NotLevel)) };
        let second = second.and_then(trim).map(|trim| LevelParams::new(&trim));
        if self.parameters.set_level((LevelParams::new(&found), second), store) {
            self.answer(Answer::Accepted(COMMAND));
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, "level stored for the next start");
        } else {
            self.answer(Answer::Busy(COMMAND));
            self.text(MavSeverity::MAV_SEVERITY_WARNING, "level not stored: memory failed");
        }
    }

    /// Takes a text to be sent; what is beyond 50 bytes is cut off.
    pub fn text(&mut self, severity: MavSeverity, words: &str) {
        let mut text = Text::new();
        for character in words.chars() {
            if text.push(character).is_err() {
                break;
            }
        }
        self.count_dropped(self.texts.is_full());
        let _ = self.texts.push_back((severity, text));
    }

    /// Writes what is due and fits into `out`; what does not fit stays due.
    pub fn poll<const N: usize>(&mut self, time_us: u64, status: &VehicleStatus, out: &mut heapless::Vec<u8, N>) {
        self.tell_arming(&status.arming);
        self.tell_unit(status.imu_unit);
        self.tell_io(status);
        self.tell_battery(status);
        while let Some(answer) = self.answers.front() {
            if command_ack(answer).is_some_and(|data| !self.writer.write(&data, out)) {
                return;
            }
            self.answers.pop_front();
        }
        if self.heartbeat.is(time_us) && self.writer.write(&heartbeat(status), out) {
            self.heartbeat.done(time_us);
        }
        if let (true, Some((severity, text))) = (self.text.is(time_us), self.texts.front())
            && self.writer.write(&STATUSTEXT_DATA { severity: *severity, text: text.as_str().into() }, out)
        {
            self.text.done(time_us);
            self.texts.pop_front();
        }
        self.parameters.write_next(&mut self.writer, out);
        if self.attitude.is(time_us) && self.writer.write(&attitude(time_us, &status.estimate), out) {
            self.attitude.done(time_us);
        }
        if self.servo.is(time_us) && self.writer.write(&servo_output(time_us, status), out) {
            self.servo.done(time_us);
        }
        if self.sys_status.is(time_us) && self.writer.write(&sys_status(status), out) {
            self.sys_status.done(time_us);
        }
        if status.io.radio.count > 0
            && self.radio.is(time_us)
            && self.writer.write(&radio_channels(time_us, &status.io.radio), out)
        {
            self.radio.done(time_us);
        }
        if self.figure.is(time_us) && self.write_figure(time_us, out) {
            self.figure.done(time_us);
        }
    }

    /// False if there was no room.
    fn write_figure<const N: usize>(&mut self, time_us: u64, out: &mut heapless::Vec<u8, N>) -> bool {
        let figure = self.figures.get(self.next_figure).copied().unwrap_or_default();
        let (name, value) = figure;
        let data = NAMED_VALUE_INT_DATA { time_boot_ms: wrapped_ms(time_us), value: value as i32, name: name.into() };
        let told = name.is_empty() || self.writer.write(&data, out);
        if told {
            self.next_figure = if self.next_figure + 1 < self.figures.len() { self.next_figure + 1 } else { 0 };
        }
        told
    }

    /// Refusals have been reported by their answer.
    fn tell_arming(&mut self, arming: &Arming) {
        if self.told == Some(*arming) {
            return;
        }
        let link_is_back = matches!((self.told, arming), (Some(Arming::LinkLost { .. }), Arming::Armed));
        if link_is_back {
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, "link back: armed");
        } else if let Some((severity, words)) = arming_words(arming) {
            self.text(severity, words);
        }
        self.told = Some(*arming);
    }

    fn tell_unit(&mut self, unit: ImuUnit) {
        if self.told_unit == unit {
            return;
        }
        match unit {
            ImuUnit::First => self.text(MavSeverity::MAV_SEVERITY_NOTICE, "first IMU in use again"),
            ImuUnit::Second => self.text(MavSeverity::MAV_SEVERITY_CRITICAL, "first IMU failed: second in use"),
        }
        self.told_unit = unit;
    }

    /// Who is at the IO chip's end where that is not as it should be, and who has the sticks.
    fn tell_io(&mut self, status: &VehicleStatus) {
        if self.told_io != status.io.state
            && let Some(words) = io_words(status.io.state)
        {
            self.text(MavSeverity::MAV_SEVERITY_CRITICAL, words);
        }
        self.told_io = status.io.state;
        let heard = status.radio_flies && status.io.radio.heard;
        match (self.told_radio, heard) {
            (false, true) => self.text(MavSeverity::MAV_SEVERITY_NOTICE, "radio heard: it has the sticks"),
            (true, false) => self.text(MavSeverity::MAV_SEVERITY_CRITICAL, "radio lost"),
            _ => {}
        }
        self.told_radio = heard;
        if self.told_acro != status.acro {
            let words = if status.acro { "mode: acro (rates)" } else { "mode: stabilise (angles)" };
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, words);
            self.told_acro = status.acro;
        }
    }

    /// Low in the air; at arming the refusal says it.
    fn tell_battery(&mut self, status: &VehicleStatus) {
        let low = status.battery_low && status.arming.is_armed();
        if low && !self.told_battery_low {
            self.text(MavSeverity::MAV_SEVERITY_CRITICAL, "battery low: land");
        }
        self.told_battery_low = low;
    }

    fn count_dropped(&mut self, dropped: bool) {
        if dropped {
            self.dropped = self.dropped.saturating_add(1);
        }
    }
}

/// When a message is due.
#[derive(Clone, Copy, Debug)]
struct Due {
    period_us: u64,
    next_us: u64,
}

impl Due {
    fn every(period_us: u64) -> Self {
        Self { period_us, next_us: 0 }
    }

    fn is(&self, time_us: u64) -> bool {
        time_us >= self.next_us
    }

    /// A message that is late by more than its period is not made up for.
    fn done(&mut self, time_us: u64) {
        let on_time = self.next_us.saturating_add(self.period_us);
        self.next_us = if on_time > time_us { on_time } else { time_us.saturating_add(self.period_us) };
    }
}

#[cfg(test)]
mod tests;
