//! The supply detector: below 2.9 V the core cannot be trusted for long, the motors must stop before that.

use stm32f4xx_hal::pac::{EXTI, PWR};
use stm32f4xx_hal::rcc::{Enable, Rcc};

use super::clock;

/// Line of the detector (RM 12.2.5).
const LINE: u8 = 16;

/// The detector with its interrupt `PVD`.
pub struct SupplyDetector<'a> {
    power: &'a PWR,
    exti: &'a EXTI,
}

impl<'a> SupplyDetector<'a> {
    /// Raises the interrupt from now on when the supply falls below the threshold.
    pub fn new(power: &'a PWR, exti: &'a EXTI, rcc: &mut Rcc) -> Self {
        PWR::enable(rcc);
        // level 7: 2.9 V
        power.cr().modify(|_, w| w.pls().set(7).pvde().set_bit());
        // it takes a moment to settle; the data sheet gives no time, the reference voltage beside it 10 us
        clock::wait_us(50);
        exti.rtsr().modify(|_, w| w.tr(LINE).set_bit());
        exti.imr().modify(|_, w| w.mr(LINE).set_bit());
        Self { power, exti }
    }

    /// True if the supply is low. The interrupt shows its fall only: one that is low from the start causes none.
    pub fn is_low(&self) -> bool {
        self.power.csr().read().pvdo().bit_is_set()
    }

    /// Forgets falls so far. True if the supply is good after that; one that falls later raises the interrupt.
    pub fn forget(&self) -> bool {
        self.exti.pr().write(|w| w.pr(LINE).clear());
        cortex_m::peripheral::NVIC::unpend(stm32f4xx_hal::pac::Interrupt::PVD);
        !self.is_low()
    }
}
