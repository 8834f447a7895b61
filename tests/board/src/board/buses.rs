//! SPI1 and SPI2 with the devices on them: who is selected answers.

use super::wiring::SPI1_DMA;
use super::{A, B, Board, C, D, FLOATING};
use crate::devices::Sensor;
use crate::memory::Memory;
use crate::peripherals::spi_clock::{self, LAST_BIT_LATE};
use crate::stop::Cause;
use crate::time::Ticks;

/// Clock, MISO and MOSI: of SPI1 on port A, of SPI2 on port B; both alternate function 5.
pub(super) const SPI1_PINS: [u32; 3] = [5, 6, 7];
pub(super) const SPI2_PINS: [u32; 3] = [13, 14, 15];
const SPI_FUNCTION: Option<u32> = Some(5);

/// Chip selects on SPI1: the port and the pin.
const MPU6000: (usize, u32) = (C, 2);
const L3GD20: (usize, u32) = (C, 13);
const LSM303D: (usize, u32) = (C, 15);
const MS5611: (usize, u32) = (D, 7);
pub(super) const SPI1_SELECTS: [(usize, u32); 4] = [MPU6000, L3GD20, LSM303D, MS5611];
/// On SPI2.
pub(super) const FRAM: (usize, u32) = (D, 10);

impl Board {
    pub(super) fn tick_spi1(&mut self, now: Ticks, memory: &mut dyn Memory) {
        self.move_items(&SPI1_DMA, memory);
        while let Some(byte) = self.spi1.shifted_out(now) {
            let answer = self.exchange_on_spi1(byte, now);
            let answer = self.clocked(1, answer, now);
            self.spi1.answer(answer);
            self.move_items(&SPI1_DMA, memory);
        }
    }

    pub(super) fn tick_spi2(&mut self, now: Ticks) {
        while let Some(byte) = self.spi2.shifted_out(now) {
            let answer = self.exchange_on_spi2(byte);
            let answer = self.clocked(2, answer, now);
            self.spi2.answer(answer);
        }
    }

    /// Follows the levels of the chip selects.
    pub(super) fn refresh_selects(&mut self, now: Ticks) {
        let low = |(port, pin): (usize, u32)| self.ports[port].output_level(pin) == Some(false);
        let [mpu6000, l3gd20, lsm303d, fram] = [MPU6000, L3GD20, LSM303D, FRAM].map(low);
        let held = self.mpu6000.select(mpu6000, now);
        self.keep_rule(held, now);
        self.l3gd20.select(l3gd20);
        self.lsm303d.select(lsm303d);
        let edge_ns = self.ports[FRAM.0].speed(FRAM.1).edge_ns(self.load);
        if let Err(rule) = self.fram.select(fram, now, edge_ns)
            && self.break_rule(rule, now)
        {
            self.fram.end_command(now);
        }
        self.check_idle_clocks(now);
    }

    /// What a byte that came back is worth, by the speed of the clock's pin.
    pub(super) fn clocked(&mut self, bus: usize, answer: u8, now: Ticks) -> u8 {
        let (spi, port, pin) = match bus {
            1 => (&self.spi1, A, SPI1_PINS[0]),
            _ => (&self.spi2, B, SPI2_PINS[0]),
        };
        let speed = self.ports[port].speed(pin);
        let follows = spi_clock::check_pin(speed, self.load, spi.clock_hz());
        let late = spi_clock::loses_last_bit(speed, spi.bus_hz());
        let before = std::mem::replace(&mut self.last_answer[bus - 1], answer);
        self.keep_rule(follows, now);
        if late && !self.break_rule(LAST_BIT_LATE, now) { answer & !1 | before & 1 } else { answer }
    }

    pub(super) fn exchange_on_spi1(&mut self, byte: u8, now: Ticks) -> u8 {
        if SPI1_PINS.iter().any(|pin| self.ports[A].alternate_function(*pin) != SPI_FUNCTION) {
            return FLOATING;
        }
        let level = |(port, pin): (usize, u32)| self.ports[port].output_level(pin);
        let mut selected = SPI1_SELECTS.into_iter().filter(|select| level(*select) != Some(true));
        let (first, second) = (selected.next(), selected.next());
        let answer = match (first, second) {
            (None, _) => Ok(FLOATING),
            (Some(_), Some(_)) => Err("SPI1 clocked while more than one chip select is not high"),
            (Some(select), None) if level(select).is_none() => Err("SPI1 clocked while a chip select floats"),
            _ if !self.spi1.is_mode_3() => Err("SPI1 in a mode other than 3"),
            (Some(MPU6000), None) => self.exchange_with(Sensor::Mpu6000, byte, now),
            (Some(L3GD20), None) => self.exchange_with(Sensor::L3gd20, byte, now),
            (Some(LSM303D), None) => self.exchange_with(Sensor::Lsm303d, byte, now),
            (Some(_), None) => Err("device on SPI1"),
        };
        self.answer_or_refuse(answer)
    }

    fn exchange_with(&mut self, sensor: Sensor, byte: u8, now: Ticks) -> Result<u8, &'static str> {
        let clock_hz = self.spi1.clock_hz();
        let answer = match sensor {
            Sensor::Mpu6000 => {
                let ready = self.mpu6000.check_data_after(byte);
                self.keep_rule(ready, now);
                self.mpu6000.exchange(byte, clock_hz, now)
            }
            Sensor::L3gd20 => self.l3gd20.exchange(byte, clock_hz, now),
            Sensor::Lsm303d => self.lsm303d.exchange(byte, clock_hz, now),
        };
        self.stuck_answer(sensor).map_or(answer, Ok)
    }

    fn exchange_on_spi2(&mut self, byte: u8) -> u8 {
        if SPI2_PINS.iter().any(|pin| self.ports[B].alternate_function(*pin) != SPI_FUNCTION) {
            return FLOATING;
        }
        if !self.fram.is_selected() {
            return FLOATING;
        }
        let answer = match self.spi2.is_mode_3() || self.spi2.is_mode_0() {
            true => self.fram.exchange(byte, self.spi2.clock_hz(), self.now),
            false => Err("FRAM in SPI mode 1 or 2"),
        };
        self.answer_or_refuse(answer)
    }

    fn answer_or_refuse(&mut self, answer: Result<u8, &'static str>) -> u8 {
        answer.unwrap_or_else(|why| {
            self.refuse(Cause::Unmodelled(why), 0, None);
            FLOATING
        })
    }
}
