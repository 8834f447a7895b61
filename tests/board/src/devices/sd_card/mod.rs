//! A microSD card of high capacity in SD mode. SD Physical Layer Simplified Specification 6.00, chapter 4.
//!
//! It hears whole commands and blocks, and says when what comes back begins. The lines are the controller's affair.

mod content;
mod identity;
mod pauses;

pub use content::{Content, SECTOR_BYTES, Sector};
pub use pauses::Pauses;

use identity::{CID, HIGH_CAPACITY, POWERED_UP, SCR, VOLTAGES, csd};
use pauses::Clockwork;

use crate::time::{TICKS_PER_S, TICKS_PER_US, Ticks};

/// Initialisation takes so long from the first ACMD41 that starts it; a second is allowed (section 4.2.3).
const INITIALISATION: Ticks = 50 * 1000 * TICKS_PER_US;
/// The clock while cards are identified, Hz (section 4.2.1).
const IDENTIFICATION_HZ: u64 = 400_000;
/// And at default speed.
const DEFAULT_SPEED_HZ: u64 = 25_000_000;

/// A card is clocked faster than it may be.
pub const CLOCK_TOO_FAST: &str = "SD card clocked above 400 kHz before it is identified, or above 25 MHz";
/// A block came for which the card did not wait.
pub const BLOCK_UNAWAITED: &str = "block sent to an SD card that is not ready to receive one";

// card status (section 4.10.1)
const OUT_OF_RANGE: u32 = 1 << 31;
const BLOCK_LEN_ERROR: u32 = 1 << 29;
const ILLEGAL_COMMAND: u32 = 1 << 22;
const ERROR: u32 = 1 << 19;
const READY_FOR_DATA: u32 = 1 << 8;
const APP_CMD: u32 = 1 << 5;

/// What can be wrong with a card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardFault {
    /// It takes a block, says that it is busy, and never ends.
    BusyForEver,
    /// Blocks are received and not kept, which the card's status says afterwards.
    WriteError,
    /// Blocks are refused by a negative CRC status.
    BlocksRefused,
}

/// The states (section 4.1), with their numbers in the card's status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Idle = 0,
    Ready = 1,
    Identification = 2,
    StandBy = 3,
    Transfer = 4,
    SendingData = 5,
    ReceivingData = 6,
    Programming = 7,
}

/// What a card answers to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Response {
    /// Nothing.
    None,
    /// R1, R6 and R7: the command's index, 32 bits, a CRC.
    Short(u32),
    /// R3: no index and no CRC.
    Conditions(u32),
    /// R2: 127 bits, no index.
    Long([u32; 4]),
}

/// What a card answers to a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockStatus {
    /// Nobody answers.
    None,
    /// CRC status 101, so that the host has to take the block for lost.
    Refused,
    /// CRC status 010, and data line 0 is low until then; none if for ever.
    Taken { busy_until: Option<Ticks> },
}

/// What it sends or receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Transfer {
    Sectors { next: u32, many: bool },
    Configuration,
}

/// A card in its slot.
#[derive(Clone, Debug)]
pub struct SdCard {
    content: Content,
    clockwork: Clockwork,
    fault: Option<CardFault>,
    /// Out of the slot: it hears and says nothing.
    removed: bool,
    state: State,
    /// Errors that the next status says.
    errors: u32,
    application: bool,
    address: u16,
    initialised_at: Option<Ticks>,
    wide: bool,
    transfer: Option<Transfer>,
    /// The next block of what it sends begins then.
    sends_at: Ticks,
    /// It programs until then; none while it does so for ever.
    busy_until: Option<Ticks>,
}

impl SdCard {
    /// A card with this content. It has 1024 sectors at least, a multiple of that.
    pub fn new(content: Content, pauses: Pauses, seed: u64) -> Self {
        let clockwork = Clockwork::new(pauses, seed);
        Self {
            content,
            clockwork,
            fault: None,
            removed: false,
            state: State::Idle,
            errors: 0,
            application: false,
            address: 0,
            initialised_at: None,
            wide: false,
            transfer: None,
            sends_at: 0,
            busy_until: Some(0),
        }
    }

    /// What it holds.
    pub fn content(&self) -> &Content {
        &self.content
    }

    /// What it holds, to be changed behind its back.
    pub fn content_mut(&mut self) -> &mut Content {
        &mut self.content
    }

    /// It takes its time otherwise from now on.
    pub fn set_pauses(&mut self, pauses: Pauses) {
        self.clockwork.pauses = pauses;
    }

    /// It fails from now on, or no longer.
    pub fn set_fault(&mut self, fault: Option<CardFault>) {
        self.fault = fault;
    }

    /// Somebody takes it out of the slot.
    pub fn remove(&mut self) {
        self.removed = true;
    }

