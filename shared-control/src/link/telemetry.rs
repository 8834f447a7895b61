//! What the vehicle says of itself; at start, at rates that leave half of 57,600 baud free.

mod choices;
mod on_request;
mod signed;

use core::fmt::Write;

use mavlink::MessageData;
use mavlink::dialects::common::{COMMAND_ACK_DATA, MavSeverity, NAMED_VALUE_INT_DATA, STATUSTEXT_DATA};

use super::file_transfer::FileTransfer;
use super::frame::FrameWriter;
use super::inquiries::{About, Inquiries};
use super::log_download::LogDownload;
use super::messages::{
    arming_words, attitude, command_result, heartbeat, io_words, radio_channels, servo_output, sys_status, wrapped_ms,
};
use super::mode::Mode;
use super::orders_and_answers::{Answer, Inquiry, Text};
use super::parameters::Parameters;
use super::reports::{attitude_quaternion, attitude_target, battery, highres_imu, landed, system_time, vibration};
use super::settings::{COMPONENT_ID, LinkSettings};
use super::signing::{Refused, Signing, SigningRecord};
use super::spare_room::SpareRoom;
use super::streams::{Due, Stream, Streams};
use super::vehicle_status::VehicleStatus;
use crate::io_chip::IoState;
use crate::motor_loss::{MotorReport, Verdict};
use crate::params::Params;
use crate::sensing::imu_select::ImuUnit;
use crate::supervisor::Arming;

/// Shortest time between two `STATUSTEXT`, µs.
pub const TEXT_PERIOD_US: u64 = 100_000;

/// Shortest time between two texts about frames that were not let in, µs: whoever floods is not to fill the line.
const REFUSAL_PERIOD_US: u64 = 10_000_000;

/// Time from one `NAMED_VALUE_INT` to the next, µs; they take turns.
pub const FIGURE_PERIOD_US: u64 = 250_000;

