//! Rotors that shake the IMU, against the equations of docs/effects.md, "Vibration".

use std::f64::consts::{FRAC_PI_4, TAU};

use sil_host::effects::Effect;
use sil_host::model::{Rig, SensorNoise, VehicleModel};
use sil_host::plant::{Plant, Truth};
use sil_host::sensors::{Sensors, imu};

const SHAKEN: &str = "rotor_vibration:peak_m_s2=30,peak_rad_s=0.4,at_rad_s=900";

fn shaken(rig: Rig) -> (Plant, Sensors) {
    let mut model = VehicleModel::nominal(rig);
    model.effects = vec![Effect::parse(SHAKEN, rig).unwrap()];
    (Plant::new(&model), Sensors::new(&SensorNoise::NONE, 0).with_effects(&model.effects))
}

/// What the page adds to rate and specific force.
fn of_the_page(truth: &Truth) -> ([f64; 3], [f64; 3]) {
    let left = |line_rad_s: f64, cutoff_hz: f64| (1.0 + (line_rad_s / (TAU * cutoff_hz)).powi(4)).sqrt().recip();
    let (mut rate, mut force) = ([0.0; 3], [0.0; 3]);
    let bearings = [1.0, -3.0, -1.0, 3.0].map(|quarter: f64| quarter * FRAC_PI_4);
    for ((w, psi), alpha) in truth.motor_speed_rad_s.into_iter().zip(truth.rotor_phase_rad.unwrap()).zip(bearings) {
        let (a, r) = (30.0 / 4.0 * (w / 900.0).powi(2), 0.4 / 4.0 * (w / 900.0));
        for (n, s) in [(1.0, 1.0), (2.0, 0.3), (3.0, 0.1)] {
            force[0] += a * s * left(n * w, 260.0) * (n * psi).cos();
            force[1] += a * s * left(n * w, 260.0) * (n * psi).sin();
            rate[0] += r * s / n * left(n * w, 256.0) * (n * psi).cos();
            rate[1] += r * s / n * left(n * w, 256.0) * (n * psi).sin();
            rate[2] += r * s / n * left(n * w, 256.0) * (n * psi - alpha).sin();
        }
        force[2] += a * left(2.0 * w, 260.0) * (2.0 * psi).cos();
    }
    (rate, force)
}

#[test]
fn the_imu_reports_what_the_page_says() {
    for rig in [Rig::Gimbal, Rig::Free] {
        let (mut plant, mut sensors) = shaken(rig);
        for k in 0..400u64 {
            plant.set_commands([0.5, 0.45, 0.55, if k < 200 { 0.5 } else { 0.6 }]);
            plant.advance(1e-3);
            let truth = plant.truth();
            let (rate, force) = of_the_page(&truth);
            let sample = sensors.imu(&plant, k);
            assert_eq!(sensors.imu_of(&Truth { time_s: k as f64 * 1e-6, ..truth }), sample);
            for (counts, shake, true_value, per_unit) in [
                (sample.gyro_counts, rate, truth.rate_body_rad_s, imu::GYRO_COUNTS_PER_RAD_S),
                (sample.accel_counts, force, truth.specific_force_body_m_s2, imu::ACCEL_COUNTS_PER_M_S2),
            ] {
                let expected = imu::sensor_from_body([0, 1, 2].map(|axis| true_value[axis] + shake[axis]));
                for (counts, expected) in counts.into_iter().zip(expected) {
                    // half a count, and rounding
                    assert!((f64::from(counts) - expected * per_unit).abs() < 0.5001, "{counts} {expected}");
                }
            }
        }
    }
}

/// A rotor's angle is the integral of its speed, on its way from one speed to another too: against one thousand steps
/// where the plant takes one.
#[test]
fn a_rotors_angle_is_the_integral_of_its_speed() {
    let (mut coarse, _) = shaken(Rig::Free);
    let mut fine = coarse.clone();
    assert_eq!(coarse.truth().rotor_phase_rad, None, "nothing turns before the clock does");
    let first = [0.0, 1.3, 2.9, 4.4];
    let mut turned = [0.0; 4];
    for command in [0.5, 0.6, 0.4] {
        for plant in [&mut coarse, &mut fine] {
            plant.set_commands([command; 4]);
        }
        for _ in 0..20 {
            coarse.advance(2.5e-3);
            for _ in 0..1000 {
                let before = fine.motor_speed_rad_s();
                fine.advance(2.5e-6);
                let after = fine.motor_speed_rad_s();
                (0..4).for_each(|motor| turned[motor] += 0.5 * (before[motor] + after[motor]) * 2.5e-6);
            }
        }
    }
    for motor in 0..4 {
        let error = (coarse.truth().rotor_phase_rad.unwrap()[motor] - first[motor] - turned[motor]).rem_euclid(TAU);
        // the bend of the speed within a step, w'' T^3 / 12, is 5e-4 rad in the first step of each change
        assert!(error.min(TAU - error) < 5e-3, "motor {motor}: {error}");
    }
}

/// Two of them add up, as all effects do; of no strength they change nothing.
#[test]
fn shaking_adds_up() {
    let reading = |effects: &[&str]| {
        let mut model = VehicleModel::nominal(Rig::Free);
        model.effects = effects.iter().map(|short| Effect::parse(short, Rig::Free).unwrap()).collect();
        let (mut plant, mut sensors) =
            (Plant::new(&model), Sensors::new(&SensorNoise::NONE, 0).with_effects(&model.effects));
        plant.advance(7e-3);
        sensors.imu(&plant, 0)
    };
    let whole = reading(&["rotor_vibration:peak_m_s2=40,peak_rad_s=0.2,at_rad_s=500"]);
    // the same at twice the speed: four times the force, twice the rate
    let half = "rotor_vibration:peak_m_s2=80,peak_rad_s=0.2,at_rad_s=1000";
    assert_eq!(reading(&[half, half]), whole);
    assert_eq!(reading(&["rotor_vibration:peak_m_s2=0"]), reading(&[]));
    assert_ne!(whole, reading(&[]));
}
