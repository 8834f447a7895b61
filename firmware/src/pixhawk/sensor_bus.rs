//! SPI1, the bus of the internal sensors: supply, chip selects, registers by polling, speeds.
//!
//! Mode 3. Registers at 656 kHz (the MPU6000 allows 1 MHz), samples at 10.5 MHz (the MPU6000 allows 20) or 5.25 MHz
//! (the others allow 10).
#![allow(unsafe_code)] // a reset without the owner of all clocks

use stm32f4xx_hal::gpio::{Alternate, Output, PA5, PA6, PA7, PC2, PC13, PC15, PD7, PE3};
use stm32f4xx_hal::pac::{SPI1, spi1};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::board;
use super::clock;

/// First bit of a register address that is read.
pub const READ: u8 = 0x80;
/// Second bit, where the L3GD20 and the LSM303D are to go on to the next register.
pub const INCREMENT: u8 = 0x40;

/// A sensor in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum Chip {
    /// Gyro and accelerometer of the first IMU.
    Mpu6000,
    /// Gyro of the second IMU.
    L3gd20,
    /// Accelerometer of the second IMU.
    Lsm303d,
}

/// What is wrong with a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum Flaw {
    /// Somebody else, or nobody, answers; with the answer.
    Identity(u8),
    /// A register did not keep what was written; with its address.
    Register(u8),
}

/// Why a sensor is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub struct SensorFault {
    /// The sensor.
    pub chip: Chip,
    /// What is wrong with it.
    pub flaw: Flaw,
}

impl SensorFault {
    /// For a person.
    pub fn words(self) -> &'static str {
        match (self.chip, self.flaw) {
            (Chip::Mpu6000, Flaw::Identity(_)) => "MPU6000 does not answer as itself",
            (Chip::Mpu6000, Flaw::Register(_)) => "MPU6000 does not keep its settings",
            (Chip::L3gd20, Flaw::Identity(_)) => "L3GD20 does not answer as itself",
            (Chip::L3gd20, Flaw::Register(_)) => "L3GD20 does not keep its settings",
            (Chip::Lsm303d, Flaw::Identity(_)) => "LSM303D does not answer as itself",
            (Chip::Lsm303d, Flaw::Register(_)) => "LSM303D does not keep its settings",
        }
    }
}

/// Chip selects of all that hangs on the bus; one that floats would answer along.
pub struct Selects {
    /// MPU6000.
    pub mpu6000: PC2<Output>,
    /// L3GD20.
    pub l3gd20: PC13<Output>,
    /// LSM303D.
    pub lsm303d: PC15<Output>,
    /// MS5611: not used yet, but kept high.
    pub ms5611: PD7<Output>,
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
    /// Restarts the sensors and takes the bus. All that leads to the sensors must be low: while they have no supply, a
    /// line that is high feeds them through their protection diodes, and they come up in any state.
    pub fn new(spi: SPI1, pins: Pins, mut selects: Selects, supply: &mut PE3<Output>, rcc: &mut Rcc) -> Self {
        supply.set_low();
        clock::wait_us(board::SENSOR_OFF_MS * 1000);
        supply.set_high();
        clock::wait_us(board::SENSOR_RISE_US);
        selects.mpu6000.set_high();
        selects.l3gd20.set_high();
        selects.lsm303d.set_high();
        selects.ms5611.set_high();
        clock::wait_us(board::SENSOR_START_MS * 1000);
        SPI1::enable(rcc);
        SPI1::reset(rcc);
        // for registers: 84 MHz / 128
        spi.cr1().write(|w| mode_3(w).br().div128().spe().set_bit());
        Self { spi, selects, _pins: pins }
    }

    /// From now on samples, by DMA.
    pub fn hand_to_dma(&self) {
        self.spi.cr1().write(|w| mode_3(w));
        self.spi.cr2().write(|w| w.rxdmaen().set_bit().txdmaen().set_bit());
    }

    /// Begins a transfer of a sample, at the chip's speed.
    pub fn begin_sample(&mut self, chip: Chip) {
        // the speed may change only while it is off
        self.spi.cr1().write(|w| at_speed_of(chip, mode_3(w)));
        // before the chip listens: until then nobody drives the clock, and an edge of it would shift all bits by one
        self.spi.cr1().write(|w| at_speed_of(chip, mode_3(w)).spe().set_bit());
        self.select(chip);
    }

    /// Begins a transfer of a register, at the speed that registers allow.
    pub fn begin_register(&mut self, chip: Chip) {
        self.spi.cr1().write(|w| mode_3(w).br().div128());
        self.spi.cr1().write(|w| mode_3(w).br().div128().spe().set_bit());
        self.select(chip);
    }

    /// Ends it: the MPU6000 wants its select low for 500 ns more (product specification 6.8), and then as long high.
    pub fn release_register(&mut self, chip: Chip) {
        clock::wait_us(1);
        self.release(chip);
        clock::wait_us(1);
    }

    /// Ends one that was broken off, and clears away what is left of it.
    pub fn start_over(&mut self, chip: Chip) {
        self.release(chip);
        // SAFETY: a write to the bit of this peripheral alone, through its bit-band alias
        unsafe { SPI1::reset_unchecked() };
        self.hand_to_dma();
    }

    /// Ends a transfer.
    pub fn release(&mut self, chip: Chip) {
        match chip {
            Chip::Mpu6000 => self.selects.mpu6000.set_high(),
            Chip::L3gd20 => self.selects.l3gd20.set_high(),
            Chip::Lsm303d => self.selects.lsm303d.set_high(),
        }
    }

    fn select(&mut self, chip: Chip) {
        match chip {
            Chip::Mpu6000 => self.selects.mpu6000.set_low(),
            Chip::L3gd20 => self.selects.l3gd20.set_low(),
            Chip::Lsm303d => self.selects.lsm303d.set_low(),
        }
    }

    /// Reads one register.
    pub fn read(&mut self, chip: Chip, register: u8) -> u8 {
        self.transfer(chip, READ | register, 0)
    }

    /// Writes one.
    pub fn write(&mut self, chip: Chip, register: u8, value: u8) {
        self.transfer(chip, register, value);
    }

    /// Writes registers, each with its value.
    pub fn write_all(&mut self, chip: Chip, settings: &[(u8, u8)]) {
        for (register, value) in settings {
            self.write(chip, *register, *value);
        }
    }

    /// Do they read back?
    pub fn verify(&mut self, chip: Chip, settings: &[(u8, u8)]) -> Result<(), SensorFault> {
        for (register, value) in settings {
            if self.read(chip, *register) != *value {
                return Err(SensorFault { chip, flaw: Flaw::Register(*register) });
            }
        }
        Ok(())
    }

    fn transfer(&mut self, chip: Chip, address: u8, value: u8) -> u8 {
        self.select(chip);
        // PC13 and PC15 are slow
        clock::wait_us(1);
        self.exchange(address);
        let answer = self.exchange(value);
        // the MPU6000 wants its select low for 500 ns more (product specification 6.8) ...
        clock::wait_us(1);
        self.release(chip);
        // ... and then as long high
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

/// A master in mode 3 that leaves chip selects to others.
fn mode_3(w: &mut spi1::cr1::W) -> &mut spi1::cr1::W {
    w.cpol().set_bit().cpha().set_bit().mstr().set_bit().ssm().set_bit().ssi().set_bit()
}

fn at_speed_of(chip: Chip, w: &mut spi1::cr1::W) -> &mut spi1::cr1::W {
    match chip {
        Chip::Mpu6000 => w.br().div8(),
        Chip::L3gd20 | Chip::Lsm303d => w.br().div16(),
    }
}
