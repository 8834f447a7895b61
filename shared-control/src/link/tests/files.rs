//! Files over the link, request by request, and read by somebody who reads on as the protocol's page says.

use super::*;
use crate::config::Controller;
use crate::params::Params;
use crate::params::table::Field;
use mavlink::dialects::common::{COMPONENT_METADATA_DATA, FILE_TRANSFER_PROTOCOL_DATA, MavCmd};
use std::string::String;
use std::{format, vec};

const CLOSE: u8 = 1;
const CLOSE_ALL: u8 = 2;
const LIST: u8 = 3;
const OPEN: u8 = 4;
const READ: u8 = 5;
const CRC: u8 = 14;
const BURST: u8 = 15;
const ACK: u8 = 128;
const NAK: u8 = 129;

const BAD_SIZE: u8 = 3;
const NO_SESSION: u8 = 4;
const ALL_TAKEN: u8 = 5;
const END_OF_FILE: u8 = 6;
const UNKNOWN: u8 = 7;
const READ_ONLY: u8 = 9;
const NOT_FOUND: u8 = 10;

const PATH: &[u8] = b"/parameters.json";

/// An answer, taken apart.
#[derive(Clone, Debug, PartialEq)]
struct Answered {
    to: [u8; 2],
    sequence: u16,
    session: u8,
    opcode: u8,
    request: u8,
    complete: bool,
    offset: u32,
    data: Vec<u8>,
}

impl Answered {
    fn of(message: &MavMessage) -> Option<Answered> {
        let MavMessage::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
            target_system,
            target_component,
            payload,
            ..
        }) = message
        else {
            return None;
        };
        Some(Answered {
            to: [*target_system, *target_component],
            sequence: u16::from_le_bytes([payload[0], payload[1]]),
            session: payload[2],
            opcode: payload[3],
            request: payload[5],
            complete: payload[6] == 1,
            offset: u32::from_le_bytes([payload[8], payload[9], payload[10], payload[11]]),
            data: payload[12..12 + usize::from(payload[4])].to_vec(),
        })
    }

    /// The reason, where it is a refusal.
    fn refusal(&self) -> Option<u8> {
        (self.opcode == NAK && self.data.len() == 1).then(|| self.data[0])
    }
}

struct Vehicle {
    receiver: Receiver,
    telemetry: Telemetry,
    time_us: u64,
    asker: [u8; 2],
    sequence: u16,
}

impl Vehicle {
    /// A second after start.
    fn new() -> Self {
        let telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
        let mut vehicle =
            Self { receiver: Receiver::new(SETTINGS), telemetry, time_us: 0, asker: [255, 190], sequence: 0 };
        vehicle.polls(100);
        vehicle
    }

    fn hear(&mut self, sequence: u16, (session, opcode): (u8, u8), (size, offset): (u8, u32), data: &[u8]) {
        let mut payload = [0; 251];
        payload[..2].copy_from_slice(&sequence.to_le_bytes());
        payload[2..5].copy_from_slice(&[session, opcode, size]);
        payload[8..12].copy_from_slice(&offset.to_le_bytes());
        payload[12..12 + data.len()].copy_from_slice(data);
        let message = FILE_TRANSFER_PROTOCOL_DATA { target_network: 0, target_system: 1, target_component: 1, payload };
        let mut raw = MAVLinkV2MessageRaw::new();
        let [system_id, component_id] = self.asker;
        raw.serialize_message_data(MavHeader { system_id: system_id.into(), component_id, sequence: 0 }, &message);
        for byte in raw.raw_bytes() {
            if let Some(Order::Files(request)) = self.receiver.receive(*byte, &mut Guard::open()) {
                self.telemetry.take_file_request(&request);
            }
        }
    }

    fn polls(&mut self, count: usize) -> Vec<MavMessage> {
        let mut messages = Vec::new();
        for _ in 0..count {
            let mut out = heapless::Vec::<u8, 280>::new();
            let status = VehicleStatus::at_start(Controller::Cascade);
            self.telemetry.poll(self.time_us, &status, &mut out);
            self.telemetry.send_files(self.time_us, &status, &mut NoLogs, &mut out);
            self.time_us += 10_000;
            messages.extend(decoded(&out));
        }
        messages
    }

    fn answers(&mut self, count: usize) -> Vec<Answered> {
        self.polls(count).iter().filter_map(Answered::of).collect()
    }

    /// The one answer to a new request.
    fn ask(&mut self, what: (u8, u8), range: (u8, u32), data: &[u8]) -> Answered {
        self.sequence += 1;
        self.hear(self.sequence, what, range, data);
        let answers = self.answers(20);
        assert_eq!(answers.len(), 1, "{answers:?}");
        let expected = (self.asker, self.sequence + 1, what.1);
        assert_eq!((answers[0].to, answers[0].sequence, answers[0].request), expected);
        answers[0].clone()
    }

