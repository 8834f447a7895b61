//! The microSD card: woken, identified, its sectors read and written (SD Physical Layer Simplified Specification 6.00).
//!
//! Cards of high and extended capacity, which are all of 4 GB and more.

use shared_control::log_card::{CardError, SECTOR_BYTES, Sector, Sectors};

use super::clock;
use super::sd_bus::{Answer, SdBus, wait_for};

/// The supply has risen and 74 clocks have gone by (section 6.4.1).
const WAKE_US: u32 = 2_000;
/// A card may take a second to get ready (section 4.2.3).
const READY_US: u32 = 1_200_000;
/// Between two looks at a card that is not ready.
const LOOK_US: u32 = 5_000;
/// Of a write, beyond what an SDXC card may take (section 4.6.2.2).
const WRITE_US: u32 = 700_000;

/// 2.7 to 3.6 V, and the pattern that comes back (section 4.3.13).
const CONDITIONS: u32 = 0x1aa;
/// High capacity is known here, and the voltage (section 4.2.3.1).
const HOST: u32 = 1 << 30 | 0x00ff_8000;
const IS_READY: u32 = 1 << 31;
const HIGH_CAPACITY: u32 = 1 << 30;
/// All errors of the card's status (section 4.10.1).
const ERRORS: u32 = 0xfdf9_8008;
const STATE: u32 = 0xf << 9;
/// Ready to be read or written.
const TRANSFER: u32 = 4 << 9;

/// A card, once one is there.
pub struct SdCard {
    bus: SdBus,
    /// Its address in the upper half; none while no card is identified.
    address: Option<u32>,
}

impl SdCard {
    /// Nothing is known of it.
    pub fn new(bus: SdBus) -> Self {
        Self { bus, address: None }
    }

    /// Wakes it, whatever it was at.
    ///
    /// # Errors
    /// [`CardError::Absent`] where none answers.
    pub fn identify(&mut self) -> Result<(), CardError> {
        self.address = None;
        self.bus.start_slowly();
        pause(WAKE_US);
        self.bus.command(0, 0, Answer::None)?;
        // cards that don't know it are older, and of 2 GB at most
        if self.bus.command(8, CONDITIONS, Answer::Short)? & 0xfff != CONDITIONS {
            return Err(CardError::Failed);
        }
        self.await_ready()?;
        self.bus.command(2, 0, Answer::Long)?;
        let address = self.bus.command(3, 0, Answer::Short)? & 0xffff_0000;
        self.bus.command(7, address, Answer::Short)?;
        self.address = Some(address);
        self.application(6, 2)?;
        self.bus.speed_up();
        self.await_transfer()
    }

    fn await_ready(&mut self) -> Result<(), CardError> {
        let begin_us = clock::now_us();
        while clock::now_us().wrapping_sub(begin_us) < READY_US {
            self.bus.command(55, 0, Answer::Short)?;
            let conditions = self.bus.command(41, HOST, Answer::Unchecked)?;
            if conditions & IS_READY != 0 {
                return if conditions & HIGH_CAPACITY != 0 { Ok(()) } else { Err(CardError::Failed) };
            }
            pause(LOOK_US);
        }
        Err(CardError::Failed)
    }

    fn application(&mut self, index: u8, argument: u32) -> Result<(), CardError> {
        self.addressed(55)?;
        let status = self.bus.command(index, argument, Answer::Short)?;
        if status & ERRORS == 0 { Ok(()) } else { Err(CardError::Failed) }
    }

    /// A command to this card; its status.
    fn addressed(&mut self, index: u8) -> Result<u32, CardError> {
        let address = self.address.ok_or(CardError::Absent)?;
        self.bus.command(index, address, Answer::Short)
    }

    /// Until it has done all that it was to do; what went wrong with it comes to light here.
    fn await_transfer(&mut self) -> Result<(), CardError> {
        let begin_us = clock::now_us();
        loop {
            let is_over = clock::now_us().wrapping_sub(begin_us) >= WRITE_US;
            let status = self.addressed(13)?;
            match status & (ERRORS | STATE) {
                TRANSFER => return Ok(()),
                status if status & ERRORS != 0 || is_over => return Err(CardError::Failed),
                _ => super::load::sleep(),
            }
        }
    }

    fn checked(&mut self, index: u8, argument: u32) -> Result<(), CardError> {
        if self.address.is_none() {
            return Err(CardError::Absent);
        }
        let status = self.bus.command(index, argument, Answer::Short)?;
        if status & ERRORS == 0 { Ok(()) } else { Err(CardError::Failed) }
    }

    fn write_some(&mut self, number: u32, bytes: &[u8]) -> Result<(), CardError> {
        let many = bytes.len() > SECTOR_BYTES;
        self.checked(if many { 25 } else { 24 }, number)?;
        let sent = self.bus.send(bytes);
        if many {
            // also where it failed: the card waits for the next block
            let stopped = self.bus.command(12, 0, Answer::Short);
            sent.and(stopped.map(drop))?;
        } else {
            sent?;
        }
        self.await_transfer()
    }

    /// From a card that is taken out in flight nothing comes any more; the next start may find another.
    fn lost(error: CardError) -> CardError {
        if error == CardError::Absent { CardError::Failed } else { error }
    }
}

impl Sectors for SdCard {
    fn read(&mut self, number: u32, sector: &mut Sector) -> Result<(), CardError> {
        self.bus.expect_sector();
        let asked = self.checked(17, number);
        if asked.is_err() {
            self.bus.stop_data();
        }
        asked.and_then(|()| self.bus.take_sector(sector)).map_err(Self::lost)
    }

    fn write(&mut self, number: u32, bytes: &[u8]) -> Result<(), CardError> {
        let mut next = number;
        for some in bytes.chunks(SdBus::MOST_BYTES) {
            self.write_some(next, some).map_err(Self::lost)?;
            next = next.wrapping_add((some.len() / SECTOR_BYTES) as u32);
        }
        Ok(())
    }
}

fn pause(duration_us: u32) {
    // nothing is looked for
    let _ = wait_for(duration_us, || None::<()>);
}
