//! Against a vehicle of a few lines behind a link that loses, doubles and swaps frames. The vehicle that flies is met
//! in `tests/tests`.

use super::*;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use shared_control::link::frame::FrameFinder;

/// Keeps logs and answers requests for them.
struct Keeper {
    logs: Vec<Vec<u8>>,
    finder: FrameFinder,
    writer: FrameWriter,
    /// Parts that are due: log, place, end.
    under_way: Option<(u16, usize, usize)>,
}

impl Keeper {
    fn new(logs: Vec<Vec<u8>>) -> Self {
        Self { logs, finder: FrameFinder::default(), writer: FrameWriter::new(1, 1), under_way: None }
    }

    fn frame(&mut self, data: &impl MessageData) -> Vec<u8> {
        let mut frame = heapless::Vec::<u8, 280>::new();
        assert!(self.writer.write(data, &mut frame));
        frame.to_vec()
    }

    fn take(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let extra = |id| match id {
            LOG_REQUEST_LIST_DATA::ID => Some(LOG_REQUEST_LIST_DATA::EXTRA_CRC),
            LOG_REQUEST_DATA_DATA::ID => Some(LOG_REQUEST_DATA_DATA::EXTRA_CRC),
            _ => None,
        };
        let mut answers = Vec::new();
        for byte in bytes {
            let Some(frame) = self.finder.push(*byte, extra) else { continue };
            if let Some(LOG_REQUEST_DATA_DATA { ofs, count, id, .. }) = message(&frame) {
                let end = (ofs as usize + count as usize).min(self.logs[usize::from(id)].len());
                self.under_way = Some((id, ofs as usize, end));
            } else {
                let count = self.logs.len() as u16;
                for id in 0..count {
                    let size = self.logs[usize::from(id)].len() as u32;
                    let entry = LOG_ENTRY_DATA { id, size, num_logs: count, ..LOG_ENTRY_DATA::DEFAULT };
                    answers.push(self.frame(&entry));
                }
            }
        }
        answers
    }

    /// A heartbeat and a few parts, as every 10 ms.
    fn send(&mut self) -> Vec<Vec<u8>> {
        let quadrotor = HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_QUADROTOR, ..HEARTBEAT_DATA::DEFAULT };
        let mut frames = vec![self.frame(&quadrotor)];
        for _ in 0..8 {
            let Some((id, at, end)) = self.under_way.filter(|(_, at, end)| at < end) else { break };
            let part = &self.logs[usize::from(id)][at..end.min(at + 90)];
            let mut message = LOG_DATA_DATA { id, ofs: at as u32, count: part.len() as u8, ..LOG_DATA_DATA::DEFAULT };
            message.data[..part.len()].copy_from_slice(part);
            self.under_way = Some((id, at + part.len(), end));
            frames.push(self.frame(&message));
        }
        frames
    }
}

/// Loses a fifth of the frames, doubles a tenth, lets a tenth wait for the next.
struct Link {
    random: Pcg32,
    waiting: Option<Vec<u8>>,
}

impl Link {
    fn carry(&mut self, frames: Vec<Vec<u8>>) -> Vec<u8> {
        let mut out = Vec::new();
        for frame in frames {
            match self.random.next_u32() % 10 {
                0 | 1 => {}
                2 => out.extend([&frame[..], &frame[..]].concat()),
                3 => self.waiting = Some(frame),
                _ => out.extend(frame),
            }
            if self.random.next_u32().is_multiple_of(2) {
                out.extend(self.waiting.take().unwrap_or_default());
            }
        }
        out
    }
}

fn log(length: usize, seed: u64) -> Vec<u8> {
    let mut random = Pcg32::seed_from_u64(seed);
    (0..length).map(|_| random.next_u32() as u8).collect()
}

