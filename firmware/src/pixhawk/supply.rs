//! The supply detector: below 2.9 V the core cannot be trusted for long, the motors must stop before that.

use stm32f4xx_hal::pac::{EXTI, PWR};
use stm32f4xx_hal::rcc::{Enable, Rcc};

/// Line of the detector (RM 12.2.5).
const LINE: u8 = 16;

/// Raises the interrupt `PVD` when the supply falls below the threshold.
pub fn watch(power: &PWR, exti: &EXTI, rcc: &mut Rcc) {
    PWR::enable(rcc);
    // level 7: 2.9 V
    power.cr().modify(|_, w| w.pls().set(7).pvde().set_bit());
    exti.rtsr().modify(|_, w| w.tr(LINE).set_bit());
    exti.imr().modify(|_, w| w.mr(LINE).set_bit());
}
