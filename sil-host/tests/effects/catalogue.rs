//! The effects, one by one.

use rayon::prelude::*;
use sil_host::effects::Effect;
use sil_host::model::{self, SensorNoise, VehicleModel};
use sil_host::plant::Plant;
use sil_host::sensors::{Sensors, imu};
use sil_host::synthesis::Synthesis;

use crate::checks::{Case, the_plant_moves_as_the_page_says, the_prediction_expects_what_the_page_says};
use crate::reference::{GRAVITY_M_S2, MASS_KG, Moving, NOMINAL, Page, Rig::Free, Rig::Gimbal, rotation};

/// Those that act on the motion.
fn of_motion() -> Vec<Case> {
    [of_rig(), of_body(), of_actuators(), of_surroundings()].into_iter().flatten().collect()
}

fn page(moment: fn(&Moving) -> [f64; 3]) -> Page {
    Page { moment, ..NOMINAL }
}

fn lift(lift: fn(f64, f64, f64) -> [f64; 4]) -> Page {
    Page { lift, ..NOMINAL }
}

/// Moments of the rig and of gravity.
fn of_rig() -> Vec<Case> {
    let case = Case::of;
    vec![
        case(
            Gimbal,
            "cg_offset:axis=pitch,cos_moment_nm=0.04,sin_moment_nm=0.05",
            page(|m| {
                let (sin, cos) = m.angle[1].sin_cos();
                [0.0, -(0.04 * cos + 0.05 * sin), 0.0]
            }),
        ),
        case(
            Gimbal,
            "cg_offset:axis=roll,cos_moment_nm=0.02,sin_moment_nm=0.06",
            page(|m| {
                let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (m.angle[0].sin_cos(), m.angle[1].sin_cos());
                let (c, s) = (0.02, 0.06);
                [cos_theta * (c * cos_phi - s * sin_phi), -sin_theta * (c * sin_phi + s * cos_phi), 0.0]
            }),
        ),
        case(
            Free,
            "cg_offset:axis=roll,cos_moment_nm=0.02",
            page(|m| [0.02 * m.lift_n / (MASS_KG * GRAVITY_M_S2), 0.0, 0.0]),
        ),
        case(
            Free,
            "cg_offset:axis=pitch,cos_moment_nm=0.02",
            page(|m| [0.0, -0.02 * m.lift_n / (MASS_KG * GRAVITY_M_S2), 0.0]),
        ),
        case(Gimbal, "torque_bias:axis=roll,torque_nm=0.02", page(|_| [0.02, 0.0, 0.0])),
        case(Free, "torque_bias:axis=yaw,torque_nm=-0.01", page(|_| [0.0, 0.0, -0.01])),
        case(Gimbal, "viscous_friction:axis=pitch,coefficient_nms=0.05", page(|m| [0.0, -0.05 * m.rate[1], 0.0])),
        case(Free, "viscous_friction:axis=yaw,coefficient_nms=0.03", page(|m| [0.0, 0.0, -0.03 * m.rate[2]])),
        case(
            Gimbal,
            "coulomb_friction:axis=pitch,torque_nm=0.01",
            page(|m| [0.0, -0.01 * (m.rate[1] / 0.02).tanh(), 0.0]),
        ),
        case(
            Free,
            "coulomb_friction:axis=roll,torque_nm=0.003",
            page(|m| [-0.003 * (m.rate[0] / 0.02).tanh(), 0.0, 0.0]),
        ),
        case(
            Gimbal,
            "spring:axis=pitch,stiffness_nm_rad=0.2,rest_rad=0.1",
            page(|m| [0.0, -0.2 * (m.angle[1] - 0.1), 0.0]),
        ),
        case(
            Free,
            "spring:axis=yaw,stiffness_nm_rad=0.05,rest_rad=-0.2",
            page(|m| [0.0, 0.0, -0.05 * (m.angle[2] + 0.2)]),
        ),
    ]
}

/// Mass and inertia.
fn of_body() -> Vec<Case> {
    let case = Case::of;
    vec![
        case(Gimbal, "inertia_error:axis=roll,scale=1.3", Page { inertia: [1.3, 1.0, 1.0], ..NOMINAL }),
        case(Gimbal, "inertia_error:axis=pitch,scale=0.8", Page { inertia: [1.0, 0.8, 1.0], ..NOMINAL }),
        case(Free, "inertia_error:axis=yaw,scale=1.4", Page { inertia: [1.0, 1.0, 1.4], ..NOMINAL }),
        case(Gimbal, "inertia_coupling:product_kg_m2=0.004", Page { product: 0.004, ..NOMINAL }),
        case(Free, "inertia_coupling:product_kg_m2=-0.004", Page { product: -0.004, ..NOMINAL }),
        case(
            Free,
            "rotor_inertia:inertia_kg_m2=0.0002",
            Page {
                moment: |m| {
                    let (h, change) = (2e-4 * spin(m.rotor_speed), 2e-4 * spin(m.rotor_acceleration));
                    [-m.rate[1] * h, m.rate[0] * h, -change]
                },
                rotor_lag_s: 0.05,
                ..NOMINAL
            },
        ),
        case(
            Gimbal,
            "rotor_inertia:inertia_kg_m2=0.0002",
            Page {
                moment: |m| {
                    let (h, change) = (2e-4 * spin(m.rotor_speed), 2e-4 * spin(m.rotor_acceleration));
                    let (sin_phi, cos_phi) = m.angle[0].sin_cos();
                    [-h * m.rate[1] * cos_phi, change * sin_phi + h * m.rate[0] * cos_phi, 0.0]
                },
                rotor_lag_s: 0.05,
                ..NOMINAL
            },
        ),
        case(Free, "mass_error:scale=1.05", Page { mass: 1.05, ..NOMINAL }),
    ]
}

