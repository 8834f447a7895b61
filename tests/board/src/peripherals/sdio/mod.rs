//! SDIO: the SD card's controller. RM0090 chapter 31 (registers: section 31.9).
//!
//! One command at a time (`command`), one run of data blocks at a time (`data`). Bits become times: what the card hears
//! it hears whole, at the end of the command or the block, and its answer takes the bits that it has. Without: streams,
//! SDIO cards, CE-ATA, hardware flow control and the inverted clock (ES0206: neither works), a wait for interrupts.

mod command;
mod data;

use std::collections::VecDeque;

use super::{Peripheral, Unmodelled};
use crate::devices::sd_card::{BlockStatus, Response};
use crate::time::Ticks;
use command::Command;
use data::Data;

// SDIO_CLKCR
const CLKEN: u32 = 1 << 8;
const BYPASS: u32 = 1 << 10;
const NEGEDGE_HWFC: u32 = 0b11 << 13;
// SDIO_CMD
const CPSMEN: u32 = 1 << 10;
const CMD_UNUSED: u32 = 0b11 << 8 | 0b1111 << 11;
// SDIO_DCTRL
const DTEN: u32 = 1;
const FROM_CARD: u32 = 1 << 1;
const DMAEN: u32 = 1 << 3;
const DCTRL_UNUSED: u32 = 1 << 2 | 0b1111 << 8;
// SDIO_STA
const CCRCFAIL: u32 = 1;
const DCRCFAIL: u32 = 1 << 1;
const CTIMEOUT: u32 = 1 << 2;
const DTIMEOUT: u32 = 1 << 3;
const TXUNDERR: u32 = 1 << 4;
const RXOVERR: u32 = 1 << 5;
const CMDREND: u32 = 1 << 6;
const CMDSENT: u32 = 1 << 7;
const DATAEND: u32 = 1 << 8;
const DBCKEND: u32 = 1 << 10;
const CMDACT: u32 = 1 << 11;
const TXACT: u32 = 1 << 12;
const RXACT: u32 = 1 << 13;
const TXFIFOHE: u32 = 1 << 14;
const RXFIFOHF: u32 = 1 << 15;
const TXFIFOF: u32 = 1 << 16;
const RXFIFOF: u32 = 1 << 17;
const TXFIFOE: u32 = 1 << 18;
const RXFIFOE: u32 = 1 << 19;
const TXDAVL: u32 = 1 << 20;
const RXDAVL: u32 = 1 << 21;
/// What SDIO_ICR clears.
const STATIC_FLAGS: u32 = 0x7ff;

/// Words in the FIFO, and how many the DMA moves in a burst and the line in a step of this model.
const FIFO_WORDS: usize = 32;
const BURST_WORDS: usize = 8;

/// How wide the bus is, bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    One = 1,
    Four = 4,
}

/// What the controller hands to whoever is at the other end of the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Outgoing {
    /// A command, whole at this time.
    Command { index: u8, argument: u32, at: Ticks },
    /// A block, whole at this time.
    Block { bytes: Vec<u8>, at: Ticks },
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Sdio {
    power: u32,
    clock: u32,
    argument: u32,
    command_register: u32,
    response_index: u32,
    responses: [u32; 4],
    timer: u32,
    length: u32,
    control: u32,
    mask: u32,
    /// Static flags.
    flags: u32,
    fifo: VecDeque<u32>,
    command: Option<Command>,
    data: Data,
    /// Bytes left of the run.
    left: u32,
    /// Words that DMA or core still have to bring or fetch.
    words_left: u32,
    last_word: bool,
    /// Period of the 48 MHz that it is clocked by; none where nothing gives it.
    source_cycle: Option<Ticks>,
}

impl Sdio {
    pub(crate) fn set_source_cycle(&mut self, cycle: Option<Ticks>) {
        self.source_cycle = cycle;
    }

    /// A period of the card's clock.
    pub(crate) fn cycle(&self) -> Ticks {
        let divider = if self.clock & BYPASS != 0 { 1 } else { u64::from(self.clock & 0xff) + 2 };
        self.source_cycle.unwrap_or(1) * divider
    }

    pub(crate) fn width(&self) -> Width {
        if self.clock >> 11 & 3 == 1 { Width::Four } else { Width::One }
    }

    /// Of a block, by the data control register.
    pub(crate) fn block_bytes(&self) -> u32 {
        1 << (self.control >> 4 & 0xf)
    }

    /// What is whole by now and goes out; to be answered before the next.
    pub(crate) fn outgoing(&mut self, now: Ticks) -> Option<Outgoing> {
        self.command_sent(now).or_else(|| self.block_sent(now))
    }

    /// Does it wait for a block, and since when?
    pub(crate) fn awaits_block(&self) -> Option<Ticks> {
        match self.data {
            Data::AwaitsCard { since, .. } => Some(since),
            _ => None,
        }
    }

    /// How long a block of so many bytes is on the line, with its start, CRC and end.
    pub(crate) fn block_ticks(&self, bytes: usize) -> Ticks {
        (bytes as u64 * 8 / self.width() as u64 + 18) * self.cycle()
    }

    pub(crate) fn interrupt(&self) -> bool {
        self.status() & self.mask != 0
    }

