//! Clock tree and time base: TIM5 counts microseconds, and one owner extends them to 64 bits.

use stm32f4xx_hal::pac::{DBGMCU, RCC, TIM5};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Enable, Rcc, Reset};

use super::board;

/// Looks at the crystal's ready flag, each at least 5 cycles of 62.5 ns long: a tenth of a second at least. The data
/// sheet gives 2 ms for the start of a usual crystal.
const CRYSTAL_LOOKS: u32 = 400_000;

/// The internal oscillator, Hz.
pub const INTERNAL_HZ: u32 = 16_000_000;

/// Starts the crystal, on the internal oscillator. False if it stays silent; the HAL would wait for ever.
pub fn crystal_starts(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    (0..CRYSTAL_LOOKS).any(|_| rcc.cr().read().hserdy().bit_is_set())
}

/// The internal oscillator, 16 MHz, for a board that can do no more than say so.
pub fn start_without_crystal(rcc: RCC) -> Rcc {
    rcc.freeze(Config::hsi())
}

/// 168 MHz from the crystal; if the crystal fails later, the processor raises NMI. Flash has its prefetch, which the
/// HAL switches on: only revision A of the STM32F405 and F407 is without (ES0182), not this chip (ES0206).
pub fn start(rcc: RCC) -> Rcc {
    let config = Config::hse(board::CRYSTAL_HZ.Hz())
        .sysclk(board::CORE_HZ.Hz())
        .pclk1(board::APB1_HZ.Hz())
        .pclk2(board::APB2_HZ.Hz())
        // the SD card's
        .require_pll48clk();
    let rcc = rcc.freeze(config);
    rcc.cr().modify(|_, w| w.csson().set_bit());
    rcc
}

/// While a probe halts the core, the loop, the pulses and the watchdog stand still.
pub fn freeze_on_halt(debug: &DBGMCU) {
    debug.apb2_fz().modify(|_, w| w.dbg_tim1_stop().set_bit());
    debug.apb1_fz().modify(|_, w| w.dbg_tim3_stop().set_bit().dbg_tim5_stop().set_bit().dbg_iwdg_stop().set_bit());
}

/// Starts TIM5 at 1 MHz over its whole 32 bits.
pub fn start_microseconds(tim: &TIM5, rcc: &mut Rcc) {
    TIM5::enable(rcc);
    TIM5::reset(rcc);
    tim.psc().write(|w| w.psc().set((board::APB1_TIMER_HZ / 1_000_000 - 1) as u16));
    tim.arr().write(|w| w.arr().set(u32::MAX));
    // the prescaler takes effect with an update
    tim.egr().write(|w| w.ug().set_bit());
    tim.cr1().write(|w| w.cen().set_bit());
}

/// The counter, µs; it wraps after 71 minutes.
#[allow(unsafe_code)] // reads a counter that nobody writes after start-up
pub fn now_us() -> u32 {
    // SAFETY: a read without side effects
    unsafe { (*TIM5::ptr()).cnt().read().bits() }
}

/// `asm::delay` counts its argument down, one subtraction and one taken branch a turn: at least so many cycles on a
/// Cortex-M4 (technical reference manual, table 3-1: 1 + 1 + P, P from 1 to 3).
const CYCLES_PER_TURN: u32 = 3;

/// Waits, at least so long and half as long again at most; for start-up, restarts and a microsecond now and then.
pub fn wait_us(duration_us: u32) {
    cortex_m::asm::delay(duration_us * (board::CORE_HZ / 1_000_000 / CYCLES_PER_TURN));
}

/// Waits, at least so long, while the core runs at this clock; for start-up alone.
pub fn wait_tenth_of_a_second(core_hz: u32) {
    cortex_m::asm::delay(core_hz / 10 / CYCLES_PER_TURN);
}

/// Time that does not wrap; it must be read at least once in 71 minutes.
pub struct TimeBase {
    now_us: u64,
}

impl TimeBase {
    /// Before it is read first.
    pub const START: Self = Self { now_us: 0 };

    /// The time now, µs since TIM5 started.
    pub fn now_us(&mut self) -> u64 {
        let passed_us = now_us().wrapping_sub(self.now_us as u32);
        self.now_us = self.now_us.wrapping_add(u64::from(passed_us));
        self.now_us
    }

    /// The time of a counter value from about now.
    pub fn extend(&self, counter_us: u32) -> u64 {
        let ahead_us = counter_us.wrapping_sub(self.now_us as u32).cast_signed();
        self.now_us.wrapping_add_signed(i64::from(ahead_us))
    }
}
