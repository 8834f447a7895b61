//! SPI1, the bus of the internal sensors: supply, chip selects, registers by polling.
//!
//! Mode 3. Registers at 656 kHz (the MPU6000 allows 1 MHz), samples at 10.5 MHz (it allows 20).

use stm32f4xx_hal::gpio::{Alternate, Output, PA5, PA6, PA7, PC2, PC13, PC15, PD7, PE3};
use stm32f4xx_hal::pac::SPI1;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::board;
use super::clock;

/// First bit of a register address that is read.
pub const READ: u8 = 0x80;

/// Chip selects of all that hangs on the bus; one that floats would answer along.
pub struct Selects {
    /// MPU6000.
    pub mpu6000: PC2<Output>,
    /// L3GD20, LSM303D, MS5611: not used yet, but kept high.
    pub _unused: (PC13<Output>, PC15<Output>, PD7<Output>),
}

/// Clock, MISO, MOSI.
pub type Pins = (PA5<Alternate<5>>, PA6<Alternate<5>>, PA7<Alternate<5>>);

/// The bus.
pub struct SensorBus {
    /// The SPI itself, for whoever runs DMA on it.
    pub spi: SPI1,
    selects: Selects,
    _pins: Pins,
}

impl SensorBus {
    /// Restarts the sensors and takes the bus. Chip selects must already be high.
    pub fn new(spi: SPI1, pins: Pins, selects: Selects, supply: &mut PE3<Output>, rcc: &mut Rcc) -> Self {
        supply.set_low();
        clock::wait_us(board::SENSOR_OFF_MS * 1000);
        supply.set_high();
        clock::wait_us(board::SENSOR_START_MS * 1000);
        SPI1::enable(rcc);
        SPI1::reset(rcc);
        let bus = Self { spi, selects, _pins: pins };
        bus.slow();
        bus
    }

    /// For registers: 84 MHz / 128.
    pub fn slow(&self) {
        self.spi.cr1().modify(|_, w| w.spe().clear_bit());
        self.spi.cr1().write(|w| {
            w.cpol().set_bit().cpha().set_bit().mstr().set_bit().ssm().set_bit().ssi().set_bit().br().div128();
            w.spe().set_bit()
        });
    }

    /// For samples, by DMA: 84 MHz / 8.
    pub fn fast(&self) {
        self.spi.cr1().modify(|_, w| w.spe().clear_bit());
        self.spi.cr2().write(|w| w.rxdmaen().set_bit().txdmaen().set_bit());
        self.spi.cr1().modify(|_, w| w.br().div8().spe().set_bit());
    }

    /// Begins a transfer with the MPU6000.
    pub fn select(&mut self) {
        self.selects.mpu6000.set_low();
    }

    /// Ends it.
    pub fn release(&mut self) {
        self.selects.mpu6000.set_high();
    }

    /// Reads one register of the MPU6000.
    pub fn read(&mut self, register: u8) -> u8 {
        self.transfer(READ | register, 0)
    }

    /// Writes one.
    pub fn write(&mut self, register: u8, value: u8) {
        self.transfer(register, value);
    }

    fn transfer(&mut self, address: u8, value: u8) -> u8 {
        self.select();
        self.exchange(address);
        let answer = self.exchange(value);
        self.release();
        // the MPU6000 wants its select high for 500 ns
        clock::wait_us(1);
        answer
    }

    fn exchange(&self, byte: u8) -> u8 {
        self.spi.dr().write(|w| w.dr().set(u16::from(byte)));
        // a master always gets its byte: it makes the clock
        while self.spi.sr().read().rxne().bit_is_clear() {}
        self.spi.dr().read().dr().bits() as u8
    }
}
