//! The receive FIFO: a word of status and the data of each packet. RM0090 sections 34.11.1 and 34.16.2.

use std::collections::VecDeque;

use crate::peripherals::Unmodelled;

/// What an entry says, bits 17 to 20 of its status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    OutData = 2,
    OutComplete = 3,
    SetupComplete = 4,
    SetupData = 6,
}

#[derive(Clone, Debug)]
struct Entry {
    status: Status,
    endpoint: usize,
    bytes: usize,
    toggle: bool,
    words: VecDeque<u32>,
}

/// All that was received and not yet read.
#[derive(Clone, Debug, Default)]
pub(super) struct ReceiveFifo {
    entries: VecDeque<Entry>,
    /// Words of the entry that was popped last.
    reading: VecDeque<u32>,
}

impl ReceiveFifo {
    /// Is there room for the status and this many bytes, in a FIFO of so many words?
    pub(super) fn has_room(&self, bytes: usize, depth: u32) -> bool {
        let used: usize = self.entries.iter().map(|entry| 1 + entry.words.len()).sum();
        used + self.reading.len() + 1 + bytes.div_ceil(4) <= depth as usize
    }

    pub(super) fn push(&mut self, status: Status, endpoint: usize, bytes: &[u8], toggle: bool) {
        let word = |chunk: &[u8]| chunk.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
        let words = bytes.chunks(4).map(word).collect();
        self.entries.push_back(Entry { status, endpoint, bytes: bytes.len(), toggle, words });
    }

    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// GRXSTSR: the next entry's status.
    pub(super) fn peek(&self) -> u32 {
        self.entries.front().map_or(0, Entry::word)
    }

    /// GRXSTSP: the same, and takes it out.
    pub(super) fn pop(&mut self) -> Result<(u32, Status, usize), Unmodelled> {
        if !self.reading.is_empty() {
            return Err(Unmodelled("the next status popped before all data of the packet were read"));
        }
        let entry = self.entries.pop_front().ok_or(Unmodelled("status popped while the receive FIFO is empty"))?;
        let popped = (entry.word(), entry.status, entry.endpoint);
        self.reading = entry.words;
        Ok(popped)
    }

    /// A word of data.
    pub(super) fn read(&mut self) -> Result<u32, Unmodelled> {
        self.reading.pop_front().ok_or(Unmodelled("more read from the receive FIFO than the packet holds"))
    }
}

impl Entry {
    fn word(&self) -> u32 {
        self.endpoint as u32 | (self.bytes as u32) << 4 | u32::from(self.toggle) << 16 | (self.status as u32) << 17
    }
}
