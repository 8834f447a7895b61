//! What is let in and what is not, as the other end of the link sees it.

extern crate std;
use super::record::SIGNING_RECORD_LEN;
use super::*;
use crate::link::frame::FrameWriter;
use crate::link::{LinkSettings, Order, Receiver};
use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA, MavCmd, MavType, SETUP_SIGNING_DATA,
};
use proptest::prelude::*;
use std::vec::Vec;

/// Of November 2026, as a ground station's clock says.
const TODAY: u64 = 37_500_000_000_000;

fn key(byte: u8) -> Key {
    Key::new([byte; 32]).unwrap()
}

/// The order to arm as pymavlink 2.4.50 signs it, with key 1, 2, .. 32 on link 3 at [`TODAY`].
#[rustfmt::skip]
const BY_PYMAVLINK: [u8; 55] = [
    0xfd, 0x1e, 0x01, 0x00, 0x00, 0xff, 0xbe, 0x4c, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x90, 0x01, 0x37, 0xc9, 0x03, 0x00, 0xd8, 0x2d, 0x26, 0x1b,
    0x22, 0x16, 0x21, 0xbe, 0xe3, 0x65, 0x8b,
];

/// An order to arm, signed so.
fn arms(signer: Option<(Key, u8, u64)>) -> Vec<u8> {
    let command = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
    frame(&COMMAND_LONG_DATA { command, param1: 1.0, ..COMMAND_LONG_DATA::DEFAULT }, signer)
}

fn frame(data: &impl MessageData, signer: Option<(Key, u8, u64)>) -> Vec<u8> {
    let mut writer = FrameWriter::new(255, 190);
    *writer.signer() = signer.map(|(key, link_id, timestamp)| {
        let mut signer = Signer::new(key, link_id);
        signer.set_clock(timestamp);
        signer
    });
    let mut bytes = heapless::Vec::<u8, 200>::new();
    assert!(writer.write(data, &mut bytes));
    bytes.to_vec()
}

/// A vehicle's end of the link, with a memory.
struct Vehicle {
    receiver: Receiver,
    guard: Guard,
    signing: Signing,
    memory: SigningRecord,
    memory_works: bool,
    time_us: u64,
}

impl Vehicle {
    fn start(memory: SigningRecord) -> Self {
        let (receiver, guard) = (Receiver::new(LinkSettings::NOMINAL), Guard::open());
        let mut vehicle =
            Self { receiver, guard, signing: Signing::new(memory), memory, memory_works: true, time_us: 0 };
        vehicle.pass(0);
        vehicle
    }

    /// With a key in force that was set up at [`TODAY`].
    fn with_key(of: u8) -> Self {
        let mut vehicle = Self::start(SigningRecord::default());
        vehicle.set_up(Some(key(of)), TODAY);
        vehicle
    }

    fn set_up(&mut self, key: Option<Key>, first_timestamp: u64) {
        let memory = &mut self.memory;
        let setup = SigningSetup { key, first_timestamp, is_local: true };
        assert!(self.signing.set_up(&setup, self.time_us, |record| {
            *memory = *record;
            true
        }));
        self.pass(0);
    }

    /// Housekeeping every 10 ms.
    fn pass(&mut self, time_ms: u64) {
        for _ in 0..=time_ms / 10 {
            let (memory, works) = (&mut self.memory, self.memory_works);
            self.signing.update(self.guard.latest_seen(), self.time_us, |record| {
                if works {
                    *memory = *record;
                }
                works
            });
            self.guard.follow(&self.signing.terms(self.time_us));
            self.time_us += 10_000;
        }
    }

    fn restarted(&self) -> Self {
        Self::start(SigningRecord::decode(&self.memory.encode()).unwrap())
    }

    fn hears(&mut self, bytes: &[u8]) -> usize {
        let (receiver, guard) = (&mut self.receiver, &mut self.guard);
        bytes.iter().filter_map(|byte| receiver.receive(*byte, guard)).count()
    }
}

#[test]
fn a_frame_is_signed_as_pymavlink_signs_it() {
    let key = Key::new(core::array::from_fn(|at| at as u8 + 1)).unwrap();
    assert_eq!(arms(Some((key, 3, TODAY))), BY_PYMAVLINK);
    let mut vehicle = Vehicle::start(SigningRecord::default());
    vehicle.set_up(Some(key), TODAY);
    assert_eq!([vehicle.hears(&BY_PYMAVLINK), vehicle.hears(&BY_PYMAVLINK)], [1, 0]);
}

#[test]
fn without_a_key_everybody_is_heard() {
    let mut vehicle = Vehicle::start(SigningRecord::default());
    assert_eq!(vehicle.hears(&arms(None)), 1);
    assert_eq!(vehicle.hears(&arms(Some((key(9), 0, TODAY)))), 1);
}

