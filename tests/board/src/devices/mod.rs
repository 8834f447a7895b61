//! What is soldered around the chip.

pub(crate) mod aux_line;
pub(crate) mod esc;
pub(crate) mod fram;
pub(crate) mod fram_select;
pub mod io_chip;
pub(crate) mod l3gd20;
pub(crate) mod level_shifter;
pub(crate) mod lsm303d;
pub(crate) mod mpu6000;
pub(crate) mod mpu6000_start;
pub mod sd_card;
pub(crate) mod sensor_rail;
pub(crate) mod st_sensor;
pub mod usb_host;

/// One reading of an IMU: counts in the sensor's axes, at the ranges that the firmware sets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rotation rate. MPU6000 and L3GD20: at +-2000 deg/s.
    pub gyro: [i16; 3],
    /// Specific force. MPU6000 and LSM303D: at +-8 g.
    pub accel: [i16; 3],
}

/// The gyro of the second IMU: two variants are in the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondGyro {
    /// Of most boards.
    L3gd20,
    /// Of later ones; it sits turned by a quarter.
    L3gd20h,
}

/// A sensor on SPI1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// The first IMU.
    Mpu6000,
    /// The second one's gyro, of either variant.
    L3gd20,
    /// The second one's accelerometer.
    Lsm303d,
}

/// What can be wrong with one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorFault {
    /// It is not there: this byte is read instead, 0xff or 0x00, and data-ready stays low.
    Removed(u8),
    /// Only its data line is broken: this byte is read, data-ready goes on.
    DeadBus(u8),
    /// It repeats the sample that it had.
    Frozen,
    /// Its data-ready line is broken; the rest goes on.
    NoDataReady,
}
