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

/// A plant and ideal sensors with effects, and the truth.
fn with_effects(effects: &[&str]) -> (Plant, Sensors) {
    let (_, plant) = tilted();
    let effects: Vec<Effect> = effects.iter().map(|short| Effect::parse(short, Rig::Gimbal).unwrap()).collect();
    (plant, Sensors::ideal().with_effects(&effects))
}

/// Reported rate and force in body axes, as counts allow.
fn reported(plant: &Plant, sensors: &mut Sensors) -> ([f64; 3], [f64; 3]) {
    let [x, y, z, ax, ay, az] = in_si(&sensors.imu(plant, 0));
    // sensor_from_body turned around
    ([y, -x, z], [ay, -ax, az])
}

fn assert_close(ours: [f64; 3], expected: [f64; 3], tolerance: f64) {
    assert!(ours.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance), "{ours:?} {expected:?}");
}

/// Half a count.
const GYRO_ROUNDING: f64 = 0.501 / GYRO_COUNTS_PER_RAD_S;
const ACCEL_ROUNDING: f64 = 0.501 / ACCEL_COUNTS_PER_M_S2;

#[test]
fn the_gyro_reports_scale_times_felt_plus_bias_after_misalignment() {
    let effects = [
        "gyro_bias:axis=pitch,bias_rad_s=0.05",
        "gyro_bias:axis=yaw,bias_rad_s=-0.02",
        "gyro_scale:axis=roll,scale=1.5",
        "gyro_scale:axis=pitch,scale=0.8",
        "imu_misalignment:yaw_rad=0.3",
    ];
    let (plant, mut sensors) = with_effects(&effects);
    let [p, q, r] = plant.rate_body_rad_s();
    let (sin, cos) = libm::sincos(0.3);
    let expected = [1.5 * (p * cos + q * sin), 0.8 * (-p * sin + q * cos) + 0.05, r - 0.02];
    let (rate, force) = reported(&plant, &mut sensors);
    assert_close(rate, expected, GYRO_ROUNDING);
    // scale and bias are the gyro's alone, the misalignment is the whole chip's
    let [x, y, z] = plant.specific_force_body_m_s2();
    assert_close(force, [x * cos + y * sin, -x * sin + y * cos, z], ACCEL_ROUNDING);
}

/// A sensor whose x axis points right feels a pitch rate about it.
#[test]
fn a_quarter_turn_makes_pitch_of_roll() {
    let (mut plant, mut sensors) = with_effects(&["imu_misalignment:yaw_rad=1.5707963267948966"]);
    plant.set_attitude([0.0; 3], [0.7, 0.4, 0.0]);
    let (rate, _) = reported(&plant, &mut sensors);
    assert_close(rate, [0.4, -0.7, 0.0], GYRO_ROUNDING);
    // nose up of the body is right side down for the sensor
    assert_close(sensors.attitude([0.0, 0.2, 0.0]), [0.2, 0.0, std::f64::consts::FRAC_PI_2], 1e-12);
}

/// The reported attitude belongs to the reported force: gravity seen from it is the accelerometer's reading at rest.
#[test]
fn a_misaligned_imu_reports_the_attitude_that_its_own_axes_have() {
    let (plant, mut sensors) = with_effects(&["imu_misalignment:yaw_rad=-0.4"]);
    let truth = plant.truth();
    let [roll, pitch, _] = sensors.attitude([truth.roll_rad, truth.pitch_rad, 0.0]);
    let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (libm::sincos(roll), libm::sincos(pitch));
    let expected = [9.81 * sin_pitch, -9.81 * cos_pitch * sin_roll, -9.81 * cos_pitch * cos_roll];
    assert_close(reported(&plant, &mut sensors).1, expected, ACCEL_ROUNDING);
    // and against rotations written with nalgebra
    let rotation = nalgebra::Rotation3::from_euler_angles(truth.roll_rad, truth.pitch_rad, 0.0)
        * nalgebra::Rotation3::from_euler_angles(0.0, 0.0, -0.4);
    let (expected_roll, expected_pitch, expected_yaw) = rotation.euler_angles();
    let ours = sensors.attitude([truth.roll_rad, truth.pitch_rad, 0.0]);
    assert_close(ours, [expected_roll, expected_pitch, expected_yaw], 1e-12);
}

#[test]
fn effects_of_the_plant_leave_the_sensors_as_they_are() {
    let (plant, mut sensors) =
        with_effects(&["spring:axis=roll,stiffness_nm_rad=0.1", "motor_lag:time_constant_s=0.1"]);
    assert_eq!(sensors.imu(&plant, 5), Sensors::ideal().imu(&plant, 5));
    assert_eq!(sensors.attitude_delay_s(), 0.0);
}
