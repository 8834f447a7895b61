//! The board as a block diagram: the chip's peripherals, the devices around it, and the wires between them.
//!
//! ```text
//!  PE3 --------> MPU6000 <--- world: counts at its sample clock
//!  PC2 (CS) ---> |     `--- data-ready --> PD15 -> SYSCFG -> EXTI15_10 -> NVIC
//!  SPI1 <------> '           DMA2 S0 <-- received    S5 --> to send
//!  TIM3 -- trigger output (update) --> TIM1 --> PE14, 13, 11, 9 --> world: pulses
//!  USART2 <----> TELEM1      DMA1 S5 <-- received    S6 --> to send
//!  TIM5: time base           RCC: clocks of all of them
//! ```

use crate::cortex::private_bus::{PrivateBus, part};
use crate::cpu::{Bus, Place};
use crate::devices::mpu6000::{Counts, Mpu6000};
use crate::memory::{self, Memory};
use crate::peripherals::dbgmcu::DbgMcu;
use crate::peripherals::dma::Dma;
use crate::peripherals::exti::Exti;
use crate::peripherals::flash::Flash;
use crate::peripherals::gpio::Gpio;
use crate::peripherals::iwdg::{Iwdg, LSI_HZ};
use crate::peripherals::pwr::Pwr;
use crate::peripherals::rcc::{ClockGate, Clocks, Rcc};
use crate::peripherals::spi::Spi;
use crate::peripherals::syscfg::SysCfg;
use crate::peripherals::timer::{Pulse, Timer};
use crate::peripherals::usart::Usart;
use crate::peripherals::{Peripheral, Unmodelled};
use crate::stop::{Cause, Stop};
use crate::time::Ticks;

/// Cycles that every instruction is charged.
pub(crate) const CYCLES_PER_INSTRUCTION: u64 = 2;

const PORTS: [char; 9] = ['A', 'B', 'C', 'D', 'E', 'F', 'G', 'H', 'I'];
const A: usize = 0;
const C: usize = 2;
const D: usize = 3;
const E: usize = 4;
/// SPI1's clock and data.
const SPI1_PINS: [u32; 3] = [5, 6, 7];
/// Pins of the motor channels, TIM1 CH1 to CH4.
const MOTOR_PINS: [u32; 4] = [9, 11, 13, 14];
/// Chip selects on SPI1 besides the MPU6000's: L3GD20, LSM303D, MS5611.
const OTHER_SELECTS: [(usize, u32); 3] = [(C, 13), (C, 15), (D, 7)];
/// TIM1's trigger input that is TIM3 (RM0090 table 93).
const TIM1_FROM_TIM3: u32 = 2;
/// TELEM1's usual baud rate.
const TELEM1_BAUD: u64 = 115_200;

/// The vehicle and its surroundings, as the board's sensors and outputs meet them.
pub trait World {
    /// What the IMU measures at this time.
    fn imu(&mut self, now: Ticks) -> Counts;
    /// A pulse ended on a motor output: channel 0 to 3 is TIM1 CH1 to CH4.
    fn pulse(&mut self, pulse: Pulse);
    /// TIM3 sent its trigger, the tick of the image's loop.
    fn loop_tick(&mut self, _at: Ticks) {}
}

/// In the place of a world that has been taken out.
struct Nowhere;

impl World for Nowhere {
    fn imu(&mut self, _: Ticks) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}

/// All that is not the core or its memory.
pub(crate) struct Board {
    pub(crate) private: PrivateBus,
    rcc: Rcc,
    clocks: Clocks,
    pwr: Pwr,
    flash: Flash,
    ports: [Gpio; PORTS.len()],
    exti: Exti,
    syscfg: SysCfg,
    dma: [Dma; 2],
    spi1: Spi,
    tim1: Timer,
    tim3: Timer,
    tim5: Timer,
    usart2: Usart,
    iwdg: Iwdg,
    dbgmcu: DbgMcu,
    backup_ram: Vec<u8>,
    mpu6000: Mpu6000,
    pub(crate) world: Box<dyn World>,
    /// Time and core cycles at the start of the slice.
    pub(crate) now: Ticks,
    pub(crate) cycles: u64,
    pub(crate) stop: Option<Stop>,
}

