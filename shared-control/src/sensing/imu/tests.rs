//! Counts, axes and stamps against the data sheets, and against what a vehicle would feel.

use super::*;

fn config() -> ImuConfig {
    ImuConfig::pixhawk1_mpu6000(100.0, 1000.0)
}

/// With rotors that stand.
fn condition(config: &ImuConfig, state: &mut ImuState, samples: &[RawImuSample], now_us: u64) -> ImuStep {
    super::condition(config, state, samples, now_us, Flown::default())
}

fn sample(time_us: u64, gyro_counts: [i16; 3]) -> RawImuSample {
    // level and at rest: the body's z axis feels -1 g, and the sensor's z axis is the body's
    RawImuSample { time_us, gyro_counts, accel_counts: [0, 0, -4096] }
}

#[test]
fn scale_and_axes_are_the_data_sheets() {
    let mut state = ImuState::default();
    // 164 counts on the sensor's x axis = 10 deg/s, which is -y of the body
    let step = condition(&config(), &mut state, &[sample(0, [164, 0, 0])], 0);
    assert!((step.rate_body_rad_s - Vector3::new(0.0, -10f32.to_radians(), 0.0)).norm() < 1e-5);
    assert!((step.specific_force_m_s2 - Vector3::new(0.0, 0.0, -9.806_65)).norm() < 1e-4);
}

/// A yaw word at either end says the rate that the motors make, where that is the larger and turns the same way; others
/// and lesser ones stay what they are.
#[test]
fn a_yaw_beyond_the_range_is_what_the_motors_make() {
    let most_rad_s = config().gyro_max_rad_s();
    assert!((most_rad_s - 34.87).abs() < 0.01);
    let yaw = |word: i16, beyond_rad_s: Option<f32>| {
        let flown = Flown { rotors_turn: true, beyond_rad_s };
        let mut state = ImuState::default();
        super::condition(&config(), &mut state, &[sample(0, [i16::MAX, 0, word])], 0, flown).rate_body_rad_s
    };
    for sign in [1.0, -1.0] {
        let full = if sign > 0.0 { i16::MAX } else { i16::MIN };
        assert_eq!(yaw(full, Some(sign * 41.0)).z, sign * 41.0);
        for other_rad_s in [None, Some(sign * 30.0), Some(sign * -41.0), Some(f32::NAN)] {
            assert!((yaw(full, other_rad_s).z - sign * most_rad_s).abs() < 0.01, "{other_rad_s:?}");
        }
        let within = full - 2 * sign as i16;
        assert!((yaw(within, Some(sign * 41.0)).z - sign * most_rad_s).abs() < 0.01);
        assert!((yaw(full, Some(sign * 41.0)).y + most_rad_s).abs() < 0.01);
    }
}

#[test]
fn rotation_is_the_integral_whatever_the_batches() {
    let mut state = ImuState::default();
    let mut angle = Vector3::zeros();
    let mut time_us = 0;
    for batch in [1usize, 2, 3, 16, 1, 5] {
        let samples: heapless::Vec<_, 16> = (0..batch)
            .map(|_| {
                time_us += 1000;
                sample(time_us, [0, 164, 0])
            })
            .collect();
        angle += condition(&config(), &mut state, &samples, time_us).rotation_rad;
    }
    // 28 samples span 27 ms at 10 deg/s
    assert!((angle.x - 10f32.to_radians() * 0.027).abs() < 1e-6, "{angle}");
}

#[test]
fn short_gaps_are_bridged_long_ones_are_not_and_stale_samples_are_left_out() {
    let mut state = ImuState::default();
    condition(&config(), &mut state, &[sample(1000, [0, 164, 0])], 1000);
    // 100 ms without samples at 10 deg/s on both sides: one degree
    let bridged = condition(&config(), &mut state, &[sample(101_000, [0, 164, 0])], 101_000);
    assert!(!bridged.after_gap && (bridged.rotation_rad.x - 1f32.to_radians()).abs() < 1e-6);
    let late = condition(&config(), &mut state, &[sample(900_000, [16400, 0, 0])], 900_000);
    assert!(late.after_gap && late.duration_s == 0.0 && late.rotation_rad == Vector3::zeros());
    let stale = [sample(900_000, [16400, 0, 0]), sample(800_000, [0; 3])];
    let again = condition(&config(), &mut state, &stale, 900_000);
    assert_eq!(again.samples, 0);
    assert_eq!(again.rate_body_rad_s, late.rate_body_rad_s);
}

