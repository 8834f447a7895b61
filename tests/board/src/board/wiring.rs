//! Wires inside the chip and to its pins: timers to motors, DMA requests, interrupt lines.

use super::{Board, E};
use crate::cortex::exceptions::{NMI, interrupt_line, line};
use crate::memory::{self, Memory};
use crate::peripherals::Peripheral;
use crate::peripherals::dma::Item;
use crate::time::Ticks;

/// Pins of the motor channels, TIM1 CH1 to CH4.
pub(super) const MOTOR_PINS: [u32; 4] = [9, 11, 13, 14];
/// TIM1's trigger input that is TIM3 (RM0090 table 93).
const TIM1_FROM_TIM3: u32 = 2;
/// The voltage detector's line of EXTI (section 12.2.5).
const SUPPLY_LINE: u32 = 16;

/// Who asks a DMA stream for an item: controller (0 is DMA1), stream, channel (RM0090 tables 42 and 43).
#[derive(Clone, Copy)]
pub(super) struct DmaWire {
    controller: usize,
    stream: usize,
    channel: u32,
    to_peripheral: bool,
    asks: fn(&Board) -> bool,
}

impl DmaWire {
    const fn new(
        controller: usize,
        stream: usize,
        channel: u32,
        to_peripheral: bool,
        asks: fn(&Board) -> bool,
    ) -> Self {
        Self { controller, stream, channel, to_peripheral, asks }
    }
}

pub(super) const SPI1_DMA: [DmaWire; 2] = [
    DmaWire::new(1, 0, 3, false, |board| board.spi1.requests_receive_dma()),
    DmaWire::new(1, 5, 3, true, |board| board.spi1.requests_transmit_dma()),
];
pub(super) const USART2_DMA: [DmaWire; 2] = [
    DmaWire::new(0, 5, 4, false, |board| board.usart2.requests_receive_dma()),
    DmaWire::new(0, 6, 4, true, |board| board.usart2.requests_transmit_dma()),
];
pub(super) const USART3_DMA: [DmaWire; 3] = [
    DmaWire::new(0, 1, 4, false, |board| board.usart3.requests_receive_dma()),
    DmaWire::new(0, 3, 4, true, |board| board.usart3.requests_transmit_dma()),
    DmaWire::new(0, 4, 7, true, |board| board.usart3.requests_transmit_dma()),
];
pub(super) const ADC1_DMA: [DmaWire; 1] = [DmaWire::new(1, 4, 0, false, |board| board.adc1.requests_dma())];

pub(super) const USART6_DMA: [DmaWire; 4] = [
    DmaWire::new(1, 1, 5, false, |board| board.usart6.requests_receive_dma()),
    DmaWire::new(1, 2, 5, false, |board| board.usart6.requests_receive_dma()),
    DmaWire::new(1, 6, 5, true, |board| board.usart6.requests_transmit_dma()),
    DmaWire::new(1, 7, 5, true, |board| board.usart6.requests_transmit_dma()),
];

pub(super) const SDIO_DMA: [DmaWire; 4] = [
    DmaWire::new(1, 3, 4, false, |board| board.sdio.requests_receive_dma()),
    DmaWire::new(1, 6, 4, false, |board| board.sdio.requests_receive_dma()),
    DmaWire::new(1, 3, 4, true, |board| board.sdio.requests_transmit_dma()),
    DmaWire::new(1, 6, 4, true, |board| board.sdio.requests_transmit_dma()),
];

/// Interrupts of the streams (RM0090 table 62).
const DMA1_INTERRUPTS: [u8; 8] = [11, 12, 13, 14, 15, 16, 17, 47];
const DMA2_INTERRUPTS: [u8; 8] = [56, 57, 58, 59, 60, 68, 69, 70];

impl Board {
    pub(super) fn tick_motor_timers(&mut self, now: Ticks) {
        self.tim3.tick(now);
        for at in self.tim3.take_triggers() {
            self.world.loop_tick(at);
            if self.tim1.trigger_input() == Some(TIM1_FROM_TIM3) {
                self.tim1.trigger(at);
            }
        }
        self.tim1.tick(now);
        self.pass_on_pulses();
    }