#[test]
fn with_a_key_only_what_is_signed_with_it_is_heard_and_only_once() {
    let mut vehicle = Vehicle::with_key(1);
    let right = arms(Some((key(1), 3, TODAY)));
    assert_eq!(vehicle.hears(&right), 1, "right");
    assert_eq!(vehicle.hears(&right), 0, "replayed");
    assert_eq!(vehicle.hears(&arms(None)), 0, "unsigned");
    assert_eq!(vehicle.hears(&arms(Some((key(2), 3, TODAY + 1)))), 0, "another key");
    assert_eq!(vehicle.guard.refused, Refused { unsigned: 1, wrong: 1, untimely: 1 });
    assert_eq!(vehicle.hears(&arms(Some((key(1), 3, TODAY + 5)))), 1, "later");
    assert_eq!(vehicle.hears(&arms(Some((key(1), 3, TODAY + 4)))), 0, "out of order");
    // another link has its own order
    assert_eq!(vehicle.hears(&arms(Some((key(1), 4, TODAY + 4)))), 1, "another link");
    let heartbeat = HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT };
    assert_eq!(vehicle.hears(&frame(&heartbeat, None)), 0, "an unsigned heartbeat keeps no link alive");
    assert_eq!(vehicle.hears(&frame(&HIL_SENSOR_DATA::DEFAULT, None)), 1, "a simulator signs nothing");
}

/// Every bit of a signed frame counts.
#[test]
fn a_changed_frame_is_not_heard() {
    let right = arms(Some((key(1), 0, TODAY)));
    for at in 0..8 * right.len() {
        let mut vehicle = Vehicle::with_key(1);
        let mut changed = right.clone();
        changed[at / 8] ^= 1 << (at % 8);
        // a changed length waits for bytes that do not come
        assert_eq!(vehicle.hears(&changed), 0, "bit {at}");
    }
    assert_eq!(Vehicle::with_key(1).hears(&right), 1);
}

/// Who was not heard before may be a minute behind, by the page of signing, and no more.
#[test]
fn a_clock_behind_is_not_heard() {
    let mut vehicle = Vehicle::with_key(1);
    let now = TODAY + 100 * PER_SECOND;
    vehicle.hears(&arms(Some((key(1), 0, now))));
    vehicle.pass(20);
    assert_eq!(vehicle.hears(&arms(Some((key(1), 1, now - 61 * PER_SECOND)))), 0);
    assert_eq!(vehicle.hears(&arms(Some((key(1), 2, now - 59 * PER_SECOND)))), 1);
    assert_eq!(vehicle.hears(&arms(Some((key(1), 3, TODAY - 1)))), 0, "before the key was");
}

/// A ground station that is ahead of the clock is heard from its second frame on; then the clock follows.
#[test]
fn the_clock_follows_the_ground() {
    let mut vehicle = Vehicle::with_key(1);
    let ahead = TODAY + 86_400 * PER_SECOND;
    assert_eq!(vehicle.hears(&arms(Some((key(1), 0, ahead)))), 0);
    vehicle.pass(20);
    assert_eq!(vehicle.hears(&arms(Some((key(1), 0, ahead + 1)))), 1);
    // an hour of a ground at its own pace, and of a clock that is as fast
    for second in 1..3600 {
        vehicle.pass(990);
        assert_eq!(vehicle.hears(&arms(Some((key(1), 0, ahead + second * PER_SECOND)))), 1, "{second}");
    }
    // signed with another key, a frame moves no clock
    let mut other = Vehicle::with_key(1);
    other.hears(&arms(Some((key(2), 0, ahead))));
    other.pass(20);
    assert!(other.signing.now(other.time_us) < TODAY + PER_SECOND);
}

/// Whatever was sent before the power went, heard or not, is not heard after it; the ground is, at once or a few
/// seconds later.
#[test]
fn nothing_old_passes_a_restart() {
    let mut vehicle = Vehicle::with_key(1);
    let mut sent = Vec::new();
    for tenth in 0..200 {
        sent.push(arms(Some((key(1), (tenth % 3) as u8, TODAY + tenth * PER_SECOND / 10))));
        assert_eq!(vehicle.hears(sent.last().unwrap()), 1);
        vehicle.pass(90);
    }
    let mut restarted = vehicle.restarted();
    for old in &sent {
        assert_eq!(restarted.hears(old), 0);
    }
    restarted.pass(20);
    let at_latest = TODAY + 20 * PER_SECOND + RESERVE + PER_SECOND;
    assert_eq!(restarted.hears(&arms(Some((key(1), 0, at_latest)))), 1);
    // what the vehicle signs is later than all that it signed before
    assert!(restarted.signing.now(0) >= vehicle.signing.now(vehicle.time_us));
}