#[test]
fn a_stamp_from_the_future_blinds_nobody() {
    let mut state = ImuState::default();
    condition(&config(), &mut state, &[sample(1000, [0; 3])], 1000);
    assert_eq!(condition(&config(), &mut state, &[sample(40_000_000, [0; 3])], 2000).samples, 0);
    assert_eq!(condition(&config(), &mut state, &[sample(3000, [0; 3])], 3000).samples, 1);
    // the clock itself was set back
    assert_eq!(condition(&config(), &mut state, &[sample(900_000, [0; 3])], 900_000).samples, 1);
    assert_eq!(condition(&config(), &mut state, &[sample(10_000, [0; 3])], 10_000).samples, 1);
}

#[test]
fn a_batch_has_the_mean_force_and_the_low_passed_rate() {
    let mut state = ImuState::default();
    let batch: heapless::Vec<_, 16> = (1..=10).map(|k| sample(k * 1000, [0, if k > 5 { 164 } else { 0 }, 0])).collect();
    let step = condition(&config(), &mut state, &batch, 10_000);
    assert!((step.specific_force_m_s2.z + 9.806_65).abs() < 1e-4);
    // a 100 Hz low-pass has not settled 5 ms after a step
    assert!(step.rate_body_rad_s.x > 0.1 * 10f32.to_radians() && step.rate_body_rad_s.x != 10f32.to_radians());
}

/// What ArduPilot's `LSM9DS0` driver makes of a reading: (x, -y, -z), then the board's rotation.
fn ardupilot([x, y, z]: [f32; 3], rotation: impl Fn([f32; 3]) -> [f32; 3]) -> Vector3<f32> {
    Vector3::from(rotation([x, -y, -z]))
}

#[test]
fn the_second_imus_axes_are_those_of_two_other_drivers() {
    let sensor = [1.0, 2.0, 3.0];
    let [x, y, z] = sensor;
    let roll_180 = |[x, y, z]: [f32; 3]| [x, -y, -z];
    let roll_180_yaw_270 = |[x, y, z]: [f32; 3]| [-y, -x, -z];
    let pitch_180 = |[x, y, z]: [f32; 3]| [-x, y, -z];
    let l3gd20 = AxisMap::PIXHAWK1_L3GD20.to_body(sensor);
    assert_eq!(l3gd20, ardupilot(sensor, roll_180_yaw_270));
    // PX4: 270 and 180 degrees of yaw
    assert_eq!(l3gd20, Vector3::new(y, -x, z));
    let l3gd20h = AxisMap::PIXHAWK1_L3GD20H.to_body(sensor);
    assert_eq!(l3gd20h, ardupilot(sensor, pitch_180));
    assert_eq!(l3gd20h, Vector3::new(-x, -y, z));
    assert_eq!(AxisMap::PIXHAWK1_LSM303D.to_body(sensor), ardupilot(sensor, roll_180));
}

#[test]
fn the_second_imu_reads_in_its_data_sheets_units() {
    let config = ImuConfig::pixhawk1_l3gd20_lsm303d(100.0);
    // 1000 digits on the gyro's x axis = 70 deg/s, -y of the body; 1 g is 1000 / 0.244 digits
    let sample = RawImuSample { time_us: 0, gyro_counts: [1000, 0, 0], accel_counts: [0, 0, -4098] };
    assert!((config.gyro_rad_s(&sample) - Vector3::new(0.0, -70f32.to_radians(), 0.0)).norm() < 1e-5);
    assert!((config.specific_force_m_s2(&sample) - Vector3::new(0.0, 0.0, -9.806_65)).norm() < 1.2e-3);
}

