//! Logs over the link, with a ground station that does as MAVProxy does (`mavproxy_log.py` of 1.8.75): it keeps what
//! comes, after a silence asks for up to twenty gaps or for what follows, and takes a piece of no bytes for the end.

use super::*;
use crate::config::Controller;
use crate::params::Params;
use crate::signals::ArmingBlocks;
use crate::supervisor::Arming;
use mavlink::dialects::common::{
    LOG_DATA_DATA, LOG_ENTRY_DATA, LOG_ERASE_DATA, LOG_REQUEST_DATA_DATA, LOG_REQUEST_END_DATA, LOG_REQUEST_LIST_DATA,
};
use std::collections::BTreeSet;
use std::vec;

/// Housekeeping, us.
const POLL_US: u64 = 10_000;

/// Logs in memory.
struct Shelf(Vec<Vec<u8>>);

impl LogStore for Shelf {
    fn count(&mut self) -> u16 {
        self.0.len() as u16
    }

    fn size_bytes(&mut self, id: u16) -> u32 {
        self.0.get(usize::from(id)).map_or(0, |log| log.len() as u32)
    }

    fn read(&mut self, id: u16, offset: u32, piece: &mut [u8]) -> usize {
        let log = self.0.get(usize::from(id)).map(Vec::as_slice).unwrap_or_default();
        let from = log.get(offset as usize..).unwrap_or_default();
        let count = from.len().min(piece.len());
        piece[..count].copy_from_slice(&from[..count]);
        count
    }

    fn erase(&mut self) {
        self.0.clear();
    }
}

/// Bytes with no period that a piece could have.
fn log(length: usize) -> Vec<u8> {
    (0..length as u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as u8).collect()
}

/// A vehicle and what was sent of it last.
struct Vehicle {
    receiver: Receiver,
    commander: Commander,
    telemetry: Telemetry,
    status: VehicleStatus,
    shelf: Shelf,
    time_us: u64,
}

impl Vehicle {
    fn new(logs: Vec<Vec<u8>>) -> Self {
        Self {
            receiver: Receiver::new(SETTINGS),
            commander: Commander::new(&SETTINGS, ArmingBlocks::default()),
            telemetry: Telemetry::new(&SETTINGS, &Params::DEFAULT),
            status: VehicleStatus::at_start(Controller::Cascade),
            shelf: Shelf(logs),
            time_us: 0,
        }
    }

    fn hear(&mut self, frame: &[u8]) {
        for byte in frame {
            let Some(order) = self.receiver.receive(*byte, &mut Guard::open()) else { continue };
            let (answer, chore) = self.commander.order(&order, self.time_us);
            if let Some(answer) = answer {
                self.telemetry.answer(answer);
            }
            if let Some(Chore::Logs(request)) = chore {
                self.telemetry.take_log_request(&request, &mut self.shelf);
            }
        }
    }

    /// What it sends in a housekeeping.
    fn poll(&mut self) -> Vec<MavMessage> {
        let mut out = heapless::Vec::<u8, 280>::new();
        self.telemetry.poll(self.time_us, &self.status, &mut out);
        self.telemetry.send_files(self.time_us, &self.status, &mut self.shelf, &mut out);
        self.time_us += POLL_US;
        decoded(&out)
    }

    fn polls(&mut self, count: usize) -> Vec<MavMessage> {
        (0..count).flat_map(|_| self.poll()).collect()
    }
}

fn request(id: u16, ofs: u32, count: u32) -> Vec<u8> {
    encoded(&LOG_REQUEST_DATA_DATA { ofs, count, id, target_system: 1, target_component: 1 })
}

fn list(start: u16, end: u16) -> Vec<u8> {
    encoded(&LOG_REQUEST_LIST_DATA { start, end, target_system: 1, target_component: 1 })
}

fn entries(messages: &[MavMessage]) -> Vec<LOG_ENTRY_DATA> {
    let entry =
        |message: &MavMessage| if let MavMessage::LOG_ENTRY(data) = message { Some(data.clone()) } else { None };
    messages.iter().filter_map(entry).collect()
}

fn pieces(messages: &[MavMessage]) -> Vec<LOG_DATA_DATA> {
    let piece = |message: &MavMessage| if let MavMessage::LOG_DATA(data) = message { Some(data.clone()) } else { None };
    messages.iter().filter_map(piece).collect()
}

/// One direction of a link that loses, doubles and swaps.
struct BadLink {
    state: u64,
    kept: Option<Vec<u8>>,
}