    pub(crate) fn requests_receive_dma(&self) -> bool {
        let rest = self.words_left as usize;
        self.control & (DMAEN | FROM_CARD) == DMAEN | FROM_CARD
            && self.words_left > 0
            && self.fifo.len() >= BURST_WORDS.min(rest)
    }

    pub(crate) fn requests_transmit_dma(&self) -> bool {
        let sends = self.data.is_sending() && self.control & DMAEN != 0;
        sends && self.words_left > 0 && self.fifo.len() < FIFO_WORDS
    }

    /// Has the run's last word passed between FIFO and memory? As flow controller it ends the stream then, once.
    pub(crate) fn take_last_word(&mut self) -> bool {
        std::mem::take(&mut self.last_word)
    }

    fn word_passed(&mut self) {
        self.words_left = self.words_left.saturating_sub(1);
        self.last_word |= self.words_left == 0;
    }

    fn status(&self) -> u32 {
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let (held, sends) = (self.fifo.len(), self.data.is_sending());
        let of_fifo = if sends {
            flag(held + BURST_WORDS <= FIFO_WORDS, TXFIFOHE)
                | flag(held == FIFO_WORDS, TXFIFOF)
                | flag(held == 0, TXFIFOE)
                | flag(held > 0, TXDAVL)
                | TXACT
        } else {
            flag(held >= BURST_WORDS, RXFIFOHF)
                | flag(held == FIFO_WORDS, RXFIFOF)
                | flag(held == 0, RXFIFOE)
                | flag(held > 0, RXDAVL)
                | flag(self.data.is_receiving(), RXACT)
        };
        self.flags | of_fifo | flag(self.command.is_some(), CMDACT)
    }

    fn is_clocked(&self) -> Result<(), Unmodelled> {
        match self.source_cycle {
            None => Err(Unmodelled("SDIO without its 48 MHz")),
            _ if self.power & 3 != 3 => Err(Unmodelled("SDIO used while it is off")),
            _ if self.clock & CLKEN == 0 => Err(Unmodelled("SDIO used without a clock to the card")),
            Some(_) => Ok(()),
        }
    }

    fn read_fifo(&mut self) -> Result<u32, Unmodelled> {
        let word = self.fifo.pop_front().ok_or(Unmodelled("SDIO FIFO read while it is empty"))?;
        self.word_passed();
        Ok(word)
    }

    fn write_fifo(&mut self, word: u32) -> Result<(), Unmodelled> {
        if !self.data.is_sending() || self.fifo.len() == FIFO_WORDS || self.words_left == 0 {
            return Err(Unmodelled("SDIO FIFO written while there is no room or no data wanted"));
        }
        self.fifo.push_back(word);
        self.word_passed();
        Ok(())
    }

    fn write_control(&mut self, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        if value & DCTRL_UNUSED != 0 {
            return Err(Unmodelled("SDIO data as a stream or of an SDIO card"));
        }
        self.control = value;
        self.fifo.clear();
        self.data = Data::Idle;
        (self.words_left, self.last_word) = (0, false);
        if value & DTEN == 0 {
            return Ok(());
        }
        self.is_clocked()?;
        if self.length == 0 || !self.length.is_multiple_of(self.block_bytes()) || self.block_bytes() < 4 {
            return Err(Unmodelled("SDIO data that are no whole number of blocks"));
        }
        (self.left, self.words_left) = (self.length, self.length / 4);
        self.begin_data(now);
        Ok(())
    }
}

impl Peripheral for Sdio {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        Ok(match offset {
            0x00 => self.power,
            0x04 => self.clock,
            0x08 => self.argument,
            0x0c => self.command_register,
            0x10 => self.response_index,
            0x14..=0x20 => self.responses[(offset / 4 - 5) as usize],
            0x24 => self.timer,
            0x28 => self.length,
            0x2c => self.control,
            0x30 => self.left,
            0x34 => self.status(),
            0x38 => 0,
            0x3c => self.mask,
            0x48 => self.words_left,
            0x80..0x100 => self.read_fifo()?,
            _ => return Err(Unmodelled("SDIO register")),
        })
    }

    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x00 => self.power = value & 3,
            0x04 if value & NEGEDGE_HWFC != 0 || value >> 11 & 3 > 1 => {
                return Err(Unmodelled("SDIO flow control, inverted clock or eight lines"));
            }
            0x04 => self.clock = value & 0x7fff,
            0x08 => self.argument = value,
            0x0c if value & CMD_UNUSED != 0 => return Err(Unmodelled("SDIO command that waits, or of CE-ATA")),
            0x0c => {
                self.command_register = value & 0x7fff;
                if value & CPSMEN != 0 {
                    self.begin_command(now)?;
                }
            }
            0x24 => self.timer = value,
            0x28 => self.length = value & 0x01ff_ffff,
            0x2c => self.write_control(value, now)?,
            0x38 => self.flags &= !(value & STATIC_FLAGS),
            0x3c => self.mask = value,
            0x80..0x100 => self.write_fifo(value)?,
            _ => return Err(Unmodelled("SDIO register that cannot be written")),
        }
        Ok(())
    }

    fn tick(&mut self, now: Ticks) {
        self.tick_command(now);
        self.tick_data(now);
    }

    fn next_event(&self) -> Option<Ticks> {
        self.command_event().into_iter().chain(self.data_event()).min()
    }
}