    fn path(&mut self, opcode: u8, path: &[u8]) -> Answered {
        self.ask((0, opcode), (path.len() as u8, 0), path)
    }

    /// Session and length.
    fn open(&mut self, path: &[u8]) -> (u8, u32) {
        let answer = self.path(OPEN, path);
        assert_eq!(answer.opcode, ACK);
        (answer.session, u32::from_le_bytes(answer.data.try_into().unwrap()))
    }

    fn read_all(&mut self, path: &[u8]) -> Vec<u8> {
        let (session, length) = self.open(path);
        let mut file = Vec::new();
        while (file.len() as u32) < length {
            let answer = self.ask((session, READ), (239, file.len() as u32), b"");
            assert_eq!((answer.opcode, answer.offset), (ACK, file.len() as u32));
            file.extend(answer.data);
        }
        let end = self.ask((session, READ), (239, length), b"");
        assert_eq!(end.refusal(), Some(END_OF_FILE));
        file
    }
}

/// MAVLink's CRC-32 from its table, as ground stations compute it.
fn crc(bytes: &[u8]) -> u32 {
    let table = |index: u32| (0..8).fold(index, |c, _| if c & 1 == 1 { 0xEDB8_8320 ^ (c >> 1) } else { c >> 1 });
    bytes.iter().fold(0, |crc, byte| table((crc ^ u32::from(*byte)) & 0xFF) ^ (crc >> 8))
}

#[test]
fn the_files_are_found_from_component_metadata_on() {
    let mut vehicle = Vehicle::new();
    let inquiry = Inquiry::Message { message_id: 397, index: 0, command: MavCmd::MAV_CMD_REQUEST_MESSAGE };
    vehicle.telemetry.tell(&inquiry);
    let found = vehicle.polls(5).into_iter().find_map(|message| match message {
        MavMessage::COMPONENT_METADATA(COMPONENT_METADATA_DATA { file_crc, uri, .. }) => Some((file_crc, uri)),
        _ => None,
    });
    let (general_crc, uri) = found.unwrap();
    assert_eq!(uri.split(|byte| *byte == 0).next(), Some(b"mftp:///general.json".as_slice()));
    let general = vehicle.read_all(b"/general.json");
    assert_eq!(crc(&general), general_crc);
    let parameters = vehicle.read_all(PATH);
    let text = String::from_utf8(general).unwrap();
    assert!(text.contains("\"type\":1,\"uri\":\"mftp:///parameters.json\","), "{text}");
    assert!(text.contains(&format!("\"fileCrc\":{}}}", crc(&parameters))), "{text}");
    for (path, file) in [(PATH, crc(&parameters)), (b"general.json", general_crc)] {
        assert_eq!(vehicle.path(CRC, path).data, file.to_le_bytes());
    }
}

/// Of each parameter one object with all that the table has; no text needs an escape that JSON would have.
#[test]
fn every_parameter_is_described_as_the_table_has_it() {
    let text = String::from_utf8(Vehicle::new().read_all(PATH)).unwrap();
    assert_eq!(text.matches("\"name\":").count(), Field::ALL.len());
    for field in Field::ALL {
        let (row, (least, most)) = (field.row(), field.row().allowed.ends());
        let default = row.allowed.number(Params::DEFAULT.get(field));
        let object = format!(
            "{{\"name\":\"{}\",\"type\":\"Float\",\"group\":\"{}\",\"shortDesc\":\"{}\",\"units\":\"{}\",\
             \"default\":{default},\"min\":{least},\"max\":{most},",
            row.name,
            field.group(),
            row.meaning,
            row.unit
        );
        assert!(text.contains(&object), "{object}");
        let texts = [row.name, row.meaning, row.unit];
        let is_plain = |c: char| c.is_ascii() && !c.is_ascii_control() && c != '"' && c != '\\';
        assert!(texts.iter().all(|text| text.chars().all(is_plain)), "{texts:?}");
        for end in [least, most] {
            assert!(row.allowed.bits(end as f32).is_some(), "{}: {end}", row.name);
        }
    }
}

/// Wherever a piece begins, in whatever order they are read.
#[test]
fn every_piece_is_that_of_the_whole() {
    let mut vehicle = Vehicle::new();
    let file = vehicle.read_all(PATH);
    let (session, length) = vehicle.open(PATH);
    assert_eq!(length as usize, file.len());
    for step in 0..60_usize {
        let offset = step * 7919 % file.len();
        let answer = vehicle.ask((session, READ), (80, offset as u32), b"");
        assert_eq!(answer.data, file[offset..file.len().min(offset + 80)], "{offset}");
    }
}

