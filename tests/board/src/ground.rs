//! The ground station on TELEM1, or on USB.

use std::collections::BTreeMap;

use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, LOG_ENTRY_DATA, MANUAL_CONTROL_DATA, MavCmd, MavMessage, MavResult, MavType,
};
use mavlink::{MavlinkVersion, Message, MessageData};
use shared_control::link::frame::{FrameFinder, FrameWriter};

use crate::devices::usb_host::UsbHost;
use crate::machine::Machine;
use crate::time::Ticks;

/// What it sends and what it was told.
#[derive(Clone)]
pub struct Ground {
    over_usb: bool,
    writer: FrameWriter,
    finder: FrameFinder,
    texts: Vec<(Ticks, String)>,
    parameters: BTreeMap<String, f32>,
    results: Vec<(MavCmd, MavResult)>,
    heartbeats: u32,
    bytes_heard: u64,
    log_entries: Vec<LOG_ENTRY_DATA>,
    log_data: BTreeMap<(u16, u32), Vec<u8>>,
}

impl Default for Ground {
    fn default() -> Self {
        let (texts, parameters, results) = (Vec::new(), BTreeMap::new(), Vec::new());
        Self {
            over_usb: false,
            writer: FrameWriter::new(255, 190),
            finder: FrameFinder::default(),
            texts,
            parameters,
            results,
            heartbeats: 0,
            bytes_heard: 0,
            log_entries: Vec::new(),
            log_data: BTreeMap::new(),
        }
    }
}

impl Ground {
    /// One on the computer that USB leads to.
    pub fn on_usb() -> Self {
        Self { over_usb: true, ..Self::default() }
    }

    /// Sends a message.
    ///
    /// # Panics
    /// If it is longer than any that the vehicle knows.
    pub fn send(&mut self, machine: &mut Machine, message: &impl MessageData) {
        let mut bytes = heapless::Vec::<u8, 128>::new();
        assert!(self.writer.write(message, &mut bytes));
        if self.over_usb {
            machine.with_usb(|computer| computer.send(&bytes));
        } else {
            machine.telem1_send(&bytes);
        }
    }

    /// Sends a command with one parameter.
    pub fn command(&mut self, machine: &mut Machine, command: MavCmd, param1: f32) {
        let (target_system, target_component) = (1, 1);
        let data = COMMAND_LONG_DATA { command, param1, target_system, target_component, ..COMMAND_LONG_DATA::DEFAULT };
        self.send(machine, &data);
    }

    /// Shows that somebody is there.
    pub fn heartbeat(&mut self, machine: &mut Machine) {
        self.send(machine, &HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT });
    }

    /// Moves the throttle stick, 0 to 1000; the others stand in their middle.
    pub fn sticks(&mut self, machine: &mut Machine, throttle: i16) {
        self.send(machine, &MANUAL_CONTROL_DATA { target: 1, z: throttle, ..MANUAL_CONTROL_DATA::DEFAULT });
    }

    /// Takes what the board has sent.
    pub fn listen(&mut self, machine: &mut Machine) {
        let received = if self.over_usb { machine.with_usb(UsbHost::take_received) } else { machine.telem1_receive() };
        self.bytes_heard += received.len() as u64;
        for byte in received {
            let Some(frame) = self.finder.push(byte, |id| Some(MavMessage::extra_crc(id))) else { continue };
            match MavMessage::parse(MavlinkVersion::V2, frame.message_id, &frame.payload) {
                Ok(MavMessage::STATUSTEXT(status)) => {
                    let text = String::from_utf8_lossy(&*status.text).trim_end_matches('\0').to_owned();
                    self.texts.push((machine.now(), text));
                }
                Ok(MavMessage::PARAM_VALUE(value)) => {
                    self.parameters.insert(value.param_id.to_str().unwrap_or_default().to_owned(), value.param_value);
                }
                Ok(MavMessage::COMMAND_ACK(answer)) => self.results.push((answer.command, answer.result)),
                Ok(MavMessage::HEARTBEAT(_)) => self.heartbeats += 1,
                Ok(MavMessage::LOG_ENTRY(entry)) => self.log_entries.push(entry),
                Ok(MavMessage::LOG_DATA(piece)) => {
                    self.log_data.insert((piece.id, piece.ofs), piece.data[..piece.count.into()].to_vec());
                }
                _ => {}
            }
        }
    }

    /// Texts so far, with the time at which they had arrived.
    pub fn texts(&self) -> &[(Ticks, String)] {
        &self.texts
    }

    /// What came of each command that the board has answered so far.
    pub fn results(&self) -> &[(MavCmd, MavResult)] {
        &self.results
    }

    /// What the board said last of a parameter.
    pub fn parameter(&self, name: &str) -> Option<f32> {
        self.parameters.get(name).copied()
    }

    /// Logs that the board has listed so far.
    pub fn log_entries(&self) -> &[LOG_ENTRY_DATA] {
        &self.log_entries
    }

    /// Pieces of logs so far, by the log's id and the piece's first byte.
    pub fn log_data(&self) -> &BTreeMap<(u16, u32), Vec<u8>> {
        &self.log_data
    }

    /// What comes from here on is all that there is.
    pub fn forget_log_data(&mut self) {
        self.log_data.clear();
    }

    /// Bytes that the board has sent so far.
    pub fn bytes_heard(&self) -> u64 {
        self.bytes_heard
    }

    /// Of these, such that belonged to no frame.
    pub fn bytes_skipped(&self) -> u32 {
        self.finder.bytes_skipped
    }

    /// Heartbeats of the board so far.
    pub fn heartbeats(&self) -> u32 {
        self.heartbeats
    }
}
