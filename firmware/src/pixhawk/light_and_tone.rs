//! The amber LED and the buzzer play what `shared_control::light_and_tone` says of the state: TIM2 channel 1 makes the
//! tone.

use shared_control::light_and_tone::{SLOTS, Sign};
use stm32f4xx_hal::gpio::{Alternate, OpenDrain, Output, PA15, PE12};
use stm32f4xx_hal::pac::TIM2;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::{board, clock};

/// LED, low active, and buzzer.
pub struct Pins {
    /// Amber LED.
    pub led: PE12<Output<OpenDrain>>,
    /// Buzzer.
    pub _buzzer: PA15<Alternate<1>>,
}

/// Tone generator's clock, Hz.
const TONE_CLOCK_HZ: u32 = 1_000_000;

/// Player of both.
pub struct LightAndTone {
    pins: Pins,
    tim: TIM2,
    sign: Option<Sign>,
    /// Tenths of a second since the sign came up.
    tenths: u32,
}

impl LightAndTone {
    /// Dark and silent.
    pub fn new(tim: TIM2, pins: Pins, rcc: &mut Rcc) -> Self {
        TIM2::enable(rcc);
        TIM2::reset(rcc);
        tim.psc().write(|w| w.psc().set((board::APB1_TIMER_HZ / TONE_CLOCK_HZ - 1) as u16));
        tim.ccmr1_output().write(|w| w.oc1m().pwm_mode1().oc1pe().set_bit());
        tim.ccer().write(|w| w.cc1e().set_bit());
        tim.arr().write(|w| w.arr().set(TONE_CLOCK_HZ));
        tim.egr().write(|w| w.ug().set_bit());
        tim.cr1().write(|w| w.arpe().set_bit().cen().set_bit());
        Self { pins, tim, sign: None, tenths: 0 }
    }

    /// To be called ten times a second. A sign that stays goes on where it was.
    pub fn update(&mut self, sign: Sign) {
        self.tenths = if self.sign == Some(sign) { self.tenths.saturating_add(1) } else { 0 };
        self.sign = Some(sign);
        self.pins.light(sign.light().is_on((self.tenths % u32::from(SLOTS)) as u8));
        let tone = sign.tone();
        let pitch_hz = if tone.sounds(self.tenths) { tone.pitch_hz } else { 0 };
        self.tone(pitch_hz.into());
    }

    /// A square wave; of zero, silence with the pin low.
    fn tone(&self, pitch_hz: u32) {
        let period = TONE_CLOCK_HZ.checked_div(pitch_hz);
        self.tim.ccr1().write(|w| w.ccr().set(period.unwrap_or(0) / 2));
        self.tim.arr().write(|w| w.arr().set(period.unwrap_or(1000) - 1));
        // what is preloaded takes effect at once: a period of silence may be long
        self.tim.egr().write(|w| w.ug().set_bit());
    }
}

impl Pins {
    fn light(&mut self, on: bool) {
        if on { self.led.set_low() } else { self.led.set_high() }
    }

    /// Shows a sign for as long as `goes_on` says, asked ten times a second; before there are tasks, and without a
    /// tone.
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
