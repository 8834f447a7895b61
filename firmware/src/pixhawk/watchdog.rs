//! The independent watchdog, fed in one place and only when every periodic task has reported.

use core::sync::atomic::{AtomicBool, Ordering};

use stm32f4xx_hal::pac::IWDG;

/// 20 ms at the fastest LSI (47 kHz / 4), hence 55 ms at the slowest (17 kHz / 4).
const RELOAD: u16 = (20 * 47_000 / 4 / 1000 - 1) as u16;

static LOOP_ALIVE: AtomicBool = AtomicBool::new(false);

/// The loop has made a step.
pub fn report_loop() {
    LOOP_ALIVE.store(true, Ordering::Relaxed);
}

/// The watchdog; it cannot be stopped once it runs.
pub struct Watchdog {
    iwdg: IWDG,
}

impl Watchdog {
    /// Starts it.
    pub fn start(iwdg: IWDG) -> Self {
        iwdg.kr().write(|w| w.key().start());
        iwdg.kr().write(|w| w.key().unlock());
        iwdg.pr().write(|w| w.pr().divide_by4());
        iwdg.rlr().write(|w| w.rl().set(RELOAD));
        // the registers live in another clock domain
        while iwdg.sr().read().rvu().bit_is_set() || iwdg.sr().read().pvu().bit_is_set() {}
        iwdg.kr().write(|w| w.key().feed());
        Self { iwdg }
    }

    /// To be called by the periodic task of lowest priority, which so reports itself.
    pub fn feed_if_all_alive(&mut self) {
        if LOOP_ALIVE.swap(false, Ordering::Relaxed) {
            self.iwdg.kr().write(|w| w.key().feed());
        }
    }
}
