//! The board's one clock: ticks of 336 MHz, which every clock of the board divides.
//!
//! HSI 16 MHz is 21 ticks a cycle, HSE 24 MHz 14, HCLK 168 MHz 2, APB1 42 MHz 8: no rounding anywhere.

/// A point in time, or a duration, in 1/336 us.
pub type Ticks = u64;

/// Ticks in a microsecond.
pub const TICKS_PER_US: Ticks = 336;
/// Ticks in a second.
pub const TICKS_PER_S: Ticks = 336_000_000;

/// Seconds.
pub fn seconds(ticks: Ticks) -> f64 {
    ticks as f64 / TICKS_PER_S as f64
}