impl BadLink {
    fn pass(&mut self, frame: Vec<u8>) -> Vec<Vec<u8>> {
        // Knuth's MMIX generator
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        match (self.state >> 33) % 100 {
            0..20 => vec![],
            20..30 if self.kept.is_none() => {
                self.kept = Some(frame);
                vec![]
            }
            90..100 => vec![frame.clone(), frame],
            _ => [frame].into_iter().chain(self.kept.take()).collect(),
        }
    }
}

/// What MAVProxy has of a log.
#[derive(Default)]
struct Ground {
    file: Vec<u8>,
    have: BTreeSet<u32>,
    done: bool,
}

impl Ground {
    fn take(&mut self, piece: &LOG_DATA_DATA) {
        let (at, count) = (piece.ofs as usize, usize::from(piece.count));
        if self.done {
            return;
        }
        if count > 0 {
            self.file.resize(self.file.len().max(at + count), 0);
            self.file[at..at + count].copy_from_slice(&piece.data[..count]);
            self.have.insert(piece.ofs / 90);
        }
        self.done = count == 0 || count < 90 && self.have.len() as u32 == 1 + piece.ofs / 90;
    }

    /// What it asks for when nothing came for a while.
    fn ask(&self) -> Vec<Vec<u8>> {
        let Some(highest) = self.have.last().copied() else { return vec![request(0, 0, u32::MAX)] };
        let missing: Vec<u32> = (0..highest).filter(|at| !self.have.contains(at)).collect();
        if missing.is_empty() {
            return vec![request(0, (1 + highest) * 90, u32::MAX)];
        }
        let mut gaps: Vec<(u32, u32)> = vec![];
        for at in missing {
            match gaps.last_mut() {
                Some((_, end)) if *end == at => *end += 1,
                _ => gaps.push((at, at + 1)),
            }
        }
        gaps.into_iter().take(20).map(|(from, to)| request(0, from * 90, (to - from) * 90)).collect()
    }
}

/// Of any length, whole pieces or not, in both directions through a link that loses a fifth.
#[test]
fn a_log_arrives_whole_over_a_bad_link() {
    for (length, seed) in [(1, 1), (89, 2), (90, 3), (180, 4), (4000, 5), (9000, 6), (9000, 7)] {
        let mut vehicle = Vehicle::new(vec![log(length)]);
        let (mut down, mut up) = (BadLink { state: seed, kept: None }, BadLink { state: seed + 100, kept: None });
        let mut ground = Ground::default();
        let mut heard_us = 0;
        for frame in ground.ask() {
            vehicle.hear(&frame);
        }
        while !ground.done && vehicle.time_us < 120_000_000 {
            for piece in pieces(&vehicle.poll()) {
                for frame in down.pass(encoded(&piece)) {
                    heard_us = vehicle.time_us;
                    let MavMessage::LOG_DATA(piece) =
                        MavMessage::parse(MavlinkVersion::V2, 120, &frame[10..frame.len() - 2]).unwrap()
                    else {
                        panic!("another message");
                    };
                    ground.take(&piece);
                }
            }
            if vehicle.time_us - heard_us > 700_000 {
                heard_us = vehicle.time_us;
                let asked: Vec<Vec<u8>> = ground.ask().into_iter().flat_map(|frame| up.pass(frame)).collect();
                for frame in asked {
                    vehicle.hear(&frame);
                }
            }
        }
        assert!(ground.done && ground.file == log(length), "{length} bytes, seed {seed}: {}", ground.file.len());
    }
}

#[test]
fn the_list_counts_from_nought_and_says_what_there_is() {
    let mut vehicle = Vehicle::new(vec![log(10), log(20), log(30)]);
    let told = |vehicle: &mut Vehicle| -> Vec<[u32; 4]> {
        let of = |one: &LOG_ENTRY_DATA| [one.id.into(), one.size, one.num_logs.into(), one.last_log_num.into()];
        entries(&vehicle.polls(100)).iter().map(of).collect()
    };
    vehicle.hear(&list(0, 0xFFFF));
    assert_eq!(told(&mut vehicle), [[0, 10, 3, 2], [1, 20, 3, 2], [2, 30, 3, 2]]);
    vehicle.hear(&list(1, 1));
    assert_eq!(told(&mut vehicle), [[1, 20, 3, 2]]);
    vehicle.hear(&list(7, 9));
    assert_eq!(told(&mut vehicle), [[2, 30, 3, 2]], "behind the last");
    // for another component
    vehicle.hear(&encoded(&LOG_ERASE_DATA { target_system: 1, target_component: 100 }));
    assert_eq!(vehicle.shelf.count(), 3);
    vehicle.hear(&encoded(&LOG_ERASE_DATA { target_system: 1, target_component: 1 }));
    vehicle.hear(&list(0, 0xFFFF));
    assert_eq!(told(&mut vehicle), [[0, 0, 0, 0]], "no logs");
    vehicle.hear(&request(0, 0, u32::MAX));
    assert_eq!(pieces(&vehicle.polls(100)).iter().map(|piece| piece.count).collect::<Vec<_>>(), [0]);
}