#[test]
fn a_log_comes_whole_over_a_bad_link() {
    // the last part of one is full, that of the other is a byte; one has nothing
    let logs = vec![log(90 * 700, 1), log(90 * 40 + 1, 2), Vec::new()];
    for seed in 0..5 {
        let mut keeper = Keeper::new(logs.clone());
        let mut station = GroundStation::default();
        let mut link = Link { random: Pcg32::seed_from_u64(seed), waiting: None };
        let mut got = BTreeMap::new();
        station.list_logs();
        for now_ms in (0..60_000).step_by(10) {
            let answers = keeper.take(&link.carry(vec![station.send(now_ms)]));
            station.take(&link.carry(answers), now_ms);
            station.take(&link.carry(keeper.send()), now_ms);
            if let Some((entry, bytes, end)) = station.fetched() {
                assert!(!end.is_empty());
                got.insert(entry.id, bytes);
            }
            let listed = station.logs().unwrap_or_default();
            if station.fetching().is_none()
                && let Some(entry) = listed.iter().find(|entry| !got.contains_key(&entry.id))
            {
                station.fetch(entry.id, now_ms).unwrap();
            }
        }
        assert_eq!(got.into_values().collect::<Vec<_>>(), logs, "seed {seed}");
    }
}

#[test]
fn the_vehicle_is_the_first_that_was_heard_and_leaves_with_its_silence() {
    let mut station = GroundStation::default();
    let frame = |system: u8, data: &dyn Fn(&mut FrameWriter, &mut heapless::Vec<u8, 280>) -> bool| {
        let mut out = heapless::Vec::new();
        assert!(data(&mut FrameWriter::new(system, 1), &mut out));
        out.to_vec()
    };
    let heartbeat = |mavtype| HEARTBEAT_DATA {
        mavtype,
        base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
        ..HEARTBEAT_DATA::DEFAULT
    };
    let attitude = |roll| ATTITUDE_DATA { roll, pitch: -0.2, yaw: 3.0, ..ATTITUDE_DATA::DEFAULT };
    station.take(&frame(255, &|writer, out| writer.write(&heartbeat(MavType::MAV_TYPE_GCS), out)), 0);
    assert_eq!(station.vehicle(0), None);
    station.take(&frame(7, &|writer, out| writer.write(&heartbeat(MavType::MAV_TYPE_QUADROTOR), out)), 100);
    station.take(&frame(7, &|writer, out| writer.write(&attitude(0.1), out)), 200);
    station.take(&frame(8, &|writer, out| writer.write(&heartbeat(MavType::MAV_TYPE_QUADROTOR), out)), 300);
    station.take(&frame(8, &|writer, out| writer.write(&attitude(0.9), out)), 300);
    let says = |text| STATUSTEXT_DATA { text, ..STATUSTEXT_DATA::DEFAULT };
    station.take(&frame(8, &|writer, out| writer.write(&says("another's".into()), out)), 300);
    station.take(&frame(7, &|writer, out| writer.write(&says("disarmed".into()), out)), 200);
    assert_eq!(station.words().collect::<Vec<_>>(), ["disarmed"]);
    let vehicle = station.vehicle(400).unwrap();
    assert_eq!((vehicle.id, vehicle.is_armed, vehicle.attitude_rad), ((7, 1), true, Some([0.1, -0.2, 3.0])));
    assert_eq!(station.vehicle(3_200), None);
}

#[test]
fn a_vehicle_that_stops_answering_and_a_log_that_is_too_large_are_said() {
    let mut station = GroundStation::default();
    assert_eq!(station.fetch(3, 0), Err("the vehicle has no log 3".to_owned()));
    let entry = LogEntry { id: 3, size: SIZE_MAX + 1, begun_s: 0 };
    assert!(LogFetch::begin(&entry, 0).is_err());
    let mut fetch = LogFetch::begin(&LogEntry { size: 1000, ..entry }, 0).unwrap();
    // asked for, and again after silence only
    assert_eq!([fetch.due(0), fetch.due(399), fetch.due(400)], [Some((0, 1000)), None, Some((0, 1000))]);
    let mut part = LOG_DATA_DATA { id: 3, ofs: 90, count: 90, ..LOG_DATA_DATA::DEFAULT };
    fetch.take(&part, 500);
    assert_eq!([fetch.due(899), fetch.due(900)], [None, Some((0, 90))]);
    // of another log, not at a part's begin, beyond the end, shorter than it should be: nothing
    let before = fetch.share();
    for (id, ofs, count) in [(2, 0, 90), (3, 10, 90), (3, 1080, 90), (3, 0, 10)] {
        part = LOG_DATA_DATA { id, ofs, count, ..part };
        fetch.take(&part, 600);
    }
    assert_eq!(fetch.share(), before);
    assert!(!fetch.is_silent(10_499) && fetch.is_silent(10_500));
}
