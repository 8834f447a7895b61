//! What the ground wants to know once, or at another interval: taken, acknowledged, and told when there is room.

// older ground stations ask as is no longer recommended, and are answered
#![allow(deprecated)]

use mavlink::MessageData;
use mavlink::dialects::common::{
    AUTOPILOT_VERSION_DATA, AVAILABLE_MODES_DATA, COMPONENT_METADATA_DATA, MESSAGE_INTERVAL_DATA, MISSION_COUNT_DATA,
    MavCmd, PROTOCOL_VERSION_DATA, TIMESYNC_DATA,
};

use super::file_transfer::GENERAL_ADDRESS;
use super::frame::FrameWriter;
use super::identity::{autopilot_version, protocol_version};
use super::messages::wrapped_ms;
use super::mode::Mode;
use super::orders_and_answers::{Answer, Inquiry};
use super::streams::{IntervalRefused, Stream, Streams};
use super::vehicle_status::VehicleStatus;
use crate::supervisor::Refusal;

/// Messages that may wait; whoever wants more is told that the vehicle is busy.
const WAITING_MAX: usize = 12;

/// Bytes of a `COMPONENT_METADATA` with [`GENERAL_ADDRESS`].
const METADATA_MAX: usize = 8 + GENERAL_ADDRESS.len();

/// What the answers say.
pub(super) struct About<'a> {
    pub(super) streams: &'a Streams,
    pub(super) status: &'a VehicleStatus,
    /// CRC of the file at [`GENERAL_ADDRESS`], once it is known.
    pub(super) general_crc: Option<u32>,
}

/// A message to be sent once.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Single {
    AutopilotVersion,
    ProtocolVersion,
    Metadata,
    /// Counted from 1.
    Mode(u8),
    Interval(u32),
    PlanLength {
        kind: u8,
        asker: [u8; 2],
    },
    Time {
        their_ns: i64,
    },
}

/// What is still to be told.
#[derive(Clone, Debug, Default)]
pub(super) struct Inquiries {
    waiting: heapless::Deque<Single, WAITING_MAX>,
}

impl Inquiries {
    /// Takes one; the answer, if it came as a command.
    pub(super) fn take(&mut self, inquiry: &Inquiry, streams: &mut Streams) -> Option<Answer> {
        match *inquiry {
            Inquiry::Message { message_id, index, command } => {
                Some(self.take_message(message_id, index, command, streams))
            }
            Inquiry::Interval { message_id, interval_us } => {
                const COMMAND: MavCmd = MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL;
                let set = Stream::of_message(message_id).ok_or(IntervalRefused::Senseless);
                Some(match set.and_then(|stream| streams.set(stream, interval_us)) {
                    Ok(()) => Answer::Accepted(COMMAND),
                    Err(IntervalRefused::Senseless) => Answer::Senseless(COMMAND),
                    Err(IntervalRefused::LineFull) => Answer::Refused(COMMAND, Refusal::LineFull),
                })
            }
            Inquiry::TellInterval { message_id } => {
                const COMMAND: MavCmd = MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL;
                // the answer has 16 bits for it
                let known = message_id <= u32::from(u16::MAX);
                Some(if known {
                    self.push(&[Single::Interval(message_id)], COMMAND)
                } else {
                    Answer::Senseless(COMMAND)
                })
            }
            // no commands: whoever gets no answer repeats the question
            Inquiry::PlanLength { kind, asker } => {
                let _ = self.waiting.push_back(Single::PlanLength { kind, asker });
                None
            }
            Inquiry::Time { their_ns } => {
                let _ = self.waiting.push_back(Single::Time { their_ns });
                None
            }
        }
    }

