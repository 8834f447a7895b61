//! USART2 and USART3, which are the connectors TELEM1 and TELEM2, and what is plugged into them.

use super::wiring::{USART2_DMA, USART3_DMA};
use super::{Board, D};
use crate::memory::Memory;
use crate::peripherals::Peripheral;
use crate::peripherals::usart::Usart;
use crate::time::Ticks;

/// Both connectors' usual baud rate.
pub(super) const USUAL_BAUD: u64 = 57_600;
/// Transmitter and receiver on port D, alternate function 7.
const TELEM1_PINS: [u32; 2] = [5, 6];
const TELEM2_PINS: [u32; 2] = [8, 9];
const USART_FUNCTION: Option<u32> = Some(7);

/// A connector for a radio or a computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connector {
    /// USART2.
    Telem1,
    /// USART3.
    Telem2,
}

impl Board {
    pub(super) fn tick_serial(&mut self, now: Ticks, memory: &mut dyn Memory) {
        self.move_items(&USART2_DMA, memory);
        while self.usart2.next_event().is_some_and(|at| at <= now) {
            self.usart2.tick(now);
            self.move_items(&USART2_DMA, memory);
        }
        self.move_items(&USART3_DMA, memory);
        while self.usart3.next_event().is_some_and(|at| at <= now) {
            self.usart3.tick(now);
            self.move_items(&USART3_DMA, memory);
        }
    }

    fn is_wired(&self, pin: u32) -> bool {
        self.ports[D].alternate_function(pin) == USART_FUNCTION
    }

    pub(crate) fn usart(&mut self, connector: Connector) -> &mut Usart {
        match connector {
            Connector::Telem1 => &mut self.usart2,
            Connector::Telem2 => &mut self.usart3,
        }
    }

    /// The far end sends.
    pub(crate) fn line_sends(&mut self, connector: Connector, bytes: &[u8]) {
        let [_, receiver] = pins(connector);
        if self.is_wired(receiver) {
            let now = self.now;
            self.usart(connector).line_receives(bytes, now);
        }
    }

    /// What the far end received.
    pub(crate) fn line_received(&mut self, connector: Connector) -> Vec<u8> {
        let sent = self.usart(connector).take_sent();
        let [transmitter, _] = pins(connector);
        if self.is_wired(transmitter) { sent } else { Vec::new() }
    }
}

fn pins(connector: Connector) -> [u32; 2] {
    match connector {
        Connector::Telem1 => TELEM1_PINS,
        Connector::Telem2 => TELEM2_PINS,
    }
}