    /// To the ESCs, from channels whose pin is the timer's.
    pub(super) fn pass_on_pulses(&mut self) {
        for pulse in self.tim1.take_pulses() {
            if self.ports[E].alternate_function(MOTOR_PINS[pulse.channel]) == Some(1) {
                self.world.pulse(pulse);
            }
        }
    }

    /// Moves items for as long as a peripheral asks and a stream serves it.
    pub(super) fn move_items(&mut self, wires: &[DmaWire], memory: &mut dyn Memory) {
        for wire in wires {
            while (wire.asks)(self) {
                let DmaWire { controller, stream, channel, to_peripheral, .. } = *wire;
                let Some(item) = self.dma[controller].item(stream, channel, to_peripheral) else { break };
                if self.move_item(item, to_peripheral, memory) {
                    self.dma[controller].moved(stream);
                } else {
                    self.dma[controller].failed(stream);
                }
            }
        }
    }

    /// False if nothing that DMA reaches lies there: neither CCM nor, to be written, flash.
    fn move_item(&mut self, item: Item, to_peripheral: bool, memory: &mut dyn Memory) -> bool {
        let Item { memory_address, peripheral_address, size } = item;
        let reaches =
            memory::RAM.contains(memory_address, size) || to_peripheral && memory::FLASH.contains(memory_address, size);
        let mut bytes = [0; 4];
        if !reaches {
            return false;
        }
        if to_peripheral {
            memory.load(memory_address, &mut bytes[..size as usize])
                && self.write_register(peripheral_address, u32::from_le_bytes(bytes), self.now).is_ok()
        } else {
            self.read_register(peripheral_address, self.now)
                .is_ok_and(|word| memory.store(memory_address, &word.to_le_bytes()[..size as usize]))
        }
    }

    /// Levels that follow from others: pins, EXTI lines, interrupt lines.
    pub(crate) fn refresh_lines(&mut self, now: Ticks) {
        self.refresh_rail(now);
        self.refresh_selects(now);
        self.refresh_sensors();
        self.refresh_aux(now);
        self.exti.set_levels(self.exti_levels());
        let lines = self.interrupt_lines();
        self.private.exceptions.set_lines(lines);
    }

    fn exti_levels(&self) -> u32 {
        let mut levels = u32::from(self.pwr.supply_low()) << SUPPLY_LINE;
        // only a line of which an edge is selected is worth looking at
        for line in (0..16).filter(|line| self.exti.selected() >> line & 1 != 0) {
            let port = self.syscfg.port_of_line(line) as usize;
            levels |= u32::from(self.ports.get(port).is_some_and(|port| port.level(line))) << line;
        }
        levels
    }

    /// Which interrupts are requested (RM0090 table 62).
    fn interrupt_lines(&self) -> u128 {
        let mut lines = line(NMI, self.rcc.crystal_lost());
        for (exti_lines, interrupt) in
            [(1 << 16, 1), (1, 6), (1 << 1, 7), (1 << 2, 8), (1 << 3, 9), (1 << 4, 10), (0x03e0, 23), (0xfc00, 40)]
        {
            lines |= interrupt_line(interrupt, self.exti.requests(exti_lines));
        }
        for (dma, interrupts) in self.dma.iter().zip([DMA1_INTERRUPTS, DMA2_INTERRUPTS]) {
            for (stream, interrupt) in interrupts.into_iter().enumerate() {
                lines |= interrupt_line(interrupt, dma.interrupt(stream));
            }
        }
        lines
            | interrupt_line(28, self.tim2.interrupt())
            | interrupt_line(25, self.tim1.update_interrupt())
            | interrupt_line(27, self.tim1.other_interrupts())
            | interrupt_line(29, self.tim3.interrupt())
            | interrupt_line(49, self.sdio.interrupt())
            | interrupt_line(50, self.tim5.interrupt())
            | interrupt_line(35, self.spi1.interrupt())
            | interrupt_line(36, self.spi2.interrupt())
            | interrupt_line(38, self.usart2.interrupt())
            | interrupt_line(39, self.usart3.interrupt())
            | interrupt_line(67, self.otg_fs.interrupt())
            | interrupt_line(71, self.usart6.interrupt())
    }
}
