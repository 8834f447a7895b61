//! What the board meets outside: motion to be measured, motors to be driven.

use crate::devices::Counts;
use crate::peripherals::timer::Pulse;
use crate::time::Ticks;

/// The vehicle and its surroundings, as the board's sensors and outputs meet them.
pub trait World {
    /// What the MPU6000 measures at this time.
    fn imu(&mut self, now: Ticks) -> Counts;
    /// A pulse ended on a motor output: channel 0 to 3 is TIM1 CH1 to CH4.
    fn pulse(&mut self, pulse: Pulse);
    /// TIM3 sent its trigger, the tick of the image's loop.
    fn loop_tick(&mut self, _at: Ticks) {}
    /// Are the L3GD20 and the LSM303D fitted? Without them nobody answers when they are selected.
    fn has_second_imu(&self) -> bool {
        false
    }
    /// What those two measure at this time: the gyro of the one, the accelerometer of the other.
    fn second_imu(&mut self, _now: Ticks) -> Counts {
        Counts::default()
    }
}

/// In the place of a world that has been taken out.
pub(crate) struct Nowhere;

impl World for Nowhere {
    fn imu(&mut self, _: Ticks) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}
