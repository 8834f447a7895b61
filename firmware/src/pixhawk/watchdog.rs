//! The independent watchdog, fed in one place and only when every periodic task has reported; and while a restart on
//! purpose waits, with the motor outputs held low.
#![allow(unsafe_code)] // the restart feeds it whoever owns it

use core::sync::atomic::{AtomicBool, Ordering};

use stm32f4xx_hal::pac::IWDG;

/// 20 ms at the fastest LSI (47 kHz / 4), hence 55 ms at the slowest (17 kHz / 4).
const RELOAD: u16 = (20 * 47_000 / 4 / 1000 - 1) as u16;

static LOOP_ALIVE: AtomicBool = AtomicBool::new(false);
static PLAN_EXPECTED: AtomicBool = AtomicBool::new(false);
static PLAN_MADE: AtomicBool = AtomicBool::new(false);

/// Looks in a row at which no plan had been made although one was expected; a plan may take longer than from one look
/// to the next, which makes it late, but no reason to stop.
const LOOKS_WITHOUT_PLAN_MAX: u8 = 2;

/// The loop has made its step, or seen that none is due.
pub fn report_loop() {
    LOOP_ALIVE.store(true, Ordering::Relaxed);
}

/// The loop has requested a plan.
pub fn expect_plan() {
    PLAN_EXPECTED.store(true, Ordering::Relaxed);
}

/// A plan has been made.
pub fn report_plan() {
    PLAN_MADE.store(true, Ordering::Relaxed);
}

/// For a restart that takes longer than the watchdog waits; there is no task left that could report.
pub fn feed_before_restart() {
    // SAFETY: a register that takes keys and holds nothing
    unsafe { (*IWDG::ptr()).kr().write(|w| w.key().feed()) };
}

/// The watchdog; it cannot be stopped once it runs.
pub struct Watchdog {
    iwdg: IWDG,
    looks_without_plan: u8,
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
        Self { iwdg, looks_without_plan: 0 }
    }

    /// To be called by the periodic task of lowest priority, which so reports itself.
    pub fn feed_if_all_alive(&mut self) {
        let expected = PLAN_EXPECTED.swap(false, Ordering::Relaxed);
        let missing = expected & !PLAN_MADE.swap(false, Ordering::Relaxed);
        self.looks_without_plan = if missing { self.looks_without_plan.saturating_add(1) } else { 0 };
        let planner_alive = self.looks_without_plan < LOOKS_WITHOUT_PLAN_MAX;
        if LOOP_ALIVE.swap(false, Ordering::Relaxed) && planner_alive {
            self.iwdg.kr().write(|w| w.key().feed());
        }
    }
}
