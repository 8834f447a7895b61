//! Wires inside the chip and to its pins: timers to motors, DMA requests, interrupt lines.

use super::{Board, D, E};
use crate::cortex::exceptions::interrupt_line;
use crate::memory::{self, Memory};
use crate::peripherals::Peripheral;
use crate::time::Ticks;

/// Pins of the motor channels, TIM1 CH1 to CH4.
const MOTOR_PINS: [u32; 4] = [9, 11, 13, 14];
/// TIM1's trigger input that is TIM3 (RM0090 table 93).
const TIM1_FROM_TIM3: u32 = 2;
/// The voltage detector's line of EXTI (section 12.2.5).
const SUPPLY_LINE: u32 = 16;

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
        for pulse in self.tim1.take_pulses() {
            if self.ports[E].alternate_function(MOTOR_PINS[pulse.channel]) == Some(1) {
                self.world.pulse(pulse);
            }
        }
    }

    /// Moves items for as long as a peripheral asks and a stream serves it.
    pub(super) fn move_items(&mut self, memory: &mut dyn Memory) {
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
        self.refresh_devices();
        self.ports[D].drive(15, self.mpu6000.interrupt_pin());
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

    /// Which interrupts are asked for (RM0090 table 62).
    fn interrupt_lines(&self) -> u128 {
        let mut lines = 0;
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
            | interrupt_line(25, self.tim1.update_interrupt())
            | interrupt_line(27, self.tim1.other_interrupts())
            | interrupt_line(29, self.tim3.interrupt())
            | interrupt_line(50, self.tim5.interrupt())
            | interrupt_line(35, self.spi1.interrupt())
            | interrupt_line(36, self.spi2.interrupt())
            | interrupt_line(38, self.usart2.interrupt())
    }
}