/// Who asks a DMA stream for an item: controller (0 is DMA1), stream, channel (RM0090 tables 42 and 43).
#[derive(Clone, Copy)]
struct DmaWire {
    controller: usize,
    stream: usize,
    channel: u32,
    to_peripheral: bool,
    asks: fn(&Board) -> bool,
}

const DMA_WIRES: [DmaWire; 4] = [
    DmaWire { controller: 1, stream: 0, channel: 3, to_peripheral: false, asks: |b| b.spi1.requests_receive_dma() },
    DmaWire { controller: 1, stream: 5, channel: 3, to_peripheral: true, asks: |b| b.spi1.requests_transmit_dma() },
    DmaWire { controller: 0, stream: 5, channel: 4, to_peripheral: false, asks: |b| b.usart2.requests_receive_dma() },
    DmaWire { controller: 0, stream: 6, channel: 4, to_peripheral: true, asks: |b| b.usart2.requests_transmit_dma() },
];

impl Board {
    /// As after power-on.
    pub(crate) fn new(world: Box<dyn World>, seed: u64) -> Self {
        // power-on, brown-out and pin reset (section 6.3.21)
        let rcc = Rcc::new(1 << 27 | 1 << 26 | 1 << 25);
        let clocks = Clocks { core: 21, apb1: 21, apb2: 21, apb1_timers: 21, apb2_timers: 21 };
        let mut board = Self {
            private: PrivateBus::new(0),
            rcc,
            clocks,
            pwr: Pwr::default(),
            flash: Flash::default(),
            ports: PORTS.map(Gpio::new),
            exti: Exti::default(),
            syscfg: SysCfg::default(),
            dma: Default::default(),
            spi1: Spi::default(),
            tim1: Timer::advanced(),
            tim3: Timer::general(0xffff),
            tim5: Timer::general(u32::MAX),
            usart2: Usart::new(TELEM1_BAUD),
            iwdg: Iwdg::new(LSI_HZ),
            dbgmcu: DbgMcu::default(),
            backup_ram: memory::noise(0x1000, seed ^ 0xbac),
            mpu6000: Mpu6000::default(),
            world,
            now: 0,
            cycles: 0,
            stop: None,
        };
        board.distribute_clocks();
        board
    }

    /// A reset for these reasons (flags of RCC_CSR): what keeps its power stays, backup SRAM and the sensors.
    pub(crate) fn reset(&mut self, flags: u32) {
        let flags_so_far = self.rcc.reset_flags();
        let mut fresh = Self::new(std::mem::replace(&mut self.world, Box::new(Nowhere)), 0);
        std::mem::swap(&mut fresh.backup_ram, &mut self.backup_ram);
        std::mem::swap(&mut fresh.mpu6000, &mut self.mpu6000);
        (fresh.now, fresh.cycles) = (self.now, self.cycles);
        fresh.rcc = Rcc::new(flags_so_far | flags);
        *self = fresh;
    }

    /// The reset that is due, by its flags in RCC_CSR (section 6.3.21); each pulls the reset pin too.
    pub(crate) fn due_reset(&self, now: Ticks) -> Option<u32> {
        const PIN: u32 = 1 << 26;
        if self.iwdg.bites(now) {
            return Some(PIN | 1 << 29);
        }
        self.private.reset_requested.then_some(PIN | 1 << 28)
    }

    pub(crate) fn core_ticks(&self) -> Ticks {
        self.clocks.core
    }

    /// Everything that is due by `now`, in the order of the wires.
    pub(crate) fn tick(&mut self, now: Ticks, memory: &mut dyn Memory) {
        if self.private.systick.tick(now, self.clocks.core) {
            self.private.exceptions.pend(crate::cortex::exceptions::SYS_TICK);
        }
        self.tim5.tick(now);
        self.tick_motor_timers(now);
        self.tick_imu(now);
        self.tick_spi1(now, memory);
        self.tick_usart2(now, memory);
        self.refresh_lines();
    }

