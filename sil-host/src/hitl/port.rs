//! Messages to and from a board over any stream of bytes: a serial port, or a pipe in a test.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use mavlink::MessageData;
use mavlink::dialects::common::{COMMAND_ACK_DATA, HEARTBEAT_DATA, HIL_ACTUATOR_CONTROLS_DATA, STATUSTEXT_DATA};
use shared_control::link::frame::{Frame, FrameFinder, FrameWriter, message};

use crate::ground_station::{self, crc_extra};

/// Longest frame that is sent.
const FRAME_MAX: usize = 128;
/// Bytes that are read at once.
const CHUNK: usize = 256;

/// What a board says.
#[derive(Clone, Debug, PartialEq)]
pub enum FromBoard {
    /// It is there.
    Heartbeat(HEARTBEAT_DATA),
    /// The answer to a step.
    Controls(HIL_ACTUATOR_CONTROLS_DATA),
    /// What came of a command.
    Ack(COMMAND_ACK_DATA),
    /// Words for a person.
    Text(String),
}

/// How long is waited in real time. It decides nothing but when to give up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Without a byte, until nobody is there.
    pub silence: Duration,
    /// For the answer to a step, until it is sent again.
    pub answer: Duration,
    /// For words that follow upon what they are about.
    pub words: Duration,
}

impl Patience {
    /// For a board on a serial port: longer than its start (half a second), several times what the slowest USB adapter
    /// adds (16 ms), and a few texts at ten a second.
    pub const SERIAL: Patience = Patience {
        silence: Duration::from_secs(3),
        answer: Duration::from_millis(200),
        words: Duration::from_millis(300),
    };
    /// For a board in this very process, which has answered at once.
    pub const NONE: Patience = Patience { silence: Duration::ZERO, answer: Duration::ZERO, words: Duration::ZERO };
}

/// A board on the other end of a stream. Reading must return after a short time, with what is there or a time-out.
#[derive(Debug)]
pub struct BoardPort<S> {
    stream: S,
    finder: FrameFinder,
    writer: FrameWriter,
    heard: VecDeque<FromBoard>,
    pub(super) patience: Patience,
    /// Bytes that arrived.
    pub bytes_received: u64,
    /// Frames that arrived whole, whatever they held.
    pub frames_received: u64,
}

impl<S: Read + Write> BoardPort<S> {
    /// A board that has said nothing yet.
    pub fn new(stream: S, patience: Patience) -> Self {
        Self {
            stream,
            finder: FrameFinder::default(),
            writer: FrameWriter::new(ground_station::SYSTEM_ID, ground_station::COMPONENT_ID),
            heard: VecDeque::new(),
            patience,
            bytes_received: 0,
            frames_received: 0,
        }
    }

    /// The stream.
    pub fn stream(&self) -> &S {
        &self.stream
    }

    /// Sends a message.
    ///
    /// # Errors
    /// The stream's.
    pub fn send(&mut self, data: &impl MessageData) -> std::io::Result<()> {
        let mut frame = heapless::Vec::<u8, FRAME_MAX>::new();
        if !self.writer.write(data, &mut frame) {
            return Err(std::io::Error::new(ErrorKind::InvalidInput, "a message longer than any that a board takes"));
        }
        self.stream.write_all(&frame)?;
        self.stream.flush()
    }

    /// The next thing the board says; none if that takes longer than `patience`.
    ///
    /// # Errors
    /// The stream's, time-outs aside.
    pub fn receive(&mut self, patience: Duration) -> std::io::Result<Option<FromBoard>> {
        let give_up = Instant::now() + patience;
        loop {
            if let Some(news) = self.heard.pop_front() {
                return Ok(Some(news));
            }
            let news = self.read()?;
            if !news && Instant::now() >= give_up {
                return Ok(None);
            }
        }
    }

    /// True if bytes came.
    fn read(&mut self) -> std::io::Result<bool> {
        let mut chunk = [0; CHUNK];
        let count = match self.stream.read(&mut chunk) {
            Ok(count) => count,
            Err(error) if is_time_out(error.kind()) => 0,
            Err(error) => return Err(error),
        };
        for byte in chunk.iter().take(count) {
            if let Some(frame) = self.finder.push(*byte, crc_extra) {
                self.frames_received += 1;
                self.heard.extend(understood(&frame));
            }
        }
        self.bytes_received += count as u64;
        Ok(count > 0)
    }
}

fn is_time_out(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn understood(frame: &Frame) -> Option<FromBoard> {
    match frame.message_id {
        HEARTBEAT_DATA::ID => message(frame).map(FromBoard::Heartbeat),
        HIL_ACTUATOR_CONTROLS_DATA::ID => message(frame).map(FromBoard::Controls),
        COMMAND_ACK_DATA::ID => message(frame).map(FromBoard::Ack),
        STATUSTEXT_DATA::ID => message::<STATUSTEXT_DATA>(frame).map(|data| FromBoard::Text(words(&data))),
        _ => None,
    }
}

fn words(data: &STATUSTEXT_DATA) -> String {
    data.text.to_str().unwrap_or_default().to_owned()
}
