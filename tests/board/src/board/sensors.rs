//! The three sensors: their sample clocks, their data-ready lines, their faults.

use super::{B, Board, D};
use crate::devices::{Sensor, SensorFault};
use crate::time::Ticks;

/// Port and pin of the data-ready lines.
const MPU6000_READY: (usize, u32) = (D, 15);
const L3GD20_READY: (usize, u32) = (B, 0);
const LSM303D_READY: (usize, u32) = (B, 4);

impl Board {
    /// Lets a sensor fail, or be whole again.
    pub(crate) fn set_sensor_fault(&mut self, sensor: Sensor, fault: Option<SensorFault>) {
        self.sensor_faults[sensor as usize] = fault;
        self.refresh_lines(self.now);
    }

    fn fault(&self, sensor: Sensor) -> Option<SensorFault> {
        self.sensor_faults[sensor as usize]
    }

    /// The byte that is read instead of the sensor's own.
    pub(super) fn stuck_answer(&self, sensor: Sensor) -> Option<u8> {
        match self.fault(sensor)? {
            SensorFault::Removed(byte) | SensorFault::DeadBus(byte) => Some(byte),
            SensorFault::Frozen | SensorFault::NoDataReady => None,
        }
    }

    fn is_frozen(&self, sensor: Sensor) -> bool {
        self.fault(sensor) == Some(SensorFault::Frozen)
    }

    pub(super) fn tick_sensors(&mut self, now: Ticks) {
        while let Some(at) = self.mpu6000.sample_due(now) {
            let counts = self.world.imu(at);
            self.mpu6000.sample((!self.is_frozen(Sensor::Mpu6000)).then_some(counts));
        }
        self.mpu6000.tick(now);
        while let Some(at) = self.l3gd20.sample_due(now) {
            let words = (!self.is_frozen(Sensor::L3gd20)).then(|| self.world.second_imu(at).gyro);
            self.l3gd20.sample(words);
        }
        while let Some(at) = self.lsm303d.sample_due(now) {
            let words = (!self.is_frozen(Sensor::Lsm303d)).then(|| self.world.second_imu(at).accel);
            self.lsm303d.sample(words);
        }
    }

    /// Drives their data-ready lines.
    pub(super) fn refresh_sensors(&mut self) {
        for (sensor, (port, pin), ready) in [
            (Sensor::Mpu6000, MPU6000_READY, self.mpu6000.interrupt_pin()),
            (Sensor::L3gd20, L3GD20_READY, self.l3gd20.data_ready()),
            (Sensor::Lsm303d, LSM303D_READY, self.lsm303d.data_ready()),
        ] {
            let lost = matches!(self.fault(sensor), Some(SensorFault::Removed(_) | SensorFault::NoDataReady));
            self.ports[port].put(pin, ready && !lost);
        }
    }
}