    /// When something will happen next without the core doing anything.
    pub(crate) fn next_event(&self) -> Option<Ticks> {
        let timers = [&self.tim1, &self.tim3, &self.tim5].into_iter().filter_map(|timer| timer.next_event());
        let others = [
            self.private.systick.next_event(self.clocks.core),
            self.spi1.next_event(),
            self.usart2.next_event(),
            self.mpu6000.next_event(),
            self.iwdg.next_event(),
        ];
        timers.chain(others.into_iter().flatten()).min()
    }

    fn tick_motor_timers(&mut self, now: Ticks) {
        self.tim3.tick(now);
        for at in self.tim3.take_triggers() {
            self.world.loop_tick(at);
            if self.tim1.trigger_input() == Some(TIM1_FROM_TIM3) {
                self.tim1.trigger(at);
            }
        }
        self.tim1.tick(now);
        for pulse in self.tim1.take_pulses() {
            if self.ports[E].alternate_function(MOTOR_PINS[pulse.channel]) == Some(1) {
                self.world.pulse(pulse);
            }
        }
    }

    fn tick_imu(&mut self, now: Ticks) {
        while self.mpu6000.sample_due(now) {
            let counts = self.world.imu(self.mpu6000.next_event().unwrap_or(now));
            self.mpu6000.sample(counts);
        }
        self.mpu6000.tick(now);
    }

    fn tick_spi1(&mut self, now: Ticks, memory: &mut dyn Memory) {
        self.move_items(memory);
        while let Some(byte) = self.spi1.shifted_out(now) {
            let answer = self.exchange_on_spi1(byte, now);
            self.spi1.answer(answer);
            self.move_items(memory);
        }
    }

    fn tick_usart2(&mut self, now: Ticks, memory: &mut dyn Memory) {
        self.move_items(memory);
        while self.usart2.next_event().is_some_and(|at| at <= now) {
            self.usart2.tick(now);
            self.move_items(memory);
        }
    }

    fn exchange_on_spi1(&mut self, byte: u8, now: Ticks) -> u8 {
        const FLOATING: u8 = 0xff;
        if SPI1_PINS.iter().any(|pin| self.ports[A].alternate_function(*pin) != Some(5)) {
            return FLOATING;
        }
        if OTHER_SELECTS.iter().any(|(port, pin)| self.ports[*port].output_level(*pin) != Some(true)) {
            self.refuse(Cause::Unmodelled("SPI1 clocked while another chip select is not high"), 0, None, 0);
        }
        if !self.mpu6000.is_selected() || !self.spi1.is_mode_3() {
            return FLOATING;
        }
        let answer = self.mpu6000.exchange(byte, self.spi1.clock_hz(), now);
        answer.unwrap_or_else(|why| {
            self.refuse(Cause::Unmodelled(why), 0, None, 0);
            FLOATING
        })
    }

    /// Moves items for as long as a peripheral asks and a stream serves it.
    fn move_items(&mut self, memory: &mut dyn Memory) {
        for wire in DMA_WIRES {
            while (wire.asks)(self) {
                let DmaWire { controller, stream, channel, to_peripheral, .. } = wire;
                let Some(item) = self.dma[controller].item(stream, channel, to_peripheral) else { break };
                let mut byte = [0];
                let reaches = memory::RAM.contains(item.memory_address, 1)
                    || to_peripheral && memory::FLASH.contains(item.memory_address, 1);
                let (address, at) = (item.peripheral_address, self.now);
                let done = reaches
                    && if to_peripheral {
                        memory.load(item.memory_address, &mut byte)
                            && self.write_register(address, byte[0].into(), at).is_ok()
                    } else {
                        self.read_register(address, at)
                            .is_ok_and(|word| memory.store(item.memory_address, &[word as u8]))
                    };
                if done { self.dma[controller].moved(stream) } else { self.dma[controller].failed(stream) }
            }
        }
    }