/// About z, down: motors 1 and 2 turn counter-clockwise seen from above, 3 and 4 clockwise.
fn spin([w1, w2, w3, w4]: [f64; 4]) -> f64 {
    -w1 - w2 + w3 + w4
}

/// From command to lift.
fn of_actuators() -> Vec<Case> {
    let case = Case::of;
    vec![
        case(Gimbal, "motor_lag:time_constant_s=0.03", Page { lag_s: 0.03, ..NOMINAL }),
        case(Gimbal, "actuation_delay:delay_s=0.0123", Page { delay_s: 0.0123, ..NOMINAL }),
        case(Free, "thrust_scale:scale=0.93", lift(|_, _, _| [0.93; 4])),
        case(Gimbal, "weak_motor:motor=3,scale=0.95", lift(|_, _, _| [1.0, 1.0, 0.95, 1.0])),
        case(Free, "weak_motor:motor=4,scale=1.04", lift(|_, _, _| [1.0, 1.0, 1.0, 1.04])),
        case(Free, "battery_sag:per_s=0.01", lift(|t, _, _| [1.0 - 0.01 * t; 4])),
        Case {
            fall_v_s: 0.05,
            // V0: the mean of the first second, half a second of fall
            ..case(
                Free,
                "battery_sag:per_volt=0.2,fall_v_s=0.05",
                lift(|_, v, _| [1.0 - 0.2 * (12.0 - 0.05 * 0.5 - v); 4]),
            )
        },
        case(Gimbal, "command_clipping:min=0.48,max=0.5", Page { range: [0.48, 0.5], ..NOMINAL }),
        case(Gimbal, "thrust_curve:expo=0.1", Page { acts_as: |u| 0.9 * u + 0.1 * u * u, ..NOMINAL }),
        case(
            Free,
            "thrust_curve:expo=-0.2,fixed_at=0.4",
            Page { acts_as: |u| u * (1.2 - 0.2 * u) / (1.2 - 0.2 * 0.4), rotor_lag_s: 0.05, ..NOMINAL },
        ),
    ]
}

/// From outside.
fn of_surroundings() -> Vec<Case> {
    let case = Case::of;
    vec![
        case(
            Gimbal,
            "periodic_disturbance:axis=roll,amplitude_nm=0.01,frequency_hz=1.7,phase_rad=0.5",
            page(|m| [0.01 * (std::f64::consts::TAU * 1.7 * m.time_s + 0.5).sin(), 0.0, 0.0]),
        ),
        // on a step of the reference, off the rows
        case(
            Gimbal,
            "step_disturbance:axis=pitch,torque_nm=0.05,start_s=4.0021",
            page(|m| [0.0, if m.step_start_s >= 4.0021 - 1e-9 { 0.05 } else { 0.0 }, 0.0]),
        ),
        case(Free, "speed_stability:coefficient_ns=0.01", page(|m| [-0.01 * m.against[1], 0.01 * m.against[0], 0.0])),
        case(Free, "rotor_drag:coefficient_ns_m=0.4", Page { force: |v| [-0.4 * v[0], -0.4 * v[1], 0.0], ..NOMINAL }),
        case(
            Free,
            "wind:north_m_s=3,east_m_s=-2,drag_area_m2=0.05",
            Page {
                wind: [3.0, -2.0, 0.0],
                force: |v| {
                    let speed = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
                    v.map(|component| -0.5 * 1.225 * 0.05 * speed * component)
                },
                ..NOMINAL
            },
        ),
        Case {
            start_height: 0.5,
            ..case(
                Free,
                "ground_effect:height_m=0.5,rotor_radius_m=0.2",
                lift(|_, _, height| {
                    let ratio = 0.2 / (4.0 * height.max(0.1));
                    [1.0 / (1.0 - ratio * ratio); 4]
                }),
            )
        },
    ]
}

