//! The MPU6000 of a Pixhawk 1, from motion to the counts that the board reads.
//!
//! Scales: register map of the MPU-6000, sections 4.4 and 4.5: 16.4 counts per deg/s at +-2000 deg/s, 4096 counts per g
//! at +-8 g. At both, full scale is the range of 16 bits, where the reading stays. Axes: body FRD = (sensor y, -sensor
//! x, sensor z), the chip being mounted upside down (PX4's and ArduPilot's drivers agree).

use shared_control::signals::RawImuSample;

/// Gyro counts per rad/s.
pub const GYRO_COUNTS_PER_RAD_S: f64 = 16.4 * 180.0 / core::f64::consts::PI;

/// Standard gravity, which a data sheet's "g" means, m/s².
const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Accelerometer counts per m/s².
pub const ACCEL_COUNTS_PER_M_S2: f64 = 4096.0 / STANDARD_GRAVITY_M_S2;

/// Low-pass of the accelerometer and of the gyro, Hz, with CONFIG 0, as the firmware sets it (register map 4.3). The
/// order is not documented; the second is taken. What it leaves is read at the chip's own rate, so that whatever lies
/// above half of that folds down.
const ACCEL_LOWPASS_HZ: f64 = 260.0;
const GYRO_LOWPASS_HZ: f64 = 256.0;

/// Share of a line of so many rad/s that the accelerometer's low-pass leaves.
pub(crate) fn accel_passes(line_rad_s: f64) -> f64 {
    second_order_passes(line_rad_s, ACCEL_LOWPASS_HZ)
}

/// The same of the gyro's.
pub(crate) fn gyro_passes(line_rad_s: f64) -> f64 {
    second_order_passes(line_rad_s, GYRO_LOWPASS_HZ)
}

/// Butterworth.
fn second_order_passes(line_rad_s: f64, cutoff_hz: f64) -> f64 {
    let ratio = line_rad_s / (core::f64::consts::TAU * cutoff_hz);
    1.0 / (1.0 + ratio * ratio * ratio * ratio).sqrt()
}

/// A body vector in the sensor's axes.
pub fn sensor_from_body([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-y, x, z]
}

/// What the sensor reports of a body rate and a specific force, rounded to the nearest count and held at full scale.
pub fn quantise(time_us: u64, rate_body_rad_s: [f64; 3], specific_force_body_m_s2: [f64; 3]) -> RawImuSample {
    RawImuSample {
        time_us,
        gyro_counts: sensor_from_body(rate_body_rad_s).map(|rate| nearest(rate * GYRO_COUNTS_PER_RAD_S)),
        accel_counts: sensor_from_body(specific_force_body_m_s2).map(|force| nearest(force * ACCEL_COUNTS_PER_M_S2)),
    }
}

/// A sensor's vector in the body's axes.
fn body_from_sensor([x, y, z]: [f64; 3]) -> [f64; 3] {
    [y, -x, z]
}

/// What a sample says, body axes: rate (rad/s) and specific force (m/s²). [`quantise`] makes the same sample of it.
pub fn reading(sample: &RawImuSample) -> ([f64; 3], [f64; 3]) {
    let rate_rad_s = sample.gyro_counts.map(|counts| f64::from(counts) / GYRO_COUNTS_PER_RAD_S);
    let force_m_s2 = sample.accel_counts.map(|counts| f64::from(counts) / ACCEL_COUNTS_PER_M_S2);
    (body_from_sensor(rate_rad_s), body_from_sensor(force_m_s2))
}

/// `as` cuts off toward zero, holds at the ends of the range, and makes not-a-number 0.
#[inline]
fn nearest(counts: f64) -> i16 {
    (counts + 0.5_f64.copysign(counts)) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_those_of_the_data_sheet() {
        let degree = core::f64::consts::PI / 180.0;
        let sample = quantise(7, [100.0 * degree, 0.0, -100.0 * degree], [0.0, 0.0, -9.806_65]);
        assert_eq!(sample.time_us, 7);
        assert_eq!(sample.gyro_counts, [0, 1640, -1640]);
        // at rest and level the upside-down chip reads -1 g
        assert_eq!(sample.accel_counts, [0, 0, -4096]);
    }

    #[test]
    fn axes_map_body_to_sensor_as_the_board_mounts_it() {
        // a right-down roll rate is about the body's x axis, which is the sensor's y axis
        assert_eq!(quantise(0, [1.0, 0.0, 0.0], [0.0; 3]).gyro_counts, [0, 940, 0]);
        // body y is minus sensor x
        assert_eq!(quantise(0, [0.0, 1.0, 0.0], [0.0; 3]).gyro_counts, [-940, 0, 0]);
        assert_eq!(quantise(0, [0.0, 0.0, 1.0], [0.0; 3]).gyro_counts, [0, 0, 940]);
    }

    #[test]
    fn rounding_is_to_the_nearest_and_symmetric() {
        for (counts, expected) in [(0.4, 0), (0.6, 1), (1.4, 1), (-0.4, 0), (-0.6, -1), (-1.4, -1), (100.5, 101)] {
            assert_eq!(nearest(counts), expected, "{counts}");
        }
    }

    #[test]
    fn readings_stay_at_full_scale() {
        let sample = quantise(0, [0.0, 40.0, -40.0], [0.0, -100.0, 100.0]);
        assert_eq!(sample.gyro_counts, [i16::MIN, 0, i16::MIN]);
        assert_eq!(sample.accel_counts, [i16::MAX, 0, i16::MAX]);
        let lost = quantise(0, [f64::NAN; 3], [f64::INFINITY; 3]);
        assert_eq!(lost.gyro_counts, [0; 3]);
        assert_eq!(lost.accel_counts, [i16::MIN, i16::MAX, i16::MAX]);
    }

    proptest::proptest! {
        #[test]
        fn a_reading_makes_the_same_sample_again(
            gyro_counts in proptest::array::uniform3(proptest::num::i16::ANY),
            accel_counts in proptest::array::uniform3(proptest::num::i16::ANY),
        ) {
            let sample = RawImuSample { time_us: 3, gyro_counts, accel_counts };
            let (rate, force) = reading(&sample);
            proptest::prop_assert_eq!(quantise(3, rate, force), sample);
        }

        /// The control core has scales and axis map of its own; both sides must mean the same sensor.
        #[test]
        fn the_control_core_reads_back_what_was_felt(
            rate in proptest::array::uniform3(-34.0..34.0_f64), force in proptest::array::uniform3(-78.0..78.0_f64),
        ) {
            let core = shared_control::sensing::imu::ImuConfig::pixhawk1_mpu6000(100.0, 1000.0);
            let sample = quantise(0, rate, force);
            let (rate_read, force_read) = (core.gyro_rad_s(&sample), core.specific_force_m_s2(&sample));
            for axis in 0..3 {
                // half a count, and the rounding of f32 at 2^15 counts
                let half_gyro = 0.501 / GYRO_COUNTS_PER_RAD_S + 1e-5;
                let half_accel = 0.501 / ACCEL_COUNTS_PER_M_S2 + 1e-5;
                proptest::prop_assert!((f64::from(rate_read[axis]) - rate[axis]).abs() < half_gyro);
                proptest::prop_assert!((f64::from(force_read[axis]) - force[axis]).abs() < half_accel);
            }
        }
    }
}
