//! What the core sees of the board: peripherals at their addresses (RM0090 section 2.3), their clocks and resets.

use super::{Board, PORTS};
use crate::cortex::private_bus::part;
use crate::cpu::{AccessTime, Bus};
use crate::memory;
use crate::peripherals::adc::Adc;
use crate::peripherals::dma::Dma;
use crate::peripherals::gpio::Gpio;
use crate::peripherals::rcc::ClockGate;
use crate::peripherals::sdio::Sdio;
use crate::peripherals::spi::Spi;
use crate::peripherals::syscfg::SysCfg;
use crate::peripherals::timer::Timer;
use crate::peripherals::{Peripheral, Unmodelled};
use crate::stop::Cause;
use crate::time::Ticks;

/// Address of RCC.
const RCC: u32 = 0x4002_3800;

type Reset = fn(&mut Board);

/// What a reset by RCC puts back, besides ports and DMA.
const RESETS: [(ClockGate, Reset); 14] = [
    (ClockGate::ahb2(7), |board| board.otg_fs.reset()),
    (ClockGate::apb1(0), |board| board.tim2 = Timer::general(u32::MAX)),
    (ClockGate::apb1(1), |board| board.tim3 = Timer::general(0xffff)),
    (ClockGate::apb1(3), |board| board.tim5 = Timer::general(u32::MAX)),
    (ClockGate::apb1(14), |board| board.spi2 = Spi::default()),
    (ClockGate::apb1(17), |board| board.usart2.reset()),
    (ClockGate::apb1(18), |board| board.usart3.reset()),
    (ClockGate::apb1(28), |board| board.pwr.reset()),
    (ClockGate::apb2(0), |board| board.tim1 = Timer::advanced()),
    (ClockGate::apb2(5), |board| board.usart6.reset()),
    // all three converters together
    (ClockGate::apb2(8), |board| board.adc1 = Adc::default()),
    (ClockGate::apb2(11), |board| board.sdio = Sdio::default()),
    (ClockGate::apb2(12), |board| board.spi1 = Spi::default()),
    (ClockGate::apb2(14), |board| board.syscfg = SysCfg::default()),
];

impl Board {
    /// The peripheral at an address, the gate of its clock, its first address.
    fn at(&mut self, address: u32) -> Option<(&mut dyn Peripheral, Option<ClockGate>, u32)> {
        let (base, gate): (u32, _) = (address & !0x3ff, |gate| Some(gate));
        if memory::USB.contains(address, 1) {
            return Some((&mut self.otg_fs, gate(ClockGate::ahb2(7)), memory::USB.start));
        }
        let found: (&mut dyn Peripheral, _) = match base {
            0x4000_0000 => (&mut self.tim2, gate(ClockGate::apb1(0))),
            0x4000_0400 => (&mut self.tim3, gate(ClockGate::apb1(1))),
            0x4000_0c00 => (&mut self.tim5, gate(ClockGate::apb1(3))),
            0x4000_3000 => (&mut self.iwdg, None),
            0x4000_3800 => (&mut self.spi2, gate(ClockGate::apb1(14))),
            0x4000_4400 => (&mut self.usart2, gate(ClockGate::apb1(17))),
            0x4000_4800 => (&mut self.usart3, gate(ClockGate::apb1(18))),
            0x4000_7000 => (&mut self.pwr, gate(ClockGate::apb1(28))),
            0x4001_0000 => (&mut self.tim1, gate(ClockGate::apb2(0))),
            0x4001_1400 => (&mut self.usart6, gate(ClockGate::apb2(5))),
            0x4001_2000 => (&mut self.adc1, gate(ClockGate::apb2(8))),
            0x4001_2c00 => (&mut self.sdio, gate(ClockGate::apb2(11))),
            0x4001_3000 => (&mut self.spi1, gate(ClockGate::apb2(12))),
            0x4001_3800 => (&mut self.syscfg, gate(ClockGate::apb2(14))),
            0x4001_3c00 => (&mut self.exti, None),
            0x4002_0000..0x4002_2400 => {
                let port = (base - 0x4002_0000) / 0x400;
                (&mut self.ports[port as usize], gate(ClockGate::ahb1(port)))
            }
            RCC => (&mut self.rcc, None),
            0x4002_3c00 => (&mut self.flash, None),
            0x4002_6000 => (&mut self.dma[0], gate(ClockGate::ahb1(21))),
            0x4002_6400 => (&mut self.dma[1], gate(ClockGate::ahb1(22))),
            0xe004_2000 => (&mut self.dbgmcu, None),
            _ => return None,
        };
        Some((found.0, found.1, base))
    }

    fn check_clock(&self, gate: Option<ClockGate>) -> Result<(), Cause> {
        match gate {
            Some(gate) if !self.rcc.is_clocked(gate) => Err(Cause::ClockOff),
            _ => Ok(()),
        }
    }

    pub(super) fn read_register(&mut self, address: u32, now: Ticks) -> Result<u32, Cause> {
        let (_, gate, base) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        self.check_clock(gate)?;
        let (peripheral, ..) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        peripheral.read((address & !3) - base, now).map_err(|Unmodelled(what)| Cause::Unmodelled(what))
    }