    /// Levels that follow from others: pins, EXTI lines, interrupt lines.
    pub(crate) fn refresh_lines(&mut self) {
        self.mpu6000.power(self.ports[E].output_level(3) == Some(true), self.now);
        self.mpu6000.select(self.ports[C].output_level(2) == Some(false));
        self.ports[D].drive(15, self.mpu6000.interrupt_pin());
        for line in 0..16 {
            let port = self.syscfg.port_of_line(line) as usize;
            let level = self.ports.get(port).is_some_and(|port| port.level(line));
            self.exti.set_level(line, level);
        }
        self.exti.set_level(16, self.pwr.supply_low());
        let exceptions = &mut self.private.exceptions;
        exceptions.set_line(1, self.exti.requests(1 << 16));
        for (line, interrupt) in [(0, 6), (1, 7), (2, 8), (3, 9), (4, 10)] {
            exceptions.set_line(interrupt, self.exti.requests(1 << line));
        }
        exceptions.set_line(23, self.exti.requests(0x03e0));
        exceptions.set_line(40, self.exti.requests(0xfc00));
        for (stream, interrupt) in [11, 12, 13, 14, 15, 16, 17, 47].into_iter().enumerate() {
            exceptions.set_line(interrupt, self.dma[0].interrupt(stream));
        }
        for (stream, interrupt) in [56, 57, 58, 59, 60, 68, 69, 70].into_iter().enumerate() {
            exceptions.set_line(interrupt, self.dma[1].interrupt(stream));
        }
        exceptions.set_line(25, self.tim1.update_interrupt());
        exceptions.set_line(27, self.tim1.other_interrupts());
        exceptions.set_line(29, self.tim3.update_interrupt() || self.tim3.other_interrupts());
        exceptions.set_line(50, self.tim5.update_interrupt() || self.tim5.other_interrupts());
        exceptions.set_line(35, self.spi1.interrupt());
        exceptions.set_line(38, self.usart2.interrupt());
    }

    /// The supply of chip and board.
    pub(crate) fn set_supply_v(&mut self, supply_v: f32) {
        self.pwr.set_supply_v(supply_v);
        self.refresh_lines();
    }

    /// TELEM1's other end sends.
    pub(crate) fn telem1_sends(&mut self, bytes: &[u8]) {
        if self.ports[D].alternate_function(6) == Some(7) {
            self.usart2.line_receives(bytes, self.now);
        }
    }

    /// What TELEM1's other end received.
    pub(crate) fn telem1_received(&mut self) -> Vec<u8> {
        let sent = self.usart2.take_sent();
        if self.ports[D].alternate_function(5) == Some(7) { sent } else { Vec::new() }
    }

    fn refuse(&mut self, cause: Cause, address: u32, value: Option<u32>, pc: u32) {
        // the first is the cause, the rest may follow from it
        self.stop.get_or_insert(Stop { cause, address, value, pc });
    }