/// Of a second at 57,600 baud, so that nobody who asks takes the vehicle for silent; each says where it ends, and the
/// next begins there.
#[test]
fn bursts_are_the_file_and_say_where_they_end() {
    let mut vehicle = Vehicle::new();
    let file = vehicle.read_all(PATH);
    let (session, _) = vehicle.open(PATH);
    let (mut read, mut sequence) = (file[..160].to_vec(), 500);
    while read.len() < file.len() {
        let begin = read.len() as u32;
        vehicle.hear(sequence, (session, BURST), (80, begin), b"");
        let answers = vehicle.answers(200);
        for (at, answer) in answers.iter().enumerate() {
            assert_eq!((answer.sequence, answer.offset), (sequence + 1 + at as u16, begin + 80 * at as u32));
            assert_eq!(answer.complete, at + 1 == answers.len());
            read.extend(&answer.data);
        }
        assert!(answers.len() == 24 || read.len() == file.len(), "{} pieces", answers.len());
        sequence += 100;
    }
    assert_eq!(read, file);
    let behind = vehicle.ask((session, BURST), (80, file.len() as u32), b"");
    assert_eq!(behind.refusal(), Some(END_OF_FILE));
    // closed under way
    vehicle.hear(9000, (session, BURST), (80, 0), b"");
    vehicle.hear(9001, (session, CLOSE), (0, 0), b"");
    let last = vehicle.answers(2000).pop().unwrap();
    assert_eq!((last.sequence, last.request, last.opcode), (9002, CLOSE, ACK));
}

#[test]
fn a_repeated_request_has_the_same_answer() {
    let mut vehicle = Vehicle::new();
    let mut twice = |what, range, data: &[u8]| {
        vehicle.sequence += 1;
        let sequence = vehicle.sequence;
        let mut once = || {
            vehicle.hear(sequence, what, range, data);
            vehicle.answers(20)
        };
        let answers = [once(), once()];
        assert_eq!(answers[0].len(), 1, "{answers:?}");
        assert_eq!(answers[0], answers[1]);
        answers[0][0].clone()
    };
    let session = twice((0, OPEN), (PATH.len() as u8, 0), PATH).session;
    twice((session, READ), (80, 1234), b"");
    assert_eq!(twice((session, CLOSE), (0, 0), b"").opcode, ACK);
    assert_eq!(twice((session, CLOSE), (0, 0), b"").refusal(), Some(NO_SESSION), "another is refused");
    assert_eq!(twice((0, CLOSE_ALL), (0, 0), b"").opcode, ACK);
    assert_eq!(twice((0, LIST), (1, 0), b"/").opcode, ACK);
}

/// What comes again after what followed it changes nothing any more.
#[test]
fn a_late_repetition_ends_nothing() {
    let mut vehicle = Vehicle::new();
    let (session, _) = vehicle.open(PATH);
    let opened_by = vehicle.sequence;
    vehicle.hear(700, (session, BURST), (80, 0), b"");
    vehicle.answers(2);
    vehicle.hear(opened_by, (0, OPEN), (PATH.len() as u8, 0), PATH);
    assert!(vehicle.answers(2000).last().is_some_and(|answer| answer.request == BURST && answer.complete));
    vehicle.ask((session, CLOSE), (0, 0), b"");
    let closed_by = vehicle.sequence;
    let (session, _) = vehicle.open(PATH);
    vehicle.hear(closed_by, (session, CLOSE), (0, 0), b"");
    assert_eq!(vehicle.answers(20)[0].opcode, ACK);
    assert_eq!(vehicle.ask((session, READ), (10, 0), b"").opcode, ACK, "still open");
}

/// A program that starts ends all sessions and opens a file at once; a network may swap the two.
#[test]
fn a_reset_that_was_overtaken_ends_nothing() {
    let mut vehicle = Vehicle::new();
    vehicle.hear(41, (0, OPEN), (PATH.len() as u8, 0), PATH);
    let session = vehicle.answers(20)[0].session;
    vehicle.hear(40, (0, CLOSE_ALL), (0, 0), b"");
    assert_eq!(vehicle.answers(20)[0].opcode, ACK, "answered all the same");
    assert_eq!(vehicle.ask((session, READ), (10, 0), b"").opcode, ACK, "still open");
    vehicle.hear(43, (0, CLOSE_ALL), (0, 0), b"");
    assert_eq!(vehicle.answers(20)[0].opcode, ACK);
    assert_eq!(vehicle.ask((session, READ), (10, 0), b"").refusal(), Some(NO_SESSION), "in its turn it ends all");
}