/// Figures that there is room for.
pub const FIGURES: usize = 19;

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
    told_link_losses: u8,
    told_unit: ImuUnit,
    told_io: IoState,
    /// Was the radio heard when that was told last?
    told_radio: bool,
    told_mode: Mode,
    told_battery_low: bool,
    /// What the motors were when they were last spoken of, and which, 1 to 4.
    told_motors: (Verdict, u8),
    figures: Figures,
    next_figure: usize,
    streams: Streams,
    inquiries: Inquiries,
    files: FileTransfer,
    logs: LogDownload,
    room: SpareRoom,
    signing: Signing,
    told_refused: Refused,
    refusal: Due,
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
            told_link_losses: 0,
            told_unit: ImuUnit::default(),
            told_io: IoState::default(),
            told_radio: false,
            told_mode: Mode::Stabilise,
            told_battery_low: false,
            told_motors: Default::default(),
            figures: [("", 0); FIGURES],
            next_figure: 0,
            streams: Streams::new(settings.line_bytes_s),
            inquiries: Inquiries::default(),
            files: FileTransfer::default(),
            logs: LogDownload::default(),
            room: SpareRoom::new(settings.line_bytes_s),
            signing: Signing::new(SigningRecord::default()),
            told_refused: Refused::default(),
            refusal: Due::every(REFUSAL_PERIOD_US),
            text: Due::every(TEXT_PERIOD_US),
            figure: Due::every(FIGURE_PERIOD_US),
            dropped: 0,
        }
    }

    /// Takes an answer to be sent. A refusal is also put into words.
    pub fn answer(&mut self, answer: Answer) {
        if let Answer::Refused(_, refusal)
        | Answer::ParameterRefused(_, refusal)
        | Answer::RadioRefused(refusal)
        | Answer::LogsRefused(refusal) = answer
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

    /// Takes what the ground wants to know, and answers what came as a command.
    pub fn tell(&mut self, inquiry: &Inquiry) {
        if let Some(answer) = self.inquiries.take(inquiry, &mut self.streams) {
            self.answer(answer);
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
        self.tell_link_loss(status);
        self.tell_arming(&status.arming);
        self.tell_unit(status.imu_unit);
        self.tell_io(status);
        self.tell_battery(status);
        self.tell_motors(&status.motors);
        while let Some(answer) = self.answers.front() {
            if let Some((command, result)) = command_result(answer) {
                let [low, high] = command.to_le_bytes();
                let ack = (COMMAND_ACK_DATA::ID, COMMAND_ACK_DATA::EXTRA_CRC);
                if !self.writer.write_payload(ack, &[low, high, result as u8], out) {
                    return;
                }
            }
            self.answers.pop_front();
        }
        self.write_stream(Stream::Heartbeat, time_us, status, out);
        if let (true, Some((severity, text))) = (self.text.is(time_us), self.texts.front())
            && self.writer.write(&STATUSTEXT_DATA { severity: *severity, text: text.as_str().into() }, out)
        {
            self.text.done(time_us);
            self.texts.pop_front();
        }
        self.files.survey();
        let about = About { streams: &self.streams, status, general_crc: self.files.general_crc() };
        self.inquiries.write(&mut self.writer, &about, time_us, out);
        self.parameters.write_next(&mut self.writer, out);
        for stream in Stream::ALL {
            self.write_stream(stream, time_us, status, out);
        }
        if self.figure.is(time_us) && self.write_figure(time_us, out) {
            self.figure.done(time_us);
        }
    }

    /// Writes one of the regular messages, if it is due and fits.
    fn write_stream<const N: usize>(
        &mut self,
        stream: Stream,
        time_us: u64,
        status: &VehicleStatus,
        out: &mut heapless::Vec<u8, N>,
    ) {
        if !self.streams.is_due(stream, time_us) {
            return;
        }
        let writer = &mut self.writer;
        let written = match stream {
            Stream::Heartbeat => writer.write(&heartbeat(status), out),
            Stream::Attitude => writer.write(&attitude(time_us, &status.estimate), out),
            Stream::Servos => writer.write(&servo_output(time_us, status), out),
            Stream::SysStatus => writer.write(&sys_status(status), out),
            Stream::Radio if status.io.radio.count == 0 && !self.streams.is_requested(stream) => return,
            Stream::Radio => writer.write(&radio_channels(time_us, &status.io.radio), out),
            Stream::Quaternion => writer.write(&attitude_quaternion(time_us, &status.estimate), out),
            Stream::Target => writer.write(&attitude_target(time_us, status), out),
            Stream::Landed => writer.write(&landed(status), out),
            Stream::Battery => battery(status).is_none_or(|data| writer.write(&data, out)),
            Stream::Vibration => writer.write(&vibration(time_us, status), out),
            Stream::Mode => writer.write(&status.mode.in_use(status.controller), out),
            Stream::Time => writer.write(&system_time(time_us), out),
            Stream::Imu => highres_imu(time_us, status).is_none_or(|data| writer.write(&data, out)),
        };
        if written {
            self.streams.done(stream, time_us);
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

    /// A loss of the link, also one that is over already: what came of it is told as of any other.
    fn tell_link_loss(&mut self, status: &VehicleStatus) {
        if self.told_link_losses == status.link_losses {
            return;
        }
        self.told_link_losses = status.link_losses;
        let lost = match status.arming {
            lost @ Arming::LinkLost { .. } => lost,
            _ => Arming::LinkLost { since_us: 0 },
        };
        if matches!(self.told, Some(Arming::LinkLost { .. })) {
            self.tell_arming(&Arming::Armed);
        }
        self.tell_arming(&lost);
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
        if self.told_mode != status.mode {
            let words = match status.mode {
                Mode::Stabilise => "mode: stabilise (angles)",
                Mode::Acro => "mode: acro (rates)",
                Mode::Offboard => "mode: offboard (companion's set-points)",
            };
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, words);
            self.told_mode = status.mode;
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

    fn tell_motors(&mut self, motors: &MotorReport) {
        let found = (motors.verdict, motors.motor);
        let said = match motors.verdict {
            // passes, or becomes something else
            Verdict::Suspected => return,
            Verdict::Whole => None,
            Verdict::Weak => Some((MavSeverity::MAV_SEVERITY_WARNING, "lifts too little: told to lift more")),
            Verdict::Lost => Some((MavSeverity::MAV_SEVERITY_EMERGENCY, "lost: three fly on, heading given up")),
        };
        if let (Some((severity, words)), true) = (said, self.told_motors != found) {
            let mut text = Text::new();
            // 44 bytes fit
            let _ = write!(text, "motor {} {words}", motors.motor);
            self.text(severity, &text);
        }
        self.told_motors = found;
    }

    fn count_dropped(&mut self, dropped: bool) {
        if dropped {
            self.dropped = self.dropped.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests;
