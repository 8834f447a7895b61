use super::imu::{ACCEL_COUNTS_PER_M_S2, GYRO_COUNTS_PER_RAD_S};
use super::*;
use crate::model::{Rig, VehicleModel};

const COUNT: u64 = 20_000;

/// A gimbal at rest, rolled and pitched, so that no axis of the accelerometer reads zero.
fn tilted() -> (VehicleModel, Plant) {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let mut plant = Plant::new(&model);
    plant.set_attitude([0.4, -0.3, 0.0], [0.2, -0.1, 0.0]);
    (model, plant)
}

/// Mean and standard deviation.
fn statistics(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let mean = values.clone().sum::<f64>() / COUNT as f64;
    let variance = values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / COUNT as f64;
    (mean, variance.sqrt())
}

/// Six readings in SI units, sensor axes.
fn in_si(sample: &RawImuSample) -> [f64; 6] {
    let gyro = sample.gyro_counts.map(|count| f64::from(count) / GYRO_COUNTS_PER_RAD_S);
    let accel = sample.accel_counts.map(|count| f64::from(count) / ACCEL_COUNTS_PER_M_S2);
    [gyro[0], gyro[1], gyro[2], accel[0], accel[1], accel[2]]
}

#[test]
fn readings_scatter_about_truth_and_bias_with_the_stated_deviation() {
    let (model, plant) = tilted();
    let (gyro_bias, accel_bias) = ([0.03, -0.02, 0.01], [0.2, 0.1, -0.3]);
    let mut sensors = Sensors::new(&model.noise, 11).with_bias(gyro_bias, accel_bias);
    let samples: Vec<[f64; 6]> = (0..COUNT).map(|time_us| in_si(&sensors.imu(&plant, time_us))).collect();
    let add = |a: [f64; 3], b: [f64; 3]| imu::sensor_from_body([a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    let [rate, force] = [add(plant.rate_body_rad_s(), gyro_bias), add(plant.specific_force_body_m_s2(), accel_bias)];
    for axis in 0..6 {
        let (mean, deviation) = statistics(samples.iter().map(|sample| sample[axis]));
        let (expected, noise) =
            if axis < 3 { (rate[axis], model.noise.gyro_rad_s) } else { (force[axis - 3], model.noise.accel_m_s2) };
        let n = COUNT as f64;
        // five standard errors; rounding adds 1/12 count squared of variance, under 0.1 % of the deviation here
        assert!((mean - expected).abs() < 5.0 * noise / n.sqrt(), "axis {axis}: mean {mean}, expected {expected}");
        assert!((deviation / noise - 1.0).abs() < 5.0 / (2.0 * n).sqrt() + 1e-3, "axis {axis}: {deviation}");
    }
}

#[test]
fn noise_of_one_axis_tells_nothing_of_another_or_of_the_next_sample() {
    let (model, plant) = tilted();
    let mut sensors = Sensors::new(&model.noise, 12);
    let samples: Vec<[f64; 6]> = (0..COUNT).map(|time_us| in_si(&sensors.imu(&plant, time_us))).collect();
    let moments: Vec<(f64, f64)> = (0..6).map(|axis| statistics(samples.iter().map(|sample| sample[axis]))).collect();
    let whitened = |sample: &[f64; 6], axis: usize| (sample[axis] - moments[axis].0) / moments[axis].1;
    for a in 0..6 {
        for b in 0..6 {
            let now = samples.iter().map(|sample| whitened(sample, a) * whitened(sample, b));
            let next = samples.windows(2).map(|pair| whitened(&pair[0], a) * whitened(&pair[1], b));
            // 72 correlations with standard error 1/sqrt(n): 5 of them leave none by chance
            let limit = 5.0 / (COUNT as f64).sqrt();
            let (now, next) = (now.sum::<f64>() / COUNT as f64, next.sum::<f64>() / COUNT as f64);
            assert!(a == b || now.abs() < limit, "axes {a} and {b}: {now}");
            assert!(next.abs() < limit, "axis {b} after axis {a}: {next}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_samples() {
    let (model, plant) = tilted();
    let run = |seed| {
        let mut sensors = Sensors::new(&model.noise, seed);
        (0..100).map(|time_us| (sensors.imu(&plant, time_us), sensors.attitude([0.1; 3]))).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn drawing_from_one_sensor_leaves_the_others_alone() {
    let (model, plant) = tilted();
    let mut alone = Sensors::new(&model.noise, 3);
    let mut with_attitude = Sensors::new(&model.noise, 3);
    for time_us in 0..50 {
        with_attitude.attitude([0.0; 3]);
        assert_eq!(alone.imu(&plant, time_us), with_attitude.imu(&plant, time_us));
    }
    let quiet_gyro = SensorNoise { gyro_rad_s: 0.0, ..model.noise };
    let (mut noisy, mut quiet) = (Sensors::new(&model.noise, 3), Sensors::new(&quiet_gyro, 3));
    for time_us in 0..50 {
        assert_eq!(noisy.imu(&plant, time_us).accel_counts, quiet.imu(&plant, time_us).accel_counts);
    }
}

#[test]
fn ideal_sensors_only_round() {
    let (_, plant) = tilted();
    let sample = Sensors::ideal().imu(&plant, 5);
    assert_eq!(sample, imu::quantise(5, plant.rate_body_rad_s(), plant.specific_force_body_m_s2()));
    assert_eq!(Sensors::ideal().attitude([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
}