/// Gaps of exactly the limits: the first is still continuous, at the last sample's rate; the second still bridged, at
/// the mean of both sides; a microsecond more is neither.
#[test]
fn gaps_end_where_they_are_said_to() {
    let rate = 10f32.to_radians();
    for (gap_us, rotation_rad, duration_s) in [
        (50_000, rate * 0.05, 0.05),
        (50_001, 0.5 * rate * 0.05, 0.05),
        (500_000, 0.5 * rate * 0.5, 0.5),
        (500_001, 0.0, 0.0),
    ] {
        let mut state = ImuState::default();
        let first = condition(&config(), &mut state, &[sample(1000, [0; 3])], 1000);
        assert!(first.after_gap && first.samples == 1 && first.duration_s == 0.0);
        let time_us = 1000 + gap_us;
        let step = condition(&config(), &mut state, &[sample(time_us, [0, 164, 0])], time_us);
        assert!((step.rotation_rad - Vector3::new(rotation_rad, 0.0, 0.0)).norm() < 1e-6, "{gap_us}: {step:?}");
        assert!((step.duration_s - duration_s).abs() < 2e-6, "{gap_us}: {step:?}");
        assert_eq!(step.after_gap, gap_us > 500_000);
        // the low-pass goes on over what is continuous, and begins anew behind a gap
        assert_eq!((step.rate_body_rad_s.x - rate).abs() < 1e-5, gap_us > 50_000, "{gap_us}: {step:?}");
    }
}

/// Stamps up to 5 ms ahead of the step are times, later ones are none, whether of a sample or of the last one kept.
#[test]
fn stamps_may_be_a_little_ahead() {
    for (stamp_us, taken) in [(6000, 1), (6001, 0)] {
        let mut state = ImuState::default();
        assert_eq!(condition(&config(), &mut state, &[sample(stamp_us, [0; 3])], 1000).samples, taken);
    }
    // kept as the last time, after which 5500 is no news; a microsecond beyond the limit it is forgotten
    for (now_us, taken) in [(1000, 0), (999, 1)] {
        let mut state = ImuState::default();
        condition(&config(), &mut state, &[sample(6000, [0; 3])], 6000);
        assert_eq!(condition(&config(), &mut state, &[sample(5500, [0; 3])], now_us).samples, taken, "{now_us}");
    }
}

/// Three samples, each with a force of its own: the mean, axis by axis; and times add up.
#[test]
fn a_batch_is_summed_over_its_samples() {
    let mut state = ImuState::default();
    condition(&config(), &mut state, &[sample(1000, [0; 3])], 1000);
    let forces: [[i16; 3]; 3] = [[4096, 0, 0], [0, 8192, 0], [-4096, 4096, -12288]];
    let batch: heapless::Vec<_, 16> = (2..)
        .zip(forces)
        .map(|(k, accel_counts)| RawImuSample { time_us: k * 1000, gyro_counts: [0, 0, 164], accel_counts })
        .collect();
    let step = condition(&config(), &mut state, &batch, 4000);
    // body FRD = (sensor y, -sensor x, sensor z); 4096 counts are 1 g
    let mean = Vector3::new(4096.0, 0.0, -4096.0) * (9.806_65 / 4096.0);
    assert!((step.specific_force_m_s2 - mean).norm() < 1e-4, "{step:?}");
    assert!((step.duration_s - 0.003).abs() < 1e-8 && step.samples == 3 && !step.after_gap);
    assert!((step.rotation_rad.z - 10f32.to_radians() * 0.003).abs() < 1e-7);
    assert!(step.is_usable());
}

/// A step without samples keeps the rate that was last known, for the step after it too.
#[test]
fn without_samples_the_rate_stays() {
    let mut state = ImuState::default();
    let known = condition(&config(), &mut state, &[sample(1000, [164, 0, 0])], 1000).rate_body_rad_s;
    for now_us in [2000, 3000] {
        let step = condition(&config(), &mut state, &[], now_us);
        assert_eq!((step.samples, step.rate_body_rad_s), (0, known));
        assert_eq!(step.specific_force_m_s2, Vector3::zeros());
    }
}

#[test]
fn nothing_and_no_numbers_are_not_usable() {
    let mut state = ImuState::default();
    let good = condition(&config(), &mut state, &[sample(1000, [0; 3])], 1000);
    assert!(good.is_usable());
    assert!(!ImuStep { samples: 0, ..good }.is_usable());
    for axis in 0..3 {
        let mut poison = Vector3::zeros();
        poison[axis] = f32::NAN;
        assert!(!ImuStep { rotation_rad: poison, ..good }.is_usable());
        assert!(!ImuStep { specific_force_m_s2: poison, ..good }.is_usable());
    }
}