    /// As after power-on.
    pub(crate) fn power_up(&mut self) {
        self.reset();
        self.initialised_at = None;
    }

    fn reset(&mut self) {
        (self.state, self.errors, self.application, self.address) = (State::Idle, 0, false, 0);
        (self.wide, self.transfer, self.busy_until) = (false, None, Some(0));
        self.initialised_at = None;
    }

    /// May it be clocked like that? For every command and block.
    pub(crate) fn check_clock(&self, cycle: Ticks) -> Result<(), &'static str> {
        let identified = !matches!(self.state, State::Idle | State::Ready | State::Identification);
        let limit_hz = if identified { DEFAULT_SPEED_HZ } else { IDENTIFICATION_HZ };
        if self.removed || cycle * limit_hz >= TICKS_PER_S { Ok(()) } else { Err(CLOCK_TOO_FAST) }
    }

    /// Does it use four data lines?
    pub(crate) fn is_wide(&self) -> bool {
        self.wide
    }

    /// Does nobody answer?
    pub(crate) fn is_removed(&self) -> bool {
        self.removed
    }

    fn settle(&mut self, now: Ticks) {
        if self.state == State::Programming && self.busy_until.is_some_and(|end| end <= now) {
            self.state = State::Transfer;
        }
    }

    /// Its status, and the errors that it has said are forgotten.
    fn status(&mut self) -> u32 {
        let ready =
            if matches!(self.state, State::Transfer | State::StandBy | State::Idle) { READY_FOR_DATA } else { 0 };
        let application = if self.application { APP_CMD } else { 0 };
        std::mem::take(&mut self.errors) | (self.state as u32) << 9 | ready | application
    }

    /// A command has arrived whole.
    pub(crate) fn command(&mut self, index: u8, argument: u32, now: Ticks) -> Response {
        if self.removed {
            return Response::None;
        }
        self.settle(now);
        let application = std::mem::take(&mut self.application);
        let answer =
            if application { self.application_command(index, argument, now) } else { self.plain(index, argument, now) };
        answer.unwrap_or_else(|| {
            self.errors |= ILLEGAL_COMMAND;
            Response::None
        })
    }

    /// None if the command is illegal in this state.
    fn plain(&mut self, index: u8, argument: u32, now: Ticks) -> Option<Response> {
        let to_me = (argument >> 16) as u16 == self.address;
        match (index, self.state) {
            (0, _) => {
                self.reset();
                Some(Response::None)
            }
            // 2.7 to 3.6 V; for another voltage nobody answers
            (8, State::Idle) if argument >> 8 & 0xf == 1 => Some(Response::Short(argument & 0xfff)),
            (8, State::Idle) => Some(Response::None),
            (2, State::Ready) => {
                self.state = State::Identification;
                Some(Response::Long(CID))
            }
            (3, State::Identification | State::StandBy) => {
                self.address = self.address.wrapping_add(0x1234);
                let status = self.status();
                self.state = State::StandBy;
                // R6 (section 4.9.5): bits 23, 22 and 19 of the status, and its lowest 13
                let short = status >> 8 & 0xc000 | status >> 6 & 0x2000 | status & 0x1fff;
                Some(Response::Short(u32::from(self.address) << 16 | short))
            }
            (7, State::StandBy) if to_me => {
                let status = self.status();
                self.state = State::Transfer;
                Some(Response::Short(status))
            }
            (7, State::Transfer | State::SendingData) if !to_me => {
                self.state = State::StandBy;
                Some(Response::None)
            }
            (9, State::StandBy) if to_me => Some(Response::Long(csd(self.content.sectors()))),
            (10, State::StandBy) if to_me => Some(Response::Long(CID)),
            (13, State::Idle | State::Ready | State::Identification) => None,
            (13, _) if to_me => Some(Response::Short(self.status())),
            (55, State::Ready | State::Identification) => None,
            (55, _) if to_me => {
                self.application = true;
                Some(Response::Short(self.status()))
            }
            // for another card
            (7 | 9 | 10 | 13 | 55, _) if !to_me => Some(Response::None),
            (12, State::SendingData) => {
                let status = self.status();
                (self.state, self.transfer) = (State::Transfer, None);
                Some(Response::Short(status))
            }
            (12, State::ReceivingData) => {
                let status = self.status();
                self.end_write(now);
                Some(Response::Short(status))
            }
            (16, State::Transfer) => {
                if argument != SECTOR_BYTES as u32 {
                    self.errors |= BLOCK_LEN_ERROR;
                }
                Some(Response::Short(self.status()))
            }
            (17 | 18, State::Transfer) => Some(self.begin(argument, index == 18, State::SendingData, now)),
            (24 | 25, State::Transfer) => Some(self.begin(argument, index == 25, State::ReceivingData, now)),
            _ => None,
        }
    }

    fn begin(&mut self, sector: u32, many: bool, state: State, now: Ticks) -> Response {
        if sector >= self.content.sectors() {
            self.errors |= OUT_OF_RANGE;
            return Response::Short(self.status());
        }
        let status = self.status();
        (self.state, self.transfer) = (state, Some(Transfer::Sectors { next: sector, many }));
        self.sends_at = now + self.clockwork.pauses.access;
        Response::Short(status)
    }

    fn application_command(&mut self, index: u8, argument: u32, now: Ticks) -> Option<Response> {
        match (index, self.state) {
            (41, State::Idle) => Some(self.operating_conditions(argument, now)),
            (6, State::Transfer) => {
                self.wide = argument & 3 == 2;
                Some(Response::Short(self.status()))
            }
            // so many sectors will be written: a card may erase them beforehand
            (23, State::Transfer) => Some(Response::Short(self.status())),
            (51, State::Transfer) => {
                let status = self.status();
                (self.state, self.transfer) = (State::SendingData, Some(Transfer::Configuration));
                self.sends_at = now + self.clockwork.pauses.access;
                Some(Response::Short(status))
            }
            // what is no application command is a plain one (section 4.3.9.1)
            (6 | 23 | 41 | 51, _) => None,
            _ => self.plain(index, argument, now),
        }
    }

    fn operating_conditions(&mut self, argument: u32, now: Ticks) -> Response {
        // without a voltage it is an inquiry
        if argument & VOLTAGES == 0 {
            return Response::Conditions(VOLTAGES);
        }
        let started = *self.initialised_at.get_or_insert(now + INITIALISATION);
        // a card of high capacity stays busy for a host that does not know those
        if now < started || argument & HIGH_CAPACITY == 0 {
            return Response::Conditions(VOLTAGES);
        }
        self.state = State::Ready;
        Response::Conditions(POWERED_UP | HIGH_CAPACITY | VOLTAGES)
    }

    /// When the next block of what it sends begins, and how long that is, bytes.
    pub(crate) fn sends(&self) -> Option<(Ticks, usize)> {
        let length = match self.transfer? {
            Transfer::Configuration => SCR.len(),
            Transfer::Sectors { .. } => SECTOR_BYTES,
        };
        (self.state == State::SendingData && !self.removed).then_some((self.sends_at, length))
    }

    /// That block; it ends then.
    pub(crate) fn send_block(&mut self, end: Ticks) -> Vec<u8> {
        let transfer = self.transfer.take();
        self.sends_at = end + self.clockwork.pauses.access;
        match transfer {
            Some(Transfer::Sectors { next, many }) => {
                if many && next + 1 < self.content.sectors() {
                    self.transfer = Some(Transfer::Sectors { next: next + 1, many });
                } else if many {
                    self.errors |= OUT_OF_RANGE;
                } else {
                    self.state = State::Transfer;
                }
                self.content.read(next).to_vec()
            }
            Some(Transfer::Configuration) => {
                self.state = State::Transfer;
                SCR.to_vec()
            }
            None => Vec::new(),
        }
    }

    /// A block has arrived whole, with its CRC.
    ///
    /// # Errors
    /// If the card waits for none.
    pub(crate) fn receive_block(&mut self, block: &[u8], now: Ticks) -> Result<BlockStatus, &'static str> {
        if self.removed {
            return Ok(BlockStatus::None);
        }
        let (Some(Transfer::Sectors { next, many }), State::ReceivingData) = (self.transfer, self.state) else {
            return Err(BLOCK_UNAWAITED);
        };
        let block: &Sector = block.try_into().map_err(|_| BLOCK_UNAWAITED)?;
        match self.fault {
            Some(CardFault::BlocksRefused) => return Ok(BlockStatus::Refused),
            Some(CardFault::WriteError) => self.errors |= ERROR,
            Some(CardFault::BusyForEver) => {}
            None if next < self.content.sectors() => self.content.write(next, block),
            None => self.errors |= OUT_OF_RANGE,
        }
        self.transfer = Some(Transfer::Sectors { next: next.saturating_add(1), many });
        if self.fault == Some(CardFault::BusyForEver) {
            (self.state, self.transfer, self.busy_until) = (State::Programming, None, None);
        } else if many {
            self.busy_until = Some(now + self.clockwork.pauses.between_blocks);
        } else {
            self.end_write(now);
        }
        Ok(BlockStatus::Taken { busy_until: self.busy_until })
    }

    fn end_write(&mut self, now: Ticks) {
        (self.state, self.transfer) = (State::Programming, None);
        if self.busy_until.is_some() {
            self.busy_until = Some(now + self.clockwork.after_write());
        }
    }
}

#[cfg(test)]
mod tests;
