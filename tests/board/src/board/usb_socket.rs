//! OTG_FS's pins and the computer at the connector.

use super::{A, Board, C};
use crate::peripherals::Unmodelled;
use crate::peripherals::rcc::ClockGate;
use crate::stop::Cause;
use crate::time::Ticks;

/// Data lines, both alternate function 10.
const DATA: [u32; 2] = [11, 12];
const USB_FUNCTION: Option<u32> = Some(10);
/// On port A the connector's 5 V, on port C the power switch's word for them: low is valid.
const VBUS: u32 = 9;
const NOT_VALID: u32 = 0;

impl Board {
    pub(super) fn tick_usb(&mut self, now: Ticks) {
        let powered = self.usb.is_plugged();
        self.ports[A].put(VBUS, powered);
        self.ports[C].put(NOT_VALID, !powered);
        let clocked = self.rcc.is_clocked(ClockGate::ahb2(7));
        let wired = clocked && DATA.iter().all(|pin| self.ports[A].alternate_function(*pin) == USB_FUNCTION);
        // a pin that is an output, or another peripheral's, says nothing about the connector
        let sensed = self.ports[A].output_level(VBUS).is_none() && self.ports[A].alternate_function(VBUS).is_none();
        self.otg_fs.set_connector(powered && sensed, wired);
        if let Err(Unmodelled(what)) = self.usb.tick(&mut self.otg_fs, now) {
            self.refuse(Cause::Unmodelled(what), 0, None);
        }
    }
}