    fn take_message(&mut self, message_id: u32, index: u32, command: MavCmd, streams: &mut Streams) -> Answer {
        const MODES: u32 = Mode::ALL.len() as u32;
        match (message_id, index) {
            (AUTOPILOT_VERSION_DATA::ID, _) => self.push(&[Single::AutopilotVersion], command),
            (PROTOCOL_VERSION_DATA::ID, _) => self.push(&[Single::ProtocolVersion], command),
            (COMPONENT_METADATA_DATA::ID, _) => self.push(&[Single::Metadata], command),
            (AVAILABLE_MODES_DATA::ID, 0) => {
                self.push(&core::array::from_fn::<_, { Mode::ALL.len() }, _>(|at| Single::Mode(at as u8 + 1)), command)
            }
            (AVAILABLE_MODES_DATA::ID, 1..=MODES) => self.push(&[Single::Mode(index as u8)], command),
            // what superseded MAV_CMD_GET_MESSAGE_INTERVAL; the answer has 16 bits for the message's id
            (MESSAGE_INTERVAL_DATA::ID, 0..=0xFFFF) => self.push(&[Single::Interval(index)], command),
            _ => match Stream::of_message(message_id) {
                Some(stream) => {
                    streams.request(stream);
                    Answer::Accepted(command)
                }
                None => Answer::Senseless(command),
            },
        }
    }

    /// All of them, or none.
    fn push(&mut self, singles: &[Single], command: MavCmd) -> Answer {
        if self.waiting.len() + singles.len() > WAITING_MAX {
            return Answer::Busy(command);
        }
        for single in singles {
            // there is room
            let _ = self.waiting.push_back(*single);
        }
        Answer::Accepted(command)
    }

    /// Writes what waits, as far as there is room.
    pub(super) fn write<const N: usize>(
        &mut self,
        writer: &mut FrameWriter,
        about: &About<'_>,
        time_us: u64,
        out: &mut heapless::Vec<u8, N>,
    ) {
        while let Some(single) = self.waiting.front() {
            let written = match *single {
                Single::AutopilotVersion => writer.write(&autopilot_version(), out),
                Single::ProtocolVersion => writer.write(&protocol_version(), out),
                Single::Metadata => {
                    let Some(crc) = about.general_crc else { return };
                    let head = [wrapped_ms(time_us), crc].map(u32::to_le_bytes);
                    let mut payload = heapless::Vec::<u8, METADATA_MAX>::new();
                    // the address without the zeros behind it: there is room for all of it
                    let _ = payload.extend_from_slice(head.as_flattened());
                    let _ = payload.extend_from_slice(GENERAL_ADDRESS.as_bytes());
                    let message = (COMPONENT_METADATA_DATA::ID, COMPONENT_METADATA_DATA::EXTRA_CRC);
                    writer.write_payload(message, &payload, out)
                }
                Single::Mode(index) => {
                    Mode::listed(index, about.status.controller).is_none_or(|data| writer.write(&data, out))
                }
                Single::Interval(message_id) => writer.write(&interval(message_id, about.streams), out),
                Single::PlanLength { kind, asker: [system, component] } => {
                    // count 0; the kind is an extension of the message
                    let payload = [0, 0, system, component, kind];
                    writer.write_payload((MISSION_COUNT_DATA::ID, MISSION_COUNT_DATA::EXTRA_CRC), &payload, out)
                }
                Single::Time { their_ns } => {
                    // since start; both wrap after 292 years
                    writer.write(&TIMESYNC_DATA { tc1: time_us as i64 * 1000, ts1: their_ns }, out)
                }
            };
            if !written {
                return;
            }
            self.waiting.pop_front();
        }
    }
}

/// 0 for what is never sent by itself and cannot be, -1 for what is not now: the message's own numbers.
fn interval(message_id: u32, streams: &Streams) -> MESSAGE_INTERVAL_DATA {
    let interval_us = match Stream::of_message(message_id) {
        None => 0,
        Some(stream) => streams.interval_us(stream).map_or(-1, |interval_us| interval_us as i32),
    };
    MESSAGE_INTERVAL_DATA { interval_us, message_id: message_id as u16 }
}
