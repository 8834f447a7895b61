//! The battery at ADC1, and the buzzer at TIM2.

use super::wiring::ADC1_DMA;
use super::{A, Board};
use crate::memory::Memory;
use crate::stop::Cause;
use crate::time::Ticks;

/// Channel and pin of port A behind the power module's divider.
const BATTERY_CHANNEL: u32 = 2;
const BATTERY_PIN: u32 = 2;
/// ArduPilot's value for the 3DR power module.
const DIVIDER: f32 = 10.1;
const REFERENCE_V: f32 = 3.3;
const COUNTS: f32 = 4096.0;
/// Three cells, nearly full.
pub(super) const USUAL_BATTERY_V: f32 = 12.4;

const BUZZER_PIN: u32 = 15;
/// PA15's function that is TIM2 channel 1.
const BUZZER_FUNCTION: Option<u32> = Some(1);

impl Board {
    /// The battery's voltage from now on.
    pub(crate) fn set_battery_v(&mut self, battery_v: f32) {
        self.battery_v = battery_v;
    }

    pub(super) fn tick_adc1(&mut self, now: Ticks, memory: &mut dyn Memory) {
        while let Some(channel) = self.adc1.converted(now) {
            if channel != BATTERY_CHANNEL || !self.ports[A].is_analog(BATTERY_PIN) {
                self.refuse(
                    Cause::Unmodelled("ADC1 channel without anything on its pin, or a pin that is not analog"),
                    0,
                    None,
                );
            }
            // `as` holds at 0, the converter at its largest count
            let counts = (self.battery_v / DIVIDER / REFERENCE_V * COUNTS) as u16;
            self.adc1.result(counts.min(0xfff));
            self.move_items(&ADC1_DMA, memory);
        }
    }

    /// Pitch of the buzzer; none if it is silent.
    pub(crate) fn buzzer_hz(&self) -> Option<f64> {
        self.tim2.wave_hz(0).filter(|_| self.ports[A].alternate_function(BUZZER_PIN) == BUZZER_FUNCTION)
    }
}
