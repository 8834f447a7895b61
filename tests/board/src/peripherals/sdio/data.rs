//! The data path: blocks between FIFO and line, each with its CRC, after a written one the CRC status and the card's
//! busy. Section 31.3.1, "Data path".
//!
//! The line moves eight words at a time. On the way out they must lie in the FIFO when the line has passed them, on the
//! way in there must be room for them.

use super::{
    BURST_WORDS, BlockStatus, DATAEND, DBCKEND, DCRCFAIL, DTIMEOUT, FIFO_WORDS, FROM_CARD, Outgoing, RXOVERR, Sdio,
    TXUNDERR,
};
use crate::time::Ticks;

/// Start bit, CRC and end bit of a block, the gap behind it and the five bits of the CRC status.
const END_BITS: u64 = 1 + 16 + 1 + 2 + 5;

/// State of the data path.
#[derive(Clone, Debug, Default)]
pub(super) enum Data {
    #[default]
    Idle,
    /// Wait_R: the card may begin until then.
    AwaitsCard { since: Ticks, time_out: Ticks },
    /// Words that the line has not brought yet; the next are there then. With whether the CRC will fit.
    Receives { words: std::vec::IntoIter<u32>, next: Ticks, intact: bool },
    /// All words are there, the block ends then.
    ReceiveEnds { at: Ticks, intact: bool },
    /// Wait_S: the FIFO is empty.
    AwaitsFifo,
    /// What the line has of the block; the next words are on it then.
    Sends { bytes: Vec<u8>, next: Ticks },
    /// The block and its CRC status are over then.
    SendEnds { bytes: Vec<u8>, at: Ticks },
    /// With whoever is at the other end.
    Heard { at: Ticks },
    /// Data line 0 is low until then, none is for ever; the wait ends with the time-out.
    Busy { until: Option<Ticks>, time_out: Ticks },
}

impl Data {
    pub(super) fn is_sending(&self) -> bool {
        matches!(
            self,
            Self::AwaitsFifo | Self::Sends { .. } | Self::SendEnds { .. } | Self::Heard { .. } | Self::Busy { .. }
        )
    }

    pub(super) fn is_receiving(&self) -> bool {
        matches!(self, Self::AwaitsCard { .. } | Self::Receives { .. } | Self::ReceiveEnds { .. })
    }
}

impl Sdio {
    pub(super) fn begin_data(&mut self, now: Ticks) {
        self.data = if self.control & FROM_CARD != 0 { self.await_card(now) } else { Data::AwaitsFifo };
    }

    fn await_card(&self, since: Ticks) -> Data {
        Data::AwaitsCard { since, time_out: since + self.time_out_ticks() }
    }

    fn time_out_ticks(&self) -> Ticks {
        u64::from(self.timer) * self.cycle()
    }

    fn burst_ticks(&self) -> Ticks {
        BURST_WORDS as u64 * 32 / self.width() as u64 * self.cycle()
    }

    /// A block begins on the line; `intact` unless its CRC can't fit.
    pub(crate) fn receive_block(&mut self, bytes: &[u8], at: Ticks, intact: bool) {
        let words: Vec<u32> = bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        self.data = Data::Receives { words: words.into_iter(), next: at + self.burst_ticks(), intact };
    }

    pub(super) fn block_sent(&mut self, now: Ticks) -> Option<Outgoing> {
        match &mut self.data {
            Data::SendEnds { bytes, at } if *at <= now => {
                let (bytes, at) = (std::mem::take(bytes), *at);
                self.data = Data::Heard { at };
                Some(Outgoing::Block { bytes, at })
            }
            _ => None,
        }
    }

    /// What came back to the block that went out.
    pub(crate) fn block_status(&mut self, status: BlockStatus) {
        let Data::Heard { at } = self.data else { return };
        self.data = match status {
            BlockStatus::None | BlockStatus::Refused => self.failed(DCRCFAIL),
            BlockStatus::Taken { busy_until } => {
                self.flags |= DBCKEND;
                Data::Busy { until: busy_until, time_out: at + self.time_out_ticks() }
            }
        };
    }

