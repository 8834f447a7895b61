//! Constants of the Pixhawk 1 (FMUv2, STM32F427VI). RM is the reference manual RM0090.

use shared_control::output::{LOOP_TIMER_HZ, PULSE_TIMER_HZ};

/// Crystal, Hz.
pub const CRYSTAL_HZ: u32 = 24_000_000;
/// Core clock, Hz: the fastest without over-drive.
pub const CORE_HZ: u32 = 168_000_000;
/// APB1, Hz: at most 45 MHz, so the core clock divided by 4.
pub const APB1_HZ: u32 = CORE_HZ / 4;
/// APB2, Hz: at most 90 MHz, so the core clock divided by 2.
pub const APB2_HZ: u32 = CORE_HZ / 2;
/// Timers on APB1 (TIM3, TIM5) count at twice the bus clock, since the bus clock is divided (RM 7.2).
pub const APB1_TIMER_HZ: u32 = 2 * APB1_HZ;
/// Timers on APB2 (TIM1) likewise.
pub const APB2_TIMER_HZ: u32 = 2 * APB2_HZ;

// the core's timer arithmetic counts on these clocks
const _: () = assert!(APB1_TIMER_HZ == LOOP_TIMER_HZ && APB2_TIMER_HZ == PULSE_TIMER_HZ);

/// Times a second that the slow things are looked at.
pub const HOUSEKEEPING_HZ: u16 = 100;

/// A pulse starts this long after the tick of the loop that computed it, us, and again with every later period of the
/// pulses. `fast` must be done by then (its budget of 60,000 cycles is 357 us), or its result waits for the pulse after
/// it. Where the rates of loop and pulses are no multiples of each other, this is the delay of the first pulse only.
pub const PULSE_DELAY_US: u32 = 500;

/// Sensor supply: off for at least this long, or the sensors do not restart, ms. The rail's bleed of 220 Ohm takes
/// 25 ms for 50 uF down to a tenth.
pub const SENSOR_OFF_MS: u32 = 60;
/// Sensor supply: it has risen this long after it is on, us (PX4 waits as long).
pub const SENSOR_RISE_US: u32 = 100;
/// Sensor supply: first register access this long after it is on, ms (MPU6000 data sheet: 100 ms at most).
pub const SENSOR_START_MS: u32 = 120;

/// TELEM1 with hardware in the loop: 400 steps a second are 300 kbit/s there and 372 back.
pub const HIL_BAUD: u32 = 921_600;