    pub(super) fn write_register(&mut self, address: u32, value: u32, now: Ticks) -> Result<(), Cause> {
        let (_, gate, base) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        self.check_clock(gate)?;
        let (peripheral, ..) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        peripheral.write(address - base, value, now).map_err(|Unmodelled(what)| Cause::Unmodelled(what))?;
        if base == RCC {
            self.reset_peripherals();
        }
        Ok(())
    }

    pub(super) fn distribute_clocks(&mut self) {
        // RCC takes no setting that has no clocks
        self.clocks = self.rcc.clocks().unwrap_or(self.clocks);
        self.spi1.set_bus_cycle(self.clocks.apb2);
        self.spi2.set_bus_cycle(self.clocks.apb1);
        self.sdio.set_source_cycle(self.clocks.pll48);
        self.otg_fs.set_phy_cycle(self.clocks.pll48);
        self.usart2.set_bus_cycle(self.clocks.apb1);
        self.usart3.set_bus_cycle(self.clocks.apb1);
        self.usart6.set_bus_cycle(self.clocks.apb2);
        self.adc1.set_bus_cycle(self.clocks.apb2);
        self.tim1.set_cycle(self.clocks.apb2_timers, self.now);
        self.tim2.set_cycle(self.clocks.apb1_timers, self.now);
        self.tim3.set_cycle(self.clocks.apb1_timers, self.now);
        self.tim5.set_cycle(self.clocks.apb1_timers, self.now);
    }

    /// Puts back what RCC holds in reset.
    fn reset_peripherals(&mut self) {
        for (index, name) in PORTS.into_iter().enumerate() {
            if self.rcc.is_in_reset(ClockGate::ahb1(index as u32)) {
                self.ports[index] = Gpio::new(name);
            }
        }
        for (index, bit) in [21, 22].into_iter().enumerate() {
            if self.rcc.is_in_reset(ClockGate::ahb1(bit)) {
                self.dma[index] = Dma::default();
            }
        }
        for (gate, reset) in RESETS {
            if self.rcc.is_in_reset(gate) {
                reset(self);
            }
        }
        self.distribute_clocks();
    }

    fn backup_ram_bytes(&mut self, address: u32, size: u32, writes: bool) -> Result<&mut [u8], Cause> {
        self.check_clock(Some(ClockGate::ahb1(18)))?;
        if writes && !self.pwr.backup_writable() {
            return Err(Cause::Unmodelled("write to backup SRAM without PWR_CR.DBP"));
        }
        let first = (address & 0xfff) as usize;
        self.backup_ram.get_mut(first..first + size as usize).ok_or(Cause::Unmodelled("backup SRAM"))
    }

    fn load_at(&mut self, address: u32, size: u32, now: Ticks, cycles: u64) -> Result<u32, Cause> {
        match address {
            0x4002_4000..0x4002_5000 => {
                let mut word = [0; 4];
                word[..size as usize].copy_from_slice(self.backup_ram_bytes(address, size, false)?);
                Ok(u32::from_le_bytes(word))
            }
            0x4200_0000..0x4400_0000 => {
                let (word, bit) = memory::bit_band_target(memory::PERIPHERALS, address - 0x4200_0000);
                Ok(self.read_register(word, now)? >> bit & 1)
            }
            0xe000_0000..0xe004_0000 => self
                .private
                .load(address, size, now, cycles, self.clocks.core)
                .ok_or(Cause::Unmodelled("register on the private bus")),
            _ => Ok(part(self.read_register(address, now)?, address, size)),
        }
    }

    fn store_at(&mut self, address: u32, size: u32, value: u32, now: Ticks, cycles: u64) -> Result<(), Cause> {
        match address {
            0x4002_4000..0x4002_5000 => {
                let bytes = self.backup_ram_bytes(address, size, true)?;
                bytes.copy_from_slice(&value.to_le_bytes()[..size as usize]);
                Ok(())
            }
            0x4200_0000..0x4400_0000 => {
                let (word, bit) = memory::bit_band_target(memory::PERIPHERALS, address - 0x4200_0000);
                let old = self.read_register(word, now)?;
                self.write_register(word, old & !(1 << bit) | (value & 1) << bit, now)
            }
            0xe000_0000..0xe004_0000 => self
                .private
                .store(address, size, value, now, cycles)
                .ok_or(Cause::Unmodelled("register on the private bus")),
            _ => self.write_register(address, value, now),
        }
    }

    /// Writes words, as a bootloader may have done.
    pub(crate) fn preset(&mut self, registers: &[(u32, u32)]) {
        for (address, word) in registers {
            self.store(*address, 4, *word, AccessTime { cycles: 0 });
        }
    }

    fn time_of(&self, at: AccessTime) -> (Ticks, u64) {
        (self.now + at.cycles * self.clocks.core, self.cycles + at.cycles)
    }
}

impl Bus for Board {
    fn load(&mut self, address: u32, size: u32, at: AccessTime) -> u32 {
        let (now, cycles) = self.time_of(at);
        match self.load_at(address, size, now, cycles) {
            Ok(value) => value,
            Err(cause) => {
                self.refuse(cause, address, None);
                0
            }
        }
    }

    fn store(&mut self, address: u32, size: u32, value: u32, at: AccessTime) {
        let (now, cycles) = self.time_of(at);
        match self.store_at(address, size, value, now, cycles) {
            Ok(()) => self.refresh_lines(now),
            Err(cause) => self.refuse(cause, address, Some(value)),
        }
    }

    fn is_over(&self) -> bool {
        self.stop.is_some()
    }
}
