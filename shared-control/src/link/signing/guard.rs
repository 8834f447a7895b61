//! Which frames are let in.

use mavlink::MessageData;
use mavlink::dialects::common::{HIL_SENSOR_DATA, SETUP_SIGNING_DATA};

use super::signature::{signature, stamp_of};
use super::{Key, NEWCOMER_BEHIND, Terms};
use crate::link::frame::Frame;

/// Senders that are remembered, each by system, component and link. Of more, the one with the oldest timestamp is
/// forgotten, and nothing up to that timestamp is taken from anybody new: a forgotten frame is no new one.
const SENDERS_MAX: usize = 16;

/// Frames that were not let in, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refused {
    /// Without a signature.
    pub unsigned: u32,
    /// With a signature that another key made, or of another frame.
    pub wrong: u32,
    /// Signed rightly, but seen before, or too old, or ahead of what is stored.
    pub untimely: u32,
}

/// One who has signed frames.
#[derive(Clone, Copy, Debug)]
struct Sender {
    id: [u8; 3],
    latest: u64,
}

/// Lets frames in, or not. One for all links of a vehicle: what came over one is not let in again over another, as far
/// as their ids are the same.
#[derive(Clone, Debug)]
pub struct Guard {
    terms: Terms,
    senders: heapless::Vec<Sender, SENDERS_MAX>,
    /// Nothing up to this is taken from a sender that is not remembered.
    forgotten: u64,
    latest_seen: u64,
    /// What was not let in.
    pub refused: Refused,
}

impl Guard {
    /// Lets everything in, until there is a key.
    pub fn open() -> Self {
        let terms = Terms { key: None, floor: 0, ceiling: 0, now: 0 };
        Self { terms, senders: heapless::Vec::new(), forgotten: 0, latest_seen: 0, refused: Refused::default() }
    }

    /// Goes by these terms from now on. Another key's senders are forgotten.
    pub fn follow(&mut self, terms: &Terms) {
        if terms.key != self.terms.key {
            self.senders.clear();
            (self.forgotten, self.latest_seen) = (0, 0);
        }
        self.terms = *terms;
    }

    /// The latest timestamp that came with a right signature, let in or not.
    pub fn latest_seen(&self) -> u64 {
        self.latest_seen
    }

    /// Is this frame let in? `is_local`: only somebody beside the vehicle can have sent it.
    #[inline(never)] // at each of the places where bytes arrive, it costs flash
    pub fn admits(&mut self, frame: &Frame, is_local: bool) -> bool {
        let Some(key) = self.terms.key else { return true };
        let Some(found) = &frame.signature else {
            let admitted = admits_unsigned(frame.message_id, is_local);
            self.refused.unsigned = counted(self.refused.unsigned, admitted);
            return admitted;
        };
        if !is_signed_with(&key, frame, found) {
            // whoever stands beside the vehicle may have another key
            let admitted = admits_unsigned(frame.message_id, is_local);
            self.refused.wrong = counted(self.refused.wrong, admitted);
            return admitted;
        }
        let (link_id, timestamp) = stamp_of(found);
        let admitted = self.is_timely([frame.system_id, frame.component_id, link_id], timestamp);
        self.latest_seen = self.latest_seen.max(timestamp);
        self.refused.untimely = counted(self.refused.untimely, admitted);
        admitted
    }

    /// Later than all that this sender has signed, and neither too old nor beyond the ceiling; then it is remembered.
    fn is_timely(&mut self, id: [u8; 3], timestamp: u64) -> bool {
        let Terms { floor, ceiling, now, .. } = self.terms;
        if timestamp <= floor || timestamp > ceiling {
            return false;
        }
        if let Some(sender) = self.senders.iter_mut().find(|sender| sender.id == id) {
            let later = timestamp > sender.latest;
            sender.latest = sender.latest.max(timestamp);
            return later;
        }
        let latest = self.senders.iter().fold(now, |latest, sender| latest.max(sender.latest));
        if timestamp <= self.forgotten || timestamp < latest.saturating_sub(NEWCOMER_BEHIND) {
            return false;
        }
        self.remember(Sender { id, latest: timestamp });
        true
    }

    fn remember(&mut self, newcomer: Sender) {
        if self.senders.is_full() {
            let oldest = self.senders.iter().enumerate().min_by_key(|(_, sender)| sender.latest);
            if let Some((at, latest)) = oldest.map(|(at, sender)| (at, sender.latest)) {
                self.forgotten = self.forgotten.max(latest);
                if let Some(place) = self.senders.get_mut(at) {
                    *place = newcomer;
                }
            }
        } else {
            // there is room
            let _ = self.senders.push(newcomer);
        }
    }
}

fn admits_unsigned(message_id: u32, is_local: bool) -> bool {
    message_id == HIL_SENSOR_DATA::ID || message_id == SETUP_SIGNING_DATA::ID && is_local
}

/// All bytes are compared, wherever the first difference is: how long it takes says nothing about it.
fn is_signed_with(key: &Key, frame: &Frame, found: &[u8; super::signature::SIGNATURE_LEN]) -> bool {
    let (link_id, timestamp) = stamp_of(found);
    let right = signature(key, &[&frame.header, &frame.payload, &frame.crc], link_id, timestamp);
    right.iter().zip(found).fold(0, |differences, (a, b)| differences | a ^ b) == 0
}

fn counted(count: u32, admitted: bool) -> u32 {
    if admitted { count } else { count.saturating_add(1) }
}
