//! The memory that survives power loss: a ferroelectric RAM FM25V01 (16 KB) on SPI2, by polling.
//!
//! Data sheet: Cypress 001-84497. It writes at the speed of the bus and without wear, so nothing waits for it; a
//! transfer of the record takes 50 us.

use shared_control::link::signing::{SIGNING_RECORD_LEN, SigningRecord};
use shared_control::params::RECORD_LEN;
use stm32f4xx_hal::gpio::{Alternate, Output, PB13, PB14, PB15, PD10};
use stm32f4xx_hal::pac::SPI2;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::clock;

/// Allows the next write; forgotten when that ends.
const WRITE_ENABLE: u8 = 0x06;
const WRITE: u8 = 0x02;
const READ: u8 = 0x03;
/// What slept until it was selected answers this much later (tREC), us; a little more.
const WAKE_US: u32 = 450;
/// Where the record of parameters lies, high byte first.
const RECORD_ADDRESS: [u8; 2] = [0, 0];
/// Where key and clock of signed frames lie, by the lowest bit of their serial number.
const SIGNING_ADDRESSES: [[u8; 2]; 2] = [[0x10, 0], [0x11, 0]];

/// Clock, MISO, MOSI.
pub type Pins = (PB13<Alternate<5>>, PB14<Alternate<5>>, PB15<Alternate<5>>);

/// The memory with its bus, which nobody else uses.
pub struct Fram {
    spi: SPI2,
    select: PD10<Output>,
    _pins: Pins,
}

impl Fram {
    /// Takes the bus: mode 3, 42 MHz / 8. The chip select must already be high.
    pub fn new(spi: SPI2, pins: Pins, select: PD10<Output>, rcc: &mut Rcc) -> Self {
        SPI2::enable(rcc);
        SPI2::reset(rcc);
        spi.cr1().write(|w| {
            w.cpol().set_bit().cpha().set_bit().mstr().set_bit().ssm().set_bit().ssi().set_bit().br().div8();
            w.spe().set_bit()
        });
        let mut memory = Self { spi, select, _pins: pins };
        memory.wake();
        memory
    }

    /// Whoever ran before may have sent it to sleep, which lasts over a restart without a loss of power: a select wakes
    /// it.
    fn wake(&mut self) {
        self.select.set_low();
        self.end();
        clock::wait_us(WAKE_US);
    }

    /// What is stored; if no memory answers, equal bytes that no record begins with.
    pub fn read(&mut self) -> [u8; RECORD_LEN] {
        self.read_at(RECORD_ADDRESS)
    }

    /// The later of the two records of signing; one without a key if there is none.
    pub fn read_signing(&mut self) -> SigningRecord {
        let places = SIGNING_ADDRESSES.map(|address| SigningRecord::decode(&self.read_at(address)));
        SigningRecord::latest(places)
    }

    /// Stores a record and reads it back; false if it is not what was written.
    pub fn store(&mut self, record: &[u8; RECORD_LEN]) -> bool {
        self.store_at(RECORD_ADDRESS, record)
    }

    /// The same for a record of signing; the one before stays in the other place.
    pub fn store_signing(&mut self, record: &SigningRecord) -> bool {
        let [even, odd] = SIGNING_ADDRESSES;
        let bytes: [u8; SIGNING_RECORD_LEN] = record.encode();
        self.store_at(if record.serial.is_multiple_of(2) { even } else { odd }, &bytes)
    }

    fn read_at<const N: usize>(&mut self, address: [u8; 2]) -> [u8; N] {
        let mut record = [0; N];
        self.begin(READ, address);
        for byte in &mut record {
            *byte = self.exchange(0);
        }
        self.end();
        record
    }

    fn store_at<const N: usize>(&mut self, address: [u8; 2], record: &[u8; N]) -> bool {
        self.select.set_low();
        self.exchange(WRITE_ENABLE);
        self.end();
        self.begin(WRITE, address);
        for byte in record {
            self.exchange(*byte);
        }
        self.end();
        self.read_at::<N>(address) == *record
    }

    fn begin(&mut self, opcode: u8, address: [u8; 2]) {
        self.select.set_low();
        self.exchange(opcode);
        for byte in address {
            self.exchange(byte);
        }
    }

    /// A command acts when the select line rises, and another may begin 60 ns later (tD): two stores in a row are 12 to
    /// 18 ns apart, and the memory would not even notice.
    fn end(&mut self) {
        self.select.set_high();
        clock::wait_us(1);
    }

    fn exchange(&self, byte: u8) -> u8 {
        self.spi.dr().write(|w| w.dr().set(u16::from(byte)));
        // a master always gets its byte: it makes the clock
        while self.spi.sr().read().rxne().bit_is_clear() {}
        self.spi.dr().read().dr().bits() as u8
    }
}
