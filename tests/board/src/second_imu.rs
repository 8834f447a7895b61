//! The L3GD20 and LSM303D of a Pixhawk 1, from motion to the counts that the board reads: scales, axes, noise of their
//! own.
//!
//! 70 mdeg/s a count at +-2000 deg/s (DocID022116 table 4), 0.244 mg at +-8 g (DocID023312 table 3). Axes as PX4's and
//! ArduPilot's drivers have them: body FRD is (sensor y, -sensor x, sensor z) for the L3GD20, (-x, -y, z) for the
//! L3GD20H, and the LSM303D's own axes; all are upside down, so that at rest z reads about -1 g.

use sil_host::model::SensorNoise;
use sil_host::plant::Truth;
use sil_host::sensors::random::RandomStream;

use crate::devices::Counts;
use crate::devices::SecondGyro;

const COUNTS_PER_RAD_S: f64 = 180.0 / core::f64::consts::PI / 0.070;
const COUNTS_PER_M_S2: f64 = 1.0 / (0.244e-3 * 9.806_65);

/// Both sensors.
#[derive(Clone)]
pub(crate) struct SecondImu {
    pub(crate) gyro: SecondGyro,
    noise: SensorNoise,
    gyro_stream: RandomStream,
    accel_stream: RandomStream,
}

impl SecondImu {
    pub(crate) fn new(gyro: SecondGyro, noise: &SensorNoise, seed: u64) -> Self {
        Self {
            gyro,
            noise: *noise,
            gyro_stream: RandomStream::new(seed, "second gyro"),
            accel_stream: RandomStream::new(seed, "second accelerometer"),
        }
    }

    /// What both measure of this motion.
    pub(crate) fn measure(&mut self, truth: &Truth) -> Counts {
        let [x, y, z] = truth.rate_body_rad_s.map(|rate| rate + self.noise.gyro_rad_s * self.gyro_stream.normal());
        let force =
            truth.specific_force_body_m_s2.map(|force| force + self.noise.accel_m_s2 * self.accel_stream.normal());
        let rate = match self.gyro {
            SecondGyro::L3gd20 => [-y, x, z],
            SecondGyro::L3gd20h => [-x, -y, z],
        };
        Counts {
            gyro: rate.map(|rate| nearest(rate * COUNTS_PER_RAD_S)),
            accel: force.map(|force| nearest(force * COUNTS_PER_M_S2)),
        }
    }
}

/// `as` cuts off toward zero and holds at the ends of the range.
fn nearest(counts: f64) -> i16 {
    (counts + 0.5_f64.copysign(counts)) as i16
}

#[cfg(test)]
mod tests {
    use super::*;
    use sil_host::model::{Rig, VehicleModel};
    use sil_host::plant::Plant;

    const NO_NOISE: SensorNoise = SensorNoise::NONE;

    #[test]
    fn counts_are_those_of_the_data_sheets_in_the_sensors_axes() {
        let mut plant = Plant::new(&VehicleModel::nominal(Rig::Gimbal));
        let degree = core::f64::consts::PI / 180.0;
        plant.set_attitude([0.0; 3], [70.0 * degree, 7.0 * degree, 0.0]);
        let counts = SecondImu::new(SecondGyro::L3gd20, &NO_NOISE, 1).measure(&plant.truth());
        assert_eq!(counts.gyro, [-100, 1000, 0]);
        let counts = SecondImu::new(SecondGyro::L3gd20h, &NO_NOISE, 1).measure(&plant.truth());
        assert_eq!(counts.gyro, [-1000, -100, 0]);
        // 1 g at 0.244 mg
        assert!((f64::from(counts.accel[2]) + 4098.0).abs() < 100.0, "{counts:?}");
    }

    #[test]
    fn its_noise_is_its_own() {
        let plant = Plant::new(&VehicleModel::nominal(Rig::Gimbal));
        let noise = SensorNoise { gyro_rad_s: 0.1, accel_m_s2: 0.5, ..SensorNoise::NONE };
        let mut first = sil_host::sensors::Sensors::new(&noise, 3);
        let mut second = SecondImu::new(SecondGyro::L3gd20, &noise, 3);
        let rates = |gyro: [i16; 3], scale: f64| gyro.map(|count| f64::from(count) / scale);
        let a = rates(first.imu(&plant, 0).gyro_counts, sil_host::sensors::imu::GYRO_COUNTS_PER_RAD_S);
        let b = rates(second.measure(&plant.truth()).gyro, COUNTS_PER_RAD_S);
        // both sit the same way: equal streams would give equal rates, to half a count of each
        assert!(a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.005), "{a:?} {b:?}");
    }
}