/// Each map and its reverse undo each other, and a map that names no axis of the sensor leaves the others alone.
#[test]
fn body_and_sensor_are_two_views_of_one_vector() {
    let body = [1.0, -2.0, 3.0];
    for map in [
        AxisMap::PIXHAWK1_MPU6000,
        AxisMap::PIXHAWK1_L3GD20,
        AxisMap::PIXHAWK1_L3GD20H,
        AxisMap::PIXHAWK1_LSM303D,
        AxisMap { source: [2, 0, 1], sign: [-1.0, 1.0, -1.0] },
    ] {
        assert_eq!(map.to_body(map.from_body(body)), Vector3::from(body), "{map:?}");
    }
    let beyond = AxisMap { source: [0, 1, 7], sign: [1.0; 3] };
    assert_eq!(beyond.from_body(body), [1.0, -2.0, 0.0]);
}

#[test]
fn spans_are_exact_to_the_microsecond_and_end_somewhere() {
    assert_eq!(seconds_between(5, 5), 0.0);
    assert_eq!(seconds_between(6, 5), 0.0);
    assert_eq!(seconds_between(1_000_000, 3_500_000), 2.5);
    for longest in [u64::from(u32::MAX), u64::from(u32::MAX) + 1, u64::MAX] {
        assert_eq!(seconds_between(0, longest), 4_294.967_3);
    }
}

/// A line of a rotor under 1 g: the steady force has a hundredth of it, the mean of all steps none, and the vibration
/// is its root mean square, peak / sqrt 2.
#[test]
fn a_rotors_line_is_vibration_and_no_force() {
    let config = config();
    let mut state = ImuState::default();
    let (peak_m_s2, mut sum, mut last) = (30.0f32, Vector3::zeros(), None);
    for step in 0..1200u64 {
        let samples: heapless::Vec<_, 16> = (0..3)
            .map(|k| {
                let time_us = (3 * step + k) * 1000;
                let turns = (time_us % 100_000) as f32 * 1e-6 * 90.0;
                let (sin, _) = crate::elementary::sin_cos(turns * core::f32::consts::TAU);
                let counts = (peak_m_s2 * sin / config.accel_m_s2_per_count) as i16;
                // the sensor's x axis is -y of the body
                RawImuSample { accel_counts: [-counts, 0, -4096], ..sample(time_us, [0; 3]) }
            })
            .collect();
        let news = condition(&config, &mut state, &samples, 3000 * step + 2000);
        // ninety whole turns from here on
        sum += if step >= 200 { news.specific_force_m_s2 } else { Vector3::zeros() };
        last = Some(news);
    }
    let news = last.unwrap();
    assert!((news.vibration_m_s2.y / (peak_m_s2 * 0.5f32.sqrt()) - 1.0).abs() < 0.02, "{}", news.vibration_m_s2);
    assert!(news.vibration_m_s2.x < 0.01 && news.vibration_m_s2.z < 0.01);
    // (5 Hz / 90 Hz)^2 is 0.0031
    assert!(news.steady_force_m_s2.y.abs() < 0.0032 * peak_m_s2);
    // single precision rounds by 6e-7 a sample, over some hundred that the low-pass remembers
    assert!((news.steady_force_m_s2.z + 9.806_65).abs() < 5e-3);
    assert!((sum.y / 1000.0).abs() < 0.01, "{sum}");
}

/// The steady force is late by what its constant says.
#[test]
fn the_steady_force_is_late_by_its_lag() {
    let config = config();
    let mut state = ImuState::default();
    // 2 m/s^2 more each second, along the sensor's y axis, the body's x
    let force_m_s2 = |time_s: f32| 2.0 * time_s;
    let mut news = None;
    for k in 0..2000u64 {
        let time_us = k * 1000;
        let counts = (force_m_s2(time_us as f32 * 1e-6) / config.accel_m_s2_per_count) as i16;
        let sample = RawImuSample { accel_counts: [0, counts, -4096], ..sample(time_us, [0; 3]) };
        news = Some(condition(&config, &mut state, &[sample], time_us));
    }
    let late_s = 1.999 - news.unwrap().steady_force_m_s2.x / 2.0;
    assert!((late_s - STEADY_LAG_S).abs() < 2e-3, "{late_s} for {STEADY_LAG_S}");
}