/// With a memory that keeps nothing, what is let in ends with what was stored: no replay after a restart either.
#[test]
fn a_memory_that_fails_lets_nothing_new_in() {
    let mut vehicle = Vehicle::with_key(1);
    vehicle.memory_works = false;
    vehicle.pass(10_000);
    assert_eq!(vehicle.hears(&arms(Some((key(1), 0, TODAY + 10 * PER_SECOND)))), 0);
    let stored = vehicle.memory.ceiling;
    assert_eq!(vehicle.hears(&arms(Some((key(1), 0, stored)))), 1);
    assert_eq!(vehicle.restarted().hears(&arms(Some((key(1), 0, stored)))), 0);
}

/// More senders than are remembered: the forgotten ones' frames are not let in again.
#[test]
fn a_forgotten_sender_is_not_new() {
    let mut vehicle = Vehicle::with_key(1);
    let frames: Vec<_> = (0..200).map(|link_id| arms(Some((key(1), link_id, TODAY + u64::from(link_id))))).collect();
    for frame in &frames {
        assert_eq!(vehicle.hears(frame), 1);
    }
    for frame in &frames {
        assert_eq!(vehicle.hears(frame), 0);
    }
}

/// The key is changed beside the vehicle, whoever signs; elsewhere by nobody without the key.
#[test]
fn signing_is_set_up_beside_the_vehicle() {
    let data =
        SETUP_SIGNING_DATA { initial_timestamp: TODAY, target_system: 1, target_component: 1, secret_key: [2; 32] };
    let wanted = Order::SetUpSigning(SigningSetup { key: Some(key(2)), first_timestamp: TODAY, is_local: true });
    let order = |vehicle: &mut Vehicle, signer| {
        let bytes = frame(&data, signer);
        bytes.iter().find_map(|byte| vehicle.receiver.receive(*byte, &mut vehicle.guard))
    };
    let mut vehicle = Vehicle::with_key(1);
    assert_eq!(order(&mut vehicle, None), None);
    assert_eq!(order(&mut vehicle, Some((key(2), 0, TODAY))), None);
    vehicle.receiver = Receiver::local(LinkSettings::NOMINAL);
    assert_eq!(order(&mut vehicle, None), Some(wanted));
    assert_eq!(vehicle.hears(&arms(None)), 0, "nothing else is");
    vehicle.set_up(Some(key(2)), TODAY);
    assert_eq!(vehicle.hears(&arms(Some((key(1), 0, TODAY + 1)))), 0, "the old key");
    assert_eq!(vehicle.hears(&arms(Some((key(2), 0, TODAY + 1)))), 1);
    // the same key once more does not set the clock back: nothing is heard twice
    vehicle.set_up(Some(key(2)), 1);
    assert_eq!(vehicle.hears(&arms(Some((key(2), 0, TODAY + 1)))), 0);
    vehicle.set_up(None, 0);
    assert_eq!(vehicle.hears(&arms(None)), 1);
}

proptest! {
    #[test]
    fn a_record_comes_back_and_a_damaged_one_does_not(serial: u32, bytes: [u8; 32], ceiling: u64, at: usize, flip: u8) {
        let record = SigningRecord { serial, key: Key::new(bytes), ceiling };
        let mut encoded = record.encode();
        prop_assert_eq!(SigningRecord::decode(&encoded), Some(record));
        encoded[at % SIGNING_RECORD_LEN] ^= flip;
        prop_assert_eq!(SigningRecord::decode(&encoded).is_some(), flip == 0);
    }

    /// A write that is cut off at any byte leaves the record before; the serial may wrap.
    #[test]
    fn a_power_cut_leaves_a_record(serial: u32, cut in 0..SIGNING_RECORD_LEN) {
        let before = SigningRecord { serial, key: Key::new([7; 32]), ceiling: 1000 };
        let older = SigningRecord { serial: serial.wrapping_sub(1), ceiling: 900, ..before };
        let after = SigningRecord { serial: serial.wrapping_add(1), ceiling: 1100, ..before };
        let mut place = older.encode();
        place[..cut].copy_from_slice(&after.encode()[..cut]);
        let found = SigningRecord::latest([SigningRecord::decode(&place), Some(before)]);
        // the last bytes may have been the same before
        prop_assert!(found == before || place == after.encode(), "{found:?}");
        let [before, after] = [Some(before), Some(after)];
        for places in [[before, after], [after, before], [None, after], [after, None]] {
            prop_assert_eq!(Some(SigningRecord::latest(places)), after);
        }
    }
}
