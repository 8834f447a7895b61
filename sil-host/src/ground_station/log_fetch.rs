//! One log of a vehicle, put together from `LOG_DATA` in whatever order it comes, with gaps asked for again
//! (<https://mavlink.io/en/messages/common.html#LOG_REQUEST_DATA>).

use mavlink::dialects::common::LOG_DATA_DATA;

use super::LogEntry;

/// Largest log that is fetched, bytes: an hour at the vehicle's own rates takes a tenth of it.
pub const SIZE_MAX: u32 = 512 << 20;
/// Bytes of a log in one message.
const PART: usize = 90;
/// So much is asked for at once: a vehicle that stops in the middle is noticed, and none of it floods a slow line.
const ASKED_AT_ONCE: usize = 512 * PART;
/// Silence after which what is missing is asked for again, ms.
const AGAIN_MS: u64 = 400;
/// Silence after which the vehicle is said not to answer, ms.
const GIVE_UP_MS: u64 = 10_000;

/// A log under way.
#[derive(Clone, Debug)]
pub struct LogFetch {
    entry: LogEntry,
    bytes: Vec<u8>,
    /// Which parts are there.
    has: Vec<bool>,
    missing: usize,
    /// The first part that is missing.
    first_missing: usize,
    /// Behind the last byte that was asked for.
    asked_to: usize,
    begun_ms: u64,
    heard_ms: u64,
    asked_ms: Option<u64>,
}

impl LogFetch {
    pub(super) fn begin(entry: &LogEntry, now_ms: u64) -> Result<Self, String> {
        if entry.size > SIZE_MAX {
            let (megabytes, most) = (entry.size >> 20, SIZE_MAX >> 20);
            return Err(format!("log {} has {megabytes} MB; at most {most} are fetched", entry.id));
        }
        let parts = (entry.size as usize).div_ceil(PART);
        Ok(Self {
            entry: *entry,
            bytes: vec![0; entry.size as usize],
            has: vec![false; parts],
            missing: parts,
            first_missing: 0,
            asked_to: 0,
            begun_ms: now_ms,
            heard_ms: now_ms,
            asked_ms: None,
        })
    }

    /// The log as the vehicle lists it.
    pub fn entry(&self) -> &LogEntry {
        &self.entry
    }

    pub(super) fn id(&self) -> u16 {
        self.entry.id
    }

    /// The share that is there, 0 to 1.
    pub fn share(&self) -> f64 {
        match self.has.len() {
            0 => 1.0,
            parts => 1.0 - self.missing as f64 / parts as f64,
        }
    }

    /// Bytes per second so far.
    pub fn rate(&self, now_ms: u64) -> f64 {
        self.share() * f64::from(self.entry.size) / (now_ms.saturating_sub(self.begun_ms).max(1) as f64 / 1000.0)
    }

    /// True if the vehicle has not answered for long.
    pub fn is_silent(&self, now_ms: u64) -> bool {
        now_ms >= self.heard_ms + GIVE_UP_MS
    }

    pub(super) fn is_whole(&self) -> bool {
        self.missing == 0
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// What is to be asked for now: from which byte, how many.
    pub(super) fn due(&mut self, now_ms: u64) -> Option<(u32, u32)> {
        if self.is_whole() {
            return None;
        }
        let is_answered = self.first_missing * PART >= self.asked_to;
        let last_ms = self.asked_ms.map(|asked_ms| asked_ms.max(self.heard_ms));
        if !is_answered && last_ms.is_some_and(|last_ms| now_ms < last_ms + AGAIN_MS) {
            return None;
        }
        let begin = self.first_missing;
        // a gap, up to what follows it
        let gap = self.has.get(begin..)?.iter().take_while(|has| !**has).count();
        let count = (gap * PART).min(ASKED_AT_ONCE).min(self.bytes.len() - begin * PART);
        self.asked_ms = Some(now_ms);
        self.asked_to = begin * PART + count;
        Some(((begin * PART) as u32, count as u32))
    }

    /// A part of it, or of another log, which is passed over; nothing that arrives is beyond the end.
    pub(super) fn take(&mut self, part: &LOG_DATA_DATA, now_ms: u64) {
        let (at, index) = (part.ofs as usize, part.ofs as usize / PART);
        let wanted = self.bytes.len().saturating_sub(at).min(PART);
        if part.id != self.entry.id || at % PART != 0 || usize::from(part.count) < wanted || wanted == 0 {
            return;
        }
        self.heard_ms = now_ms;
        let (Some(place), Some(has), Some(bytes)) =
            (self.bytes.get_mut(at..at + wanted), self.has.get_mut(index), part.data.get(..wanted))
        else {
            return;
        };
        place.copy_from_slice(bytes);
        if !std::mem::replace(has, true) {
            self.missing -= 1;
        }
        while self.has.get(self.first_missing).is_some_and(|has| *has) {
            self.first_missing += 1;
        }
    }
}
