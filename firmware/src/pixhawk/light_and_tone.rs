//! The amber LED plays what `shared_control::signs` says of the state.

use shared_control::signs::{SLOTS, Sign};
use stm32f4xx_hal::gpio::{OpenDrain, Output, PE12};

use super::clock;

/// What tells a person.
pub struct Pins {
    /// Amber LED, low active.
    pub led: PE12<Output<OpenDrain>>,
}

/// Player.
pub struct LightAndTone {
    pins: Pins,
    sign: Option<Sign>,
    /// Tenths of a second since the sign came up.
    tenths: u32,
}

impl LightAndTone {
    /// Dark.
    pub fn new(pins: Pins) -> Self {
        Self { pins, sign: None, tenths: 0 }
    }

    /// To be called ten times a second. A sign that stays goes on where it was.
    pub fn update(&mut self, sign: Sign) {
        self.tenths = if self.sign == Some(sign) { self.tenths.saturating_add(1) } else { 0 };
        self.sign = Some(sign);
        self.pins.light(sign.light().is_on((self.tenths % u32::from(SLOTS)) as u8));
    }
}

impl Pins {
    fn light(&mut self, on: bool) {
        if on { self.led.set_low() } else { self.led.set_high() }
    }

    /// Shows a sign for as long as `goes_on` says, asked ten times a second; before there are tasks, and without a tone.
    pub fn show_while(&mut self, sign: Sign, core_hz: u32, mut goes_on: impl FnMut() -> bool) {
        let mut slot = 0;
        while goes_on() {
            self.light(sign.light().is_on(slot));
            slot = (slot + 1) % SLOTS;
            clock::wait_tenth_of_a_second(core_hz);
        }
        self.light(false);
    }
}