    /// The peripheral at an address, the gate of its clock, its first address.
    fn at(&mut self, address: u32) -> Option<(&mut dyn Peripheral, Option<ClockGate>, u32)> {
        let (base, gate): (u32, _) = (address & !0x3ff, |gate| Some(gate));
        let found: (&mut dyn Peripheral, _) = match base {
            0x4000_0400 => (&mut self.tim3, gate(ClockGate::apb1(1))),
            0x4000_0c00 => (&mut self.tim5, gate(ClockGate::apb1(3))),
            0x4000_3000 => (&mut self.iwdg, None),
            0x4000_4400 => (&mut self.usart2, gate(ClockGate::apb1(17))),
            0x4000_7000 => (&mut self.pwr, gate(ClockGate::apb1(28))),
            0x4001_0000 => (&mut self.tim1, gate(ClockGate::apb2(0))),
            0x4001_3000 => (&mut self.spi1, gate(ClockGate::apb2(12))),
            0x4001_3800 => (&mut self.syscfg, gate(ClockGate::apb2(14))),
            0x4001_3c00 => (&mut self.exti, None),
            0x4002_0000..0x4002_2400 => {
                let port = (base - 0x4002_0000) / 0x400;
                (&mut self.ports[port as usize], gate(ClockGate::ahb1(port)))
            }
            0x4002_3800 => (&mut self.rcc, None),
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

    fn read_register(&mut self, address: u32, now: Ticks) -> Result<u32, Cause> {
        let (_, gate, base) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        self.check_clock(gate)?;
        let (peripheral, ..) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        peripheral.read((address & !3) - base, now).map_err(|Unmodelled(what)| Cause::Unmodelled(what))
    }

    fn write_register(&mut self, address: u32, value: u32, now: Ticks) -> Result<(), Cause> {
        let (_, gate, base) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        self.check_clock(gate)?;
        let (peripheral, ..) = self.at(address).ok_or(Cause::Unmodelled("peripheral"))?;
        peripheral.write(address - base, value, now).map_err(|Unmodelled(what)| Cause::Unmodelled(what))?;
        if base == 0x4002_3800 {
            self.distribute_clocks();
            self.reset_peripherals();
        }
        Ok(())
    }

    fn distribute_clocks(&mut self) {
        // RCC takes no setting that has no clocks
        self.clocks = self.rcc.clocks().unwrap_or(self.clocks);
        self.spi1.set_bus_cycle(self.clocks.apb2);
        self.usart2.set_bus_cycle(self.clocks.apb1);
        self.tim1.set_cycle(self.clocks.apb2_timers);
        self.tim3.set_cycle(self.clocks.apb1_timers);
        self.tim5.set_cycle(self.clocks.apb1_timers);
    }

    /// Puts back what RCC holds in reset.
    fn reset_peripherals(&mut self) {
        let held = |gate| self.rcc.is_in_reset(gate);
        for (index, name) in PORTS.into_iter().enumerate() {
            if held(ClockGate::ahb1(index as u32)) {
                self.ports[index] = Gpio::new(name);
            }
        }
        for (index, bit) in [21, 22].into_iter().enumerate() {
            if held(ClockGate::ahb1(bit)) {
                self.dma[index] = Dma::default();
            }
        }
        let (tim1, tim3, tim5) = (ClockGate::apb2(0), ClockGate::apb1(1), ClockGate::apb1(3));
        let resets =
            [tim1, tim3, tim5, ClockGate::apb2(12), ClockGate::apb2(14), ClockGate::apb1(17), ClockGate::apb1(28)]
                .map(held);
        if resets[0] {
            self.tim1 = Timer::advanced()
        }
        if resets[1] {
            self.tim3 = Timer::general(0xffff)
        }
        if resets[2] {
            self.tim5 = Timer::general(u32::MAX)
        }
        if resets[3] {
            self.spi1 = Spi::default()
        }
        if resets[4] {
            self.syscfg = SysCfg::default()
        }
        if resets[5] {
            self.usart2 = Usart::new(TELEM1_BAUD)
        }
        if resets[6] {
            self.pwr = Pwr::default()
        }
        if resets.contains(&true) {
            self.distribute_clocks();
        }
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
}

impl Bus for Board {
    fn load(&mut self, address: u32, size: u32, place: Place) -> u32 {
        let (now, cycles) = self.time_of(place);
        match self.load_at(address, size, now, cycles) {
            Ok(value) => value,
            Err(cause) => {
                self.refuse(cause, address, None, place.pc);
                0
            }
        }
    }

    fn store(&mut self, address: u32, size: u32, value: u32, place: Place) {
        let (now, cycles) = self.time_of(place);
        match self.store_at(address, size, value, now, cycles) {
            Ok(()) => self.refresh_lines(),
            Err(cause) => self.refuse(cause, address, Some(value), place.pc),
        }
    }
}

impl Board {
    fn time_of(&self, place: Place) -> (Ticks, u64) {
        let cycles = place.ran * CYCLES_PER_INSTRUCTION;
        (self.now + cycles * self.clocks.core, self.cycles + cycles)
    }
}
