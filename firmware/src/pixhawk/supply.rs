//! The supply detector: below 2.9 V the core cannot be trusted for long, the motors must stop before that.
//!
//! The detector has no filter of its own (RM 5.2.2): what it says must last.
#![allow(unsafe_code)] // its interrupt looks at registers that nobody owns after start-up

use stm32f4xx_hal::pac::{EXTI, PWR};
use stm32f4xx_hal::rcc::{Enable, Rcc};

use super::clock;

/// Line of the detector (RM 12.2.5).
const LINE: u8 = 16;

/// A supply that is low for so long is failing, us. It falls by 0.1 V in a millisecond if the capacitors of the board,
/// some 500 uF at 5 V, feed it alone: it is above the core's 1.8 V by far.
const LOW_US: u32 = 50;
/// Looks of a few cycles each that end the wait if the clock should stand still.
const LOOKS_MAX: u32 = 20_000;

/// In the detector's interrupt: is the supply failing? Not if it was good again within [`LOW_US`].
pub fn stays_low() -> bool {
    // SAFETY: reads of a register without side effects
    let is_low = || unsafe { (*PWR::ptr()).csr().read().pvdo().bit_is_set() };
    let since_us = clock::now_us();
    for _ in 0..LOOKS_MAX {
        if !is_low() {
            // SAFETY: clears one pending bit, and no other: those that are written 0 stay
            unsafe { (*EXTI::ptr()).pr().write(|w| w.pr(LINE).clear()) };
            return false;
        }
        if clock::now_us().wrapping_sub(since_us) > LOW_US {
            break;
        }
    }
    true
}

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
