//! Bytes to news and back: what the vehicle says, one thing after the other, and what is sent to it.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, MavCmd, MavResult, PARAM_VALUE_DATA, RC_CHANNELS_DATA, STATUSTEXT_DATA,
    SYS_STATUS_DATA,
};
use shared_control::link::frame::{Frame, FrameFinder, FrameWriter, message};

use super::ConsoleError;
use crate::ground_station::{self, GroundStation, LogEntry, Vehicle, crc_extra};

/// Longest frame that is sent.
const FRAME_MAX: usize = 64;
/// Bytes that are read at once.
const CHUNK: usize = 2048;

/// What the vehicle says.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// What came of a command.
    Ack(u16, MavResult),
    /// Words for a person.
    Words(String),
    /// A parameter: name, value, index, how many there are.
    Parameter(String, f32, u16, u16),
    /// How it is.
    Health(SYS_STATUS_DATA),
    /// Pulses of the radio's channels, us.
    Channels(Vec<u16>),
}

/// A stream with a vehicle at its other end.
pub struct Link<S> {
    stream: S,
    ground: GroundStation,
    finder: FrameFinder,
    writer: FrameWriter,
    news: VecDeque<News>,
    begun: Instant,
}

impl<S: Read + Write> Link<S> {
    pub(super) fn new(stream: S) -> Self {
        Self {
            stream,
            ground: GroundStation::default(),
            finder: FrameFinder::default(),
            writer: FrameWriter::new(ground_station::SYSTEM_ID, ground_station::COMPONENT_ID),
            news: VecDeque::new(),
            begun: Instant::now(),
        }
    }

    #[cfg(test)]
    pub(super) fn stream(&self) -> &S {
        &self.stream
    }

    /// Until a vehicle is heard, for so long at most; false if none is.
    pub(super) fn find(&mut self, time: Duration, say: &mut dyn FnMut(&str)) -> Result<bool, ConsoleError> {
        let end = Instant::now() + time;
        while self.vehicle().is_none() && Instant::now() < end {
            self.wait(Duration::ZERO, say, |_| None::<()>)?;
            self.exchange()?;
        }
        Ok(self.vehicle().is_some())
    }

    /// System and component of the vehicle; those of all while none is heard.
    pub(super) fn target(&self) -> (u8, u8) {
        self.vehicle().map(|vehicle| vehicle.id).unwrap_or_default()
    }

    /// The vehicle, while it is heard.
    pub(super) fn vehicle(&self) -> Option<&Vehicle> {
        self.ground.vehicle(self.now_ms())
    }

    /// Until `pick` finds what it wants, for so long at most; the vehicle's words are said meanwhile.
    pub(super) fn wait<T>(
        &mut self,
        time: Duration,
        say: &mut dyn FnMut(&str),
        mut pick: impl FnMut(&News) -> Option<T>,
    ) -> Result<Option<T>, ConsoleError> {
        let end = Instant::now() + time;
        loop {
            while let Some(news) = self.news.pop_front() {
                if let News::Words(words) = &news {
                    say(&format!("vehicle: {words}"));
                }
                if let Some(found) = pick(&news) {
                    return Ok(Some(found));
                }
            }
            if Instant::now() >= end {
                return Ok(None);
            }
            self.exchange()?;
        }
    }

    /// Sends a message.
    pub(super) fn send(&mut self, data: &impl MessageData) -> Result<(), ConsoleError> {
        let mut frame = heapless::Vec::<u8, FRAME_MAX>::new();
        if self.writer.write(data, &mut frame) {
            self.stream.write_all(&frame)?;
            self.stream.flush()?;
        }
        Ok(())
    }

    /// Sends a command; parameters that are not given are zero.
    pub(super) fn send_command(&mut self, command: MavCmd, params: &[f32]) -> Result<(), ConsoleError> {
        let param = |at: usize| params.get(at).copied().unwrap_or_default();
        let (target_system, target_component) = self.target();
        self.send(&COMMAND_LONG_DATA {
            command,
            param1: param(0),
            param2: param(1),
            param3: param(2),
            param4: param(3),
            param5: param(4),
            param6: param(5),
            param7: param(6),
            target_system,
            target_component,
            ..COMMAND_LONG_DATA::DEFAULT
        })
    }