/// Those that act on what is reported of it.
fn of_sensors() -> Vec<Case> {
    let case = Case::of;
    vec![
        case(
            Gimbal,
            "gyro_bias:axis=pitch,bias_rad_s=0.03",
            Page { reported_rate: |[p, q, r]| [p, q + 0.03, r], ..NOMINAL },
        ),
        case(Free, "gyro_scale:axis=roll,scale=1.08", Page { reported_rate: |[p, q, r]| [1.08 * p, q, r], ..NOMINAL }),
        case(Gimbal, "attitude_delay:delay_s=0.02", Page { angle_delay_s: 0.02, ..NOMINAL }),
        case(
            Free,
            "imu_misalignment:yaw_rad=0.1",
            Page {
                reported_rate: turned,
                reported_force: turned,
                reported_angle: |angle| {
                    let sensor = rotation(angle) * rotation([0.0, 0.0, 0.1]);
                    let (roll, pitch, yaw) = nalgebra::Rotation3::from_matrix_unchecked(sensor).euler_angles();
                    [roll, pitch, yaw]
                },
                ..NOMINAL
            },
        ),
    ]
}

/// A vector of the body in the axes of a sensor that is turned by 0.1 rad from forward to right.
fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = 0.1f64.sin_cos();
    [cos * x + sin * y, -sin * x + cos * y, z]
}

#[test]
fn the_plant_moves_as_every_page_says() {
    of_motion().par_iter().for_each(the_plant_moves_as_the_page_says);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn the_prediction_expects_what_every_page_says() {
    let (motion, sensors) = (of_motion(), of_sensors());
    motion.par_iter().chain(&sensors).for_each(the_prediction_expects_what_the_page_says);
}

#[test]
fn no_effect_of_the_catalogue_is_without_its_page() {
    let mut tested: Vec<&str> =
        of_motion().iter().chain(&of_sensors()).map(|case| case.model().effects[0].name()).collect();
    // shaken.rs
    tested.push("rotor_vibration");
    for entry in Effect::CATALOGUE {
        assert!(tested.contains(&entry.name), "{} has no case here: docs/recipes.md, \"An effect\"", entry.name);
    }
}

/// Rates and specific force to half a count of the chip.
#[test]
fn the_sensors_report_as_their_pages_say() {
    for case in of_sensors() {
        let model = case.model();
        let mut plant = Plant::new(&VehicleModel { effects: Vec::new(), ..model.clone() });
        let (angle, rate) = ([0.4, -0.3, 0.9], [0.8, -0.6, 0.5]);
        plant.set_attitude(angle, rate);
        let truth = plant.truth();
        let mut sensors = Sensors::new(&SensorNoise::NONE, 0).with_effects(&model.effects);
        let sample = sensors.imu_of(&truth);
        let page = [
            (sample.gyro_counts, (case.page.reported_rate)(truth.rate_body_rad_s), imu::GYRO_COUNTS_PER_RAD_S),
            (
                sample.accel_counts,
                (case.page.reported_force)(truth.specific_force_body_m_s2),
                imu::ACCEL_COUNTS_PER_M_S2,
            ),
        ];
        for (counts, page, per_unit) in page {
            for (counts, page) in counts.into_iter().zip(imu::sensor_from_body(page)) {
                assert!((f64::from(counts) - page * per_unit).abs() < 0.5001, "{}: {counts} {page}", case.short);
            }
        }
        let reported = sensors.attitude([truth.roll_rad, truth.pitch_rad, truth.yaw_rad]);
        for (ours, page) in reported.into_iter().zip((case.page.reported_angle)(truth_angles(&truth))) {
            assert!((ours - page).abs() < 1e-12, "{}: {ours} {page}", case.short);
        }
        assert_eq!(sensors.attitude_delay_s(), case.page.angle_delay_s);
    }
}

fn truth_angles(truth: &sil_host::plant::Truth) -> [f64; 3] {
    [truth.roll_rad, truth.pitch_rad, truth.yaw_rad]
}

/// The controller makes its own attitude of the gyro, so that a late attitude changes nothing but the log's angles.
#[test]
fn a_late_attitude_is_the_one_of_earlier_rows() {
    let log = |effect: Option<&str>| {
        let mut model = VehicleModel::nominal(model::Rig::Gimbal);
        model.noise = SensorNoise::NONE;
        model.effects.extend(effect.map(|short| Effect::parse(short, model::Rig::Gimbal).unwrap()));
        Synthesis { duration_s: 4.0, ..Synthesis::of(model) }.log().unwrap()
    };
    let (prompt, late) = (log(None), log(Some("attitude_delay:delay_s=0.02")));
    assert_eq!(prompt.rate_rad_s, late.rate_rad_s);
    for axis in 0..2 {
        let (prompt, late) = (prompt.angle_rad[axis].as_ref().unwrap(), late.angle_rad[axis].as_ref().unwrap());
        assert!(prompt.iter().any(|angle| angle.abs() > 0.1) || axis == 1);
        // 200 rows a second
        assert_eq!(prompt[..prompt.len() - 4], late[4..]);
    }
}
