//! What is soldered around the chip.

pub(crate) mod fram;
pub(crate) mod mpu6000;

/// One reading of an IMU: counts in the sensor's axes, at the ranges that the firmware sets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rotation rate. MPU6000 and L3GD20: at +-2000 deg/s.
    pub gyro: [i16; 3],
    /// Specific force. MPU6000 and LSM303D: at +-8 g.
    pub accel: [i16; 3],
}