    /// The list of logs; none if it does not come.
    pub(super) fn logs(
        &mut self,
        time: Duration,
        say: &mut dyn FnMut(&str),
    ) -> Result<Option<Vec<LogEntry>>, ConsoleError> {
        let end = Instant::now() + time;
        self.ground.list_logs();
        while self.ground.logs().is_none() && Instant::now() < end {
            self.wait(Duration::ZERO, say, |_| None::<()>)?;
            self.exchange()?;
        }
        Ok(self.ground.logs())
    }

    /// A log of the list.
    pub(super) fn fetch(
        &mut self,
        id: u16,
        time: Duration,
        say: &mut dyn FnMut(&str),
    ) -> Result<Vec<u8>, ConsoleError> {
        let end = Instant::now() + time;
        self.ground.fetch(id, self.now_ms()).map_err(ConsoleError::Refused)?;
        loop {
            self.wait(Duration::ZERO, say, |_| None::<()>)?;
            self.exchange()?;
            if let Some((_, log, last_words)) = self.ground.fetched() {
                self.stream.write_all(&last_words)?;
                return Ok(log);
            }
            let is_silent = self.ground.fetching().is_none_or(|fetch| fetch.is_silent(self.now_ms()));
            if is_silent || Instant::now() >= end {
                self.ground.give_up();
                return Err(ConsoleError::Silent(format!("fetch {id}")));
            }
        }
    }

    /// Sends what is due, and takes what has come.
    fn exchange(&mut self) -> Result<(), ConsoleError> {
        let due = self.ground.send(self.now_ms());
        self.stream.write_all(&due)?;
        let mut chunk = [0; CHUNK];
        let count = match self.stream.read(&mut chunk) {
            Ok(0) => return Err(std::io::Error::from(ErrorKind::UnexpectedEof).into()),
            Ok(count) => count,
            Err(error) if is_time_out(error.kind()) => 0,
            Err(error) => return Err(error.into()),
        };
        let bytes = chunk.get(..count).unwrap_or_default();
        self.ground.take(bytes, self.now_ms());
        for byte in bytes {
            if let Some(frame) = self.finder.push(*byte, crc_extra) {
                self.news.extend(understood(&frame));
            }
        }
        Ok(())
    }

    fn now_ms(&self) -> u64 {
        self.begun.elapsed().as_millis() as u64
    }
}

fn is_time_out(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn understood(frame: &Frame) -> Option<News> {
    match frame.message_id {
        COMMAND_ACK_DATA::ID => {
            message::<COMMAND_ACK_DATA>(frame).map(|data| News::Ack(data.command as u16, data.result))
        }
        STATUSTEXT_DATA::ID => {
            message::<STATUSTEXT_DATA>(frame).map(|data| News::Words(data.text.to_str().unwrap_or_default().to_owned()))
        }
        PARAM_VALUE_DATA::ID => message::<PARAM_VALUE_DATA>(frame).map(|data| {
            let name = data.param_id.to_str().unwrap_or_default().to_owned();
            News::Parameter(name, data.param_value, data.param_index, data.param_count)
        }),
        SYS_STATUS_DATA::ID => message(frame).map(News::Health),
        RC_CHANNELS_DATA::ID => message::<RC_CHANNELS_DATA>(frame).map(|data| News::Channels(channels(&data))),
        _ => None,
    }
}

/// As many as the receiver has.
fn channels(data: &RC_CHANNELS_DATA) -> Vec<u16> {
    #[rustfmt::skip]
    let all = [
        data.chan1_raw, data.chan2_raw, data.chan3_raw, data.chan4_raw, data.chan5_raw, data.chan6_raw,
        data.chan7_raw, data.chan8_raw, data.chan9_raw, data.chan10_raw, data.chan11_raw, data.chan12_raw,
        data.chan13_raw, data.chan14_raw, data.chan15_raw, data.chan16_raw,
    ];
    all.into_iter().take(data.chancount.into()).collect()
}
