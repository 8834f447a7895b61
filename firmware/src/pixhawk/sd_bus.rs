//! SDIO: commands and blocks to and from the SD card (RM 31). Blocks go by DMA2 stream 3, channel 4.
//!
//! Used by the idle loop alone, which everything else interrupts: so no byte is moved by the core, whose pauses would
//! starve the FIFO, and every wait sleeps and has an end. Hardware flow control would make up for that, but does not
//! work (ES0206).
#![allow(unsafe_code)] // addresses and buffer of the DMA, registers by their bits

use core::sync::atomic::{Ordering, fence};

use shared_control::log_card::{CardError, SECTOR_BYTES};
use stm32f4xx_hal::gpio::{Alternate, PC8, PC9, PC10, PC11, PC12, PD2};
use stm32f4xx_hal::pac::{DMA2, SDIO, dma2};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::{clock, load};

/// Sectors that are written at once.
const BUFFER_SECTORS: usize = 8;

/// Data lines 0 to 3, clock, command.
pub type Pins = (
    PC8<Alternate<12>>,
    PC9<Alternate<12>>,
    PC10<Alternate<12>>,
    PC11<Alternate<12>>,
    PC12<Alternate<12>>,
    PD2<Alternate<12>>,
);

/// What the DMA moves, in bursts of 16 bytes. It must not lie on the stack, which is out of the DMA's reach.
#[repr(align(16))]
pub struct Buffer([u8; BUFFER_SECTORS * SECTOR_BYTES]);

impl Buffer {
    /// Nothing in it.
    pub const NEW: Self = Self([0; _]);
}

const STREAM: usize = 3;
const CHANNEL: u8 = 4;

// SDIO_CLKCR: 48 MHz over so much and 2 more
const IDENTIFICATION_DIVIDER: u32 = 118;
/// 16 MHz, as PX4 uses on this board; 25 would be allowed.
const TRANSFER_DIVIDER: u32 = 1;
const CLOCK_ON: u32 = 1 << 8;
const FOUR_LINES: u32 = 1 << 11;
/// Of a wait of the data path, clocks: the 500 ms that an SDXC card's write may take.
const DATA_WAIT_CLOCKS: u32 = 16_000_000 / 2;

// SDIO_CMD
const STATE_MACHINE_ON: u32 = 1 << 10;
// SDIO_DCTRL: blocks of 512 bytes by DMA
const TO_CARD: u32 = 1 | 1 << 3 | 9 << 4;
const FROM_CARD: u32 = TO_CARD | 1 << 1;
// SDIO_STA
const RESPONSE_DAMAGED: u32 = 1;
const NO_RESPONSE: u32 = 1 << 2;
const RESPONDED: u32 = 1 << 6;
const SENT: u32 = 1 << 7;
/// CRC, time-out, FIFO too slow, start bit missing.
const DATA_FAILED: u32 = 1 << 1 | 1 << 3 | 1 << 4 | 1 << 5 | 1 << 9;
const DATA_ENDED: u32 = 1 << 8;
const ALL_FLAGS: u32 = 0x7ff;

/// A command is over after 48 + 64 clocks of 400 kHz at the latest.
const COMMAND_WAIT_US: u32 = 2_000;
/// Looks at the flags before a wait begins to sleep: a command at 16 MHz takes some 7 us.
const LOOKS: u32 = 150;
/// Blocks with their pauses: the data path's own wait, for each block, ends before.
const DATA_WAIT_US: u32 = 700_000;

/// What a command is answered with.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// Nothing.
    None,
    /// Six bytes with a CRC.
    Short,
    /// Six bytes without one, which the controller takes for damaged.
    Unchecked,
    /// Seventeen bytes.
    Long,
}

/// The controller.
pub struct SdBus {
    sdio: SDIO,
    buffer: &'static mut Buffer,
    _pins: Pins,
}

impl SdBus {
    /// Off. DMA2 must be running already; its stream 3 is used here alone.
    pub fn new(sdio: SDIO, pins: Pins, buffer: &'static mut Buffer, rcc: &mut Rcc) -> Self {
        SDIO::enable(rcc);
        SDIO::reset(rcc);
        // SAFETY: the FIFO's address
        unsafe { stream().par().write(|w| w.pa().bits(sdio.fifo().as_ptr() as u32)) };
        Self { sdio, buffer, _pins: pins }
    }

    /// One data line at 400 kHz, for a card that is not known yet.
    pub fn start_slowly(&mut self) {
        self.stop_data();
        // SAFETY: bits of registers, here and below
        unsafe {
            self.sdio.power().write(|w| w.bits(3));
            self.sdio.clkcr().write(|w| w.bits(IDENTIFICATION_DIVIDER | CLOCK_ON));
            self.sdio.dtimer().write(|w| w.bits(DATA_WAIT_CLOCKS));
        }
    }

    /// Four at 16 MHz.
    pub fn speed_up(&mut self) {
        // SAFETY: bits of a register
        unsafe { self.sdio.clkcr().write(|w| w.bits(TRANSFER_DIVIDER | CLOCK_ON | FOUR_LINES)) };
    }