/// A piece of no bytes is sent only where the ground asks for nothing but what follows the end.
#[test]
fn what_is_asked_for_is_sent_and_no_more() {
    let mut vehicle = Vehicle::new(vec![log(270), log(100)]);
    let sent = |vehicle: &mut Vehicle, frames: &[Vec<u8>]| -> Vec<(u16, u32, u8)> {
        frames.iter().for_each(|frame| vehicle.hear(frame));
        pieces(&vehicle.polls(200)).iter().map(|piece| (piece.id, piece.ofs, piece.count)).collect()
    };
    assert_eq!(sent(&mut vehicle, &[request(0, 0, u32::MAX)]), [(0, 0, 90), (0, 90, 90), (0, 180, 90)]);
    assert_eq!(sent(&mut vehicle, &[request(0, 270, u32::MAX)]), [(0, 270, 0)]);
    assert_eq!(sent(&mut vehicle, &[request(0, u32::MAX, u32::MAX)]), [(0, u32::MAX, 0)]);
    assert_eq!(sent(&mut vehicle, &[request(1, 20, 100)]), [(1, 20, 80)]);
    // gaps one after the other; a doubled request once
    let gaps = [request(0, 90, 90), request(0, 0, 40), request(0, 90, 90)];
    assert_eq!(sent(&mut vehicle, &gaps), [(0, 90, 90), (0, 0, 40)]);
    // another log, or all of it, takes the place of what waits
    assert_eq!(sent(&mut vehicle, &[request(0, 0, 90), request(1, 0, 30)]), [(1, 0, 30)]);
    assert_eq!(sent(&mut vehicle, &[request(0, 0, 90), request(0, 180, u32::MAX)]), [(0, 180, 90)]);
    let end = encoded(&LOG_REQUEST_END_DATA { target_system: 1, target_component: 1 });
    assert_eq!(sent(&mut vehicle, &[request(0, 0, u32::MAX), end]), []);
}

/// A log takes what the line has left, and nothing regular waits for it.
#[test]
fn the_line_is_not_overbooked_by_a_log() {
    let count = |vehicle: &mut Vehicle| {
        let mut bytes = 0;
        let mut regular = 0;
        for _ in 0..1000 {
            let mut out = heapless::Vec::<u8, 280>::new();
            vehicle.telemetry.poll(vehicle.time_us, &vehicle.status, &mut out);
            regular += decoded(&out).len();
            vehicle.telemetry.send_files(vehicle.time_us, &vehicle.status, &mut vehicle.shelf, &mut out);
            bytes += out.len();
            vehicle.time_us += POLL_US;
        }
        (regular, bytes)
    };
    let (regular, _) = count(&mut Vehicle::new(vec![]));
    let mut vehicle = Vehicle::new(vec![log(1_000_000)]);
    vehicle.hear(&request(0, 0, u32::MAX));
    let (beside, bytes) = count(&mut vehicle);
    assert_eq!(beside, regular);
    let line = SETTINGS.line_bytes_s as usize * 10;
    assert!((line * 85 / 100..=line * 90 / 100 + 280).contains(&bytes), "{bytes} of {line}");
}

/// Armed, the vehicle has other things to do; the ground learns why nothing comes.
#[test]
fn an_armed_vehicle_sends_and_erases_none() {
    let mut vehicle = Vehicle::new(vec![log(100_000)]);
    vehicle.hear(&request(0, 0, u32::MAX));
    assert!(!pieces(&vehicle.polls(20)).is_empty());
    vehicle.status.arming = Arming::Armed;
    vehicle.commander.answer(&Arming::Armed);
    assert!(pieces(&vehicle.polls(20)).is_empty());
    for frame in
        [request(0, 0, u32::MAX), list(0, 9), encoded(&LOG_ERASE_DATA { target_system: 1, target_component: 1 })]
    {
        vehicle.hear(&frame);
    }
    let said = vehicle.polls(100);
    assert!(pieces(&said).is_empty() && entries(&said).is_empty());
    let text = |message: &MavMessage| {
        matches!(message, MavMessage::STATUSTEXT(data)
        if data.text.to_str() == Ok("refused: only when disarmed"))
    };
    assert_eq!(said.iter().filter(|message| text(message)).count(), 3);
    assert_eq!(vehicle.shelf.count(), 1);
}