#[test]
fn what_cannot_be_is_refused_with_its_reason() {
    let mut vehicle = Vehicle::new();
    for opcode in 6..=13 {
        assert_eq!(vehicle.path(opcode, PATH).refusal(), Some(READ_ONLY), "{opcode}");
    }
    for opcode in [16, 99, 127, 128] {
        assert_eq!(vehicle.path(opcode, PATH).refusal(), Some(UNKNOWN), "{opcode}");
    }
    for (opcode, path) in [(OPEN, b"/nothing".as_slice()), (OPEN, b"/"), (CRC, b"/"), (LIST, PATH), (LIST, b"/x")] {
        assert_eq!(vehicle.path(opcode, path).refusal(), Some(NOT_FOUND), "{opcode}");
    }
    // as long as a message can be
    assert_eq!(vehicle.path(OPEN, &[b'a'; 239]).refusal(), Some(NOT_FOUND));
    for opcode in [CLOSE, READ, BURST] {
        assert_eq!(vehicle.ask((0, opcode), (80, 0), b"").refusal(), Some(NO_SESSION), "{opcode}");
    }
    let (session, _) = vehicle.open(PATH);
    assert_eq!(vehicle.ask((session, READ), (240, 0), b"").refusal(), Some(BAD_SIZE));
    assert_eq!(vehicle.ask((session + 1, READ), (80, 0), b"").refusal(), Some(NO_SESSION));
    assert_eq!(vehicle.ask((session, READ), (80, u32::MAX), b"").refusal(), Some(END_OF_FILE));
    vehicle.asker = [255, 191];
    assert_eq!(vehicle.ask((session, READ), (80, 0), b"").refusal(), Some(NO_SESSION), "somebody else's");
}

#[test]
fn the_folder_lists_names_and_sizes() {
    let mut vehicle = Vehicle::new();
    let lengths = [b"/general.json".as_slice(), PATH].map(|path| vehicle.open(path).1);
    let entries = [format!("Fgeneral.json\t{}\0", lengths[0]), format!("Fparameters.json\t{}\0", lengths[1])];
    assert_eq!(vehicle.path(LIST, b"/").data, entries.concat().into_bytes());
    assert_eq!(vehicle.ask((0, LIST), (1, 1), b"/").data, entries[1].clone().into_bytes());
    assert_eq!(vehicle.ask((0, LIST), (1, 2), b"/").refusal(), Some(END_OF_FILE));
}

/// Four at once; a fifth when one of them has closed its file, or has been silent for long.
#[test]
fn four_read_at_once() {
    let mut vehicle = Vehicle::new();
    let askers = [190, 191, 192, 193].map(|component| [255, component]);
    for (session, asker) in askers.into_iter().enumerate() {
        vehicle.asker = asker;
        assert_eq!(usize::from(vehicle.open(PATH).0), session);
    }
    vehicle.asker = [254, 190];
    assert_eq!(vehicle.path(OPEN, PATH).refusal(), Some(ALL_TAKEN));
    vehicle.asker = askers[2];
    vehicle.ask((0, CLOSE_ALL), (0, 0), b"");
    vehicle.asker = [254, 190];
    assert_eq!(vehicle.open(PATH).0, 2);
    vehicle.asker = [254, 191];
    assert_eq!(vehicle.path(OPEN, PATH).refusal(), Some(ALL_TAKEN));
    vehicle.time_us += file_transfer::FORGOTTEN_AFTER_US;
    assert_eq!(vehicle.path(OPEN, PATH).opcode, ACK);
}

/// On a line of 57,600 baud, heartbeat and attitude keep coming at their rates, and no more than nine tenths are used.
#[test]
fn a_download_leaves_the_line_to_the_reports() {
    let mut vehicle = Vehicle::new();
    let (session, length) = vehicle.open(PATH);
    vehicle.hear(500, (session, BURST), (239, 0), b"");
    let mut messages = vehicle.polls(100);
    // the first burst is over by then
    let next = messages.iter().filter_map(Answered::of).map(|answer| answer.offset + answer.data.len() as u32).max();
    vehicle.hear(600, (session, BURST), (239, next.unwrap_or_default()), b"");
    messages.extend(vehicle.polls(100));
    let answers: Vec<_> = messages.iter().filter_map(Answered::of).collect();
    let attitudes = messages.iter().filter(|message| matches!(message, MavMessage::ATTITUDE(_))).count();
    let heartbeats = messages.iter().filter(|message| matches!(message, MavMessage::HEARTBEAT(_))).count();
    assert!((49..=51).contains(&attitudes) && (1..=3).contains(&heartbeats), "{attitudes} {heartbeats}");
    let bytes: usize = messages
        .iter()
        .map(|message| {
            let mut payload = vec![0; 255];
            12 + message.ser(MavlinkVersion::V2, &mut payload)
        })
        .sum();
    assert!(bytes as f64 <= 0.9 * 5760.0 * 2.0 + 280.0, "{bytes} bytes in 2 s");
    assert!(answers.iter().map(|answer| answer.data.len()).sum::<usize>() > 4000 && length > 4000);
}