    /// Everything that is due by now, up to the next block that somebody has to take.
    pub(super) fn tick_data(&mut self, now: Ticks) {
        while self.data_event().is_some_and(|at| at <= now) {
            self.data = match std::mem::take(&mut self.data) {
                Data::SendEnds { bytes, at } => {
                    self.data = Data::SendEnds { bytes, at };
                    return;
                }
                Data::AwaitsCard { .. } => self.failed(DTIMEOUT),
                Data::Receives { words, next, intact } => self.receive_burst(words, next, intact),
                Data::ReceiveEnds { at, intact: true } => self.received(at),
                Data::ReceiveEnds { .. } => self.failed(DCRCFAIL),
                Data::Sends { bytes, next } => self.send_burst(bytes, next),
                Data::Busy { until: Some(until), time_out } if until <= time_out => self.sent(),
                Data::Busy { .. } => self.failed(DTIMEOUT),
                other @ (Data::Idle | Data::AwaitsFifo | Data::Heard { .. }) => other,
            };
        }
        if matches!(self.data, Data::AwaitsFifo) && !self.fifo.is_empty() {
            self.data = Data::Sends { bytes: Vec::new(), next: now + self.burst_ticks() };
        }
    }

    fn failed(&mut self, flag: u32) -> Data {
        self.flags |= flag;
        // what was to go out is lost, what came in can still be read
        if self.control & FROM_CARD == 0 {
            self.fifo.clear();
        }
        Data::Idle
    }

    fn receive_burst(&mut self, mut words: std::vec::IntoIter<u32>, next: Ticks, intact: bool) -> Data {
        let burst: Vec<u32> = words.by_ref().take(BURST_WORDS).collect();
        if self.fifo.len() + burst.len() > FIFO_WORDS {
            return self.failed(RXOVERR);
        }
        self.fifo.extend(burst);
        if words.len() > 0 {
            Data::Receives { words, next: next + self.burst_ticks(), intact }
        } else {
            Data::ReceiveEnds { at: next + 17 * self.cycle(), intact }
        }
    }

    fn received(&mut self, at: Ticks) -> Data {
        self.left -= self.block_bytes();
        self.flags |= DBCKEND;
        if self.left > 0 {
            return self.await_card(at);
        }
        self.flags |= DATAEND;
        Data::Idle
    }

    fn send_burst(&mut self, mut bytes: Vec<u8>, next: Ticks) -> Data {
        let block = self.block_bytes() as usize;
        let wanted = BURST_WORDS.min((block - bytes.len()) / 4);
        if self.fifo.len() < wanted {
            return self.failed(TXUNDERR);
        }
        bytes.extend(self.fifo.drain(..wanted).flat_map(u32::to_le_bytes));
        if bytes.len() < block {
            Data::Sends { bytes, next: next + self.burst_ticks() }
        } else {
            Data::SendEnds { bytes, at: next + END_BITS * self.cycle() }
        }
    }

    fn sent(&mut self) -> Data {
        self.left -= self.block_bytes();
        if self.left > 0 {
            return Data::AwaitsFifo;
        }
        self.flags |= DATAEND;
        Data::Idle
    }

    pub(super) fn data_event(&self) -> Option<Ticks> {
        match &self.data {
            Data::Idle | Data::AwaitsFifo | Data::Heard { .. } => None,
            Data::AwaitsCard { time_out, .. } => Some(*time_out),
            Data::Receives { next, .. } | Data::Sends { next, .. } => Some(*next),
            Data::ReceiveEnds { at, .. } | Data::SendEnds { at, .. } => Some(*at),
            Data::Busy { until, time_out } => Some(until.map_or(*time_out, |until| until.min(*time_out))),
        }
    }
}
