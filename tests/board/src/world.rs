//! What the board meets outside: motion to be measured, motors to be driven.

use crate::devices::{Counts, SecondGyro};
use crate::peripherals::timer::Pulse;
use crate::time::Ticks;

/// The vehicle and its surroundings, as the board's sensors and outputs meet them.
pub trait World {
    /// What the MPU6000 measures at this time.
    fn imu(&mut self, now: Ticks) -> Counts;
    /// A pulse ended on a motor output: channel 0 to 3 is TIM1 CH1 to CH4.
    fn pulse(&mut self, pulse: Pulse);
    /// A pulse ended on an AUX line behind the level shifter, whoever made it: the ESC sees this one.
    fn line_pulse(&mut self, _pulse: Pulse) {}
    /// TIM3 sent its trigger, the tick of the image's loop.
    fn loop_tick(&mut self, _at: Ticks) {}
    /// The second IMU's gyro, its LSM303D being there too; none if neither is fitted: then nobody answers when
    /// selected.
    fn second_gyro(&self) -> Option<SecondGyro> {
        None
    }
    /// What the second IMU measures at this time, the L3GD20 and the LSM303D.
    fn second_imu(&mut self, _now: Ticks) -> Counts {
        Counts::default()
    }
}

/// In the place of a world that has been taken out.
pub(crate) struct Nowhere;

/// A copy of a board is connected to nothing until it has a world of its own.
impl Clone for Box<dyn World> {
    fn clone(&self) -> Self {
        Box::new(Nowhere)
    }
}

impl World for Nowhere {
    fn imu(&mut self, _: Ticks) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}
