//! Constants of the Pixhawk 1 (FMUv2, STM32F427VI) and of what is compiled in for now. RM is the reference manual RM0090.

use shared_control::config::Controller;

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

/// Steps of the fast loop per second.
pub const LOOP_RATE_HZ: u32 = 400;
/// Samples of the IMU per second.
pub const IMU_RATE_HZ: u32 = 1000;
/// Pulses per second and motor. Equal to the loop's rate or a multiple of it, or the delay from sample to pulse jitters.
pub const PULSE_RATE_HZ: u32 = 400;
/// Who flies.
pub const CONTROLLER: Controller = Controller::Cascade;
/// Control horizon of the MPC.
pub const CONTROL_HORIZON: usize = 5;

/// A pulse starts this long after the tick of the loop that computed it, µs. `fast` must be done by then (its budget of
/// 60,000 cycles is 357 µs), and the pin is low meanwhile, since the longest pulse of 2000 µs ends before the next tick:
/// 500 + 2000 = 2500.
pub const PULSE_DELAY_US: u32 = 500;

/// Sensor supply: off for at least this long, or the sensors do not restart, ms.
pub const SENSOR_OFF_MS: u32 = 25;
/// Sensor supply: first register access this long after it is on, ms (MPU6000 data sheet: 100 ms at most).
pub const SENSOR_START_MS: u32 = 120;

/// TELEM1, bits per second.
pub const LINK_BAUD: u32 = 115_200;