    /// Sends a command; the first word of what comes back.
    pub fn command(&mut self, index: u8, argument: u32, answer: Answer) -> Result<u32, CardError> {
        let awaited = match answer {
            Answer::None => 0,
            Answer::Short | Answer::Unchecked => 1 << 6,
            Answer::Long => 3 << 6,
        };
        // SAFETY: bits of registers
        unsafe {
            self.sdio.icr().write(|w| w.bits(ALL_FLAGS));
            self.sdio.arg().write(|w| w.bits(argument));
            self.sdio.cmd().write(|w| w.bits(u32::from(index & 0x3f) | awaited | STATE_MACHINE_ON));
        }
        let over = RESPONSE_DAMAGED | NO_RESPONSE | RESPONDED | SENT;
        let flags = wait_for(COMMAND_WAIT_US, || Some(self.flags()).filter(|flags| flags & over != 0))?;
        let expected = match answer {
            Answer::None => SENT,
            Answer::Unchecked => RESPONSE_DAMAGED | RESPONDED,
            Answer::Short | Answer::Long => RESPONDED,
        };
        if flags & NO_RESPONSE != 0 {
            Err(CardError::Absent)
        } else if flags & expected != 0 {
            Ok(self.sdio.resp1().read().bits())
        } else {
            Err(CardError::Failed)
        }
    }

    /// Makes ready for a sector, which the next command will have the card send.
    pub fn expect_sector(&mut self) {
        self.start_stream(false, SECTOR_BYTES);
        self.start_data(FROM_CARD, SECTOR_BYTES);
    }

    /// Waits for it.
    pub fn take_sector(&mut self, sector: &mut [u8; SECTOR_BYTES]) -> Result<(), CardError> {
        self.await_data()?;
        // the DMA's last burst
        wait_for(COMMAND_WAIT_US, || (!is_streaming()).then_some(()))?;
        fence(Ordering::Acquire);
        for (place, byte) in sector.iter_mut().zip(&self.buffer.0) {
            *place = *byte;
        }
        Ok(())
    }

    /// How many bytes [`Self::send`] takes at most.
    pub const MOST_BYTES: usize = BUFFER_SECTORS * SECTOR_BYTES;

    /// Sends sectors to a card that waits for them, until it is no longer busy with the last.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), CardError> {
        for (place, byte) in self.buffer.0.iter_mut().zip(bytes) {
            *place = *byte;
        }
        let length = bytes.len().min(Self::MOST_BYTES);
        fence(Ordering::Release);
        self.start_stream(true, length);
        self.start_data(TO_CARD, length);
        self.await_data()
    }

    /// Lets go of whatever is under way.
    pub fn stop_data(&mut self) {
        // SAFETY: bits of registers
        unsafe { self.sdio.dctrl().write(|w| w.bits(0)) };
        stream().cr().modify(|_, w| w.en().clear_bit());
        // a burst at most
        let _ = wait_for(COMMAND_WAIT_US, || (!is_streaming()).then_some(()));
        // SAFETY: bits of a register
        unsafe { self.sdio.icr().write(|w| w.bits(ALL_FLAGS)) };
    }

    fn flags(&self) -> u32 {
        self.sdio.sta().read().bits()
    }

    fn await_data(&mut self) -> Result<(), CardError> {
        let over = DATA_FAILED | DATA_ENDED;
        let flags = wait_for(DATA_WAIT_US, || Some(self.flags()).filter(|flags| flags & over != 0));
        match flags {
            Ok(flags) if flags & DATA_FAILED == 0 => Ok(()),
            _ => {
                self.stop_data();
                Err(CardError::Failed)
            }
        }
    }

    fn start_data(&mut self, control: u32, length: usize) {
        // SAFETY: bits of registers
        unsafe {
            self.sdio.icr().write(|w| w.bits(ALL_FLAGS));
            self.sdio.dlen().write(|w| w.bits(length as u32));
            self.sdio.dctrl().write(|w| w.bits(control));
        }
    }

    /// The controller says when the last word has passed (RM 10.3.15); it takes words, four in a burst.
    fn start_stream(&mut self, to_card: bool, length: usize) {
        controller().lifcr().write(|w| {
            w.cfeif3().set_bit().cdmeif3().set_bit().cteif3().set_bit().chtif3().set_bit().ctcif3().set_bit()
        });
        let stream = stream();
        // SAFETY: the buffer lives for ever, outside the CCM, and is left alone until the stream has ended
        unsafe { stream.m0ar().write(|w| w.m0a().bits(self.buffer.0.as_ptr() as u32)) };
        stream.ndtr().write(|w| w.ndt().set((length / 4) as u16));
        // no direct mode, threshold at a full FIFO
        // SAFETY: bits of a register
        unsafe { stream.fcr().write(|w| w.bits(1 << 2 | 3)) };
        stream.cr().write(|w| {
            let w = w.chsel().set(CHANNEL).pfctrl().set_bit().minc().set_bit().psize().bits32().msize().bits32();
            let w = w.pburst().incr4().mburst().incr4();
            let w = if to_card { w.dir().memory_to_peripheral() } else { w.dir().peripheral_to_memory() };
            w.en().set_bit()
        });
    }
}

fn is_streaming() -> bool {
    stream().cr().read().en().bit_is_set()
}

fn stream() -> &'static dma2::ST {
    controller().st(STREAM)
}

fn controller() -> &'static dma2::RegisterBlock {
    // SAFETY: stream 3 belongs to the card alone; the flags are cleared by writing ones
    unsafe { &*DMA2::ptr() }
}

/// Looks for a result for so long, and sleeps from one interrupt to the next: the loop's comes 100 times a second at
/// least.
pub fn wait_for<T>(most_us: u32, mut look: impl FnMut() -> Option<T>) -> Result<T, CardError> {
    for _ in 0..LOOKS {
        if let Some(found) = look() {
            return Ok(found);
        }
    }
    let begin_us = clock::now_us();
    loop {
        // looked at once more after the time is over: whatever interrupts may have taken it
        let is_over = clock::now_us().wrapping_sub(begin_us) >= most_us;
        match look() {
            Some(found) => return Ok(found),
            None if is_over => return Err(CardError::Failed),
            None => load::sleep(),
        }
    }
}
