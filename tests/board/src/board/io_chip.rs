//! USART6 and the IO chip at its other end.

use super::wiring::USART6_DMA;
use super::{Board, C};
use crate::memory::Memory;
use crate::peripherals::Peripheral;
use crate::time::Ticks;

/// Transmitter and receiver on port C, alternate function 8.
const TRANSMITTER: u32 = 6;
const RECEIVER: u32 = 7;
const USART6_FUNCTION: Option<u32> = Some(8);

impl Board {
    pub(super) fn tick_io(&mut self, now: Ticks, memory: &mut dyn Memory) {
        self.move_items(&USART6_DMA, memory);
        while self.usart6.next_event().is_some_and(|at| at <= now) {
            self.usart6.tick(now);
            self.move_items(&USART6_DMA, memory);
        }
        let sent = self.usart6.take_sent();
        if !sent.is_empty() && self.ports[C].alternate_function(TRANSMITTER) == USART6_FUNCTION {
            self.io.receive(&sent, now);
        }
        if let Some(reply) = self.io.tick(now)
            && self.ports[C].alternate_function(RECEIVER) == USART6_FUNCTION
        {
            self.usart6.line_receives(&reply, now);
        }
        if let Some(rule) = self.io.take_broken() {
            self.break_rule(rule, now);
        }
    }
}
