//! The plant against physics: what must be conserved, and motions whose solution can be written down.

use proptest::prelude::*;

use super::{unpowered, world_from_body};
use crate::axis::Axis;
use crate::effects::{CgOffset, Effect};
use crate::model::{Mounting, Rig, VehicleModel};
use crate::plant::Plant;
use crate::vehicle::{BodyChange, Gimbal};

/// J(phi) and its derivative on the gimbal, as docs/rig.md writes them.
fn ring_and_body(model: &VehicleModel, roll_rad: f64) -> (f64, f64) {
    let [_, iyy, izz] = model.inertia_kg_m2;
    let Mounting::Gimbal { ring_inertia_kg_m2 } = model.mounting else { panic!("not the gimbal") };
    let (sin, cos) = libm::sincos(roll_rad);
    (ring_inertia_kg_m2 + iyy * cos * cos + izz * sin * sin, 2.0 * (izz - iyy) * sin * cos)
}

/// Kinetic energy on the gimbal, J.
fn gimbal_energy_j(model: &VehicleModel, plant: &Plant) -> f64 {
    let truth = plant.truth();
    let (j, _) = ring_and_body(model, truth.roll_rad);
    let [roll_rate, pitch_rate, _] = truth.euler_rate_rad_s;
    0.5 * model.inertia_kg_m2[0] * roll_rate * roll_rate + 0.5 * j * pitch_rate * pitch_rate
}

#[test]
fn the_free_body_conserves_energy_and_momentum() {
    let mut model = unpowered(Rig::Free);
    model.inertia_kg_m2 = [0.011, 0.014, 0.02];
    let Mounting::Free { mass_kg } = model.mounting else { panic!("not free") };
    let mut plant = Plant::new(&model);
    plant.set_attitude([0.2, -0.3, 0.4], [3.0, -2.0, 5.0]);
    let invariants = |plant: &Plant| {
        let truth = plant.truth();
        let rate = truth.rate_body_rad_s;
        let [ix, iy, iz] = model.inertia_kg_m2;
        let momentum = world_from_body(truth.q_world_from_body, [ix * rate[0], iy * rate[1], iz * rate[2]]);
        let rotation_j = 0.5 * (ix * rate[0] * rate[0] + iy * rate[1] * rate[1] + iz * rate[2] * rate[2]);
        let speed_square: f64 = truth.velocity_ned_m_s.iter().map(|v| v * v).sum();
        // height is minus the third coordinate
        let fall_j = 0.5 * mass_kg * speed_square - mass_kg * model.gravity_m_s2 * truth.position_ned_m[2];
        (rotation_j, momentum, fall_j)
    };
    let start = invariants(&plant);
    plant.advance(10.0);
    let end = invariants(&plant);
    // 20 000 steps of 0.5 ms at 6 rad/s err by (6 * 0.5e-3)^5 / 120 each, 4e-11 in all; ten times that is allowed
    assert!((end.0 / start.0 - 1.0).abs() < 4e-10, "rotation energy {} to {}", start.0, end.0);
    for axis in 0..3 {
        assert!((end.1[axis] - start.1[axis]).abs() < 4e-11, "momentum {:?} to {:?}", start.1, end.1);
    }
    // 5800 J of fall are gained and lost: rounding of 20 000 steps
    assert!((end.2 - start.2).abs() < 1e-7, "energy of the fall {} to {}", start.2, end.2);
    let length_square: f64 = plant.truth().q_world_from_body.iter().map(|component| component * component).sum();
    assert!((length_square - 1.0).abs() < 1e-15, "the quaternion keeps its length");
    // free fall: s = g t^2 / 2, and nothing is felt
    let truth = plant.truth();
    assert!((truth.position_ned_m[2] - 0.5 * model.gravity_m_s2 * 100.0).abs() < 1e-8);
    assert_eq!(truth.specific_force_body_m_s2, [0.0; 3]);
}

/// A symmetric body's rate turns about its axis of symmetry by `(I_zz - I_xx) / I_xx * r` (Goldstein, Classical
/// Mechanics, 5.6).
#[test]
fn the_symmetric_free_body_precesses_at_the_analytic_rate() {
    let model = unpowered(Rig::Free);
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    assert_eq!(ixx, iyy);
    let mut plant = Plant::new(&model);
    let (p, r) = (1.5, 8.0);
    plant.set_attitude([0.0; 3], [p, 0.0, r]);
    let precession_rad_s = (izz - ixx) / ixx * r;
    for second in 1..=5 {
        plant.advance(1.0);
        let (sin, cos) = libm::sincos(precession_rad_s * f64::from(second));
        let rate = plant.rate_body_rad_s();
        for (ours, expected) in rate.into_iter().zip([p * cos, p * sin, r]) {
            // 5.9 rad/s in steps of 0.5 ms: (3e-3)^5 / 120 of phase a step, 2e-11 in five seconds
            assert!((ours - expected).abs() < 1e-9, "{second} s: {rate:?}");
        }
    }
}

#[test]
fn the_gimbal_without_torque_conserves_energy_and_the_momentum_about_pitch() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    // all motors alike: lift is there, torque is not
    let mut plant = Plant::new(&model);
    plant.set_attitude([0.3, 0.2, 0.0], [2.0, 4.0 * libm::cos(0.3), -4.0 * libm::sin(0.3)]);
    let momentum = |plant: &Plant| {
        let truth = plant.truth();
        ring_and_body(&model, truth.roll_rad).0 * truth.euler_rate_rad_s[1]
    };
    let (energy_j, momentum_nms) = (gimbal_energy_j(&model, &plant), momentum(&plant));
    let mut pitch_rates = [f64::INFINITY, f64::NEG_INFINITY];
    for _ in 0..100 {
        plant.advance(0.05);
        // p theta = J(phi) theta' is conserved because theta stands nowhere in the energy; error as for the free body
        assert!((gimbal_energy_j(&model, &plant) / energy_j - 1.0).abs() < 1e-10);
        assert!((momentum(&plant) / momentum_nms - 1.0).abs() < 1e-10);
        let pitch_rate = plant.truth().euler_rate_rad_s[1];
        pitch_rates = [pitch_rates[0].min(pitch_rate), pitch_rates[1].max(pitch_rate)];
    }
    // the coupling was at work: J varies by a fifth with roll
    assert!(pitch_rates[1] > 1.1 * pitch_rates[0], "{pitch_rates:?}");
}

/// A gimbal with these effects, at an attitude, at rest.
fn hung(effects: &[CgOffset], roll_rad: f64, pitch_rad: f64) -> (VehicleModel, Plant) {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    model.effects = effects.iter().copied().map(Effect::CgOffset).collect();
    let mut plant = Plant::new(&model);
    plant.set_attitude([roll_rad, pitch_rad, 0.0], [0.0; 3]);
    (model, plant)
}

const RING: CgOffset = CgOffset { axis: Axis::Pitch, cos_moment_nm: 0.1, sin_moment_nm: 0.05 };
const BODY: CgOffset = CgOffset { axis: Axis::Roll, cos_moment_nm: -0.06, sin_moment_nm: 0.12 };

/// Potential energy as the height of the mass: for the body `-m g` times the world's down component of (0, y, z), for
/// the ring of (x, 0, z), which does not roll.
fn potential_j(effects: &[CgOffset], plant: &Plant) -> f64 {
    let truth = plant.truth();
    let (sin_theta, cos_theta) = libm::sincos(truth.pitch_rad);
    let down = |effect: &CgOffset| match effect.axis {
        Axis::Roll => {
            let offset = [0.0, effect.cos_moment_nm, effect.sin_moment_nm];
            world_from_body(truth.q_world_from_body, offset)[2]
        }
        _ => -effect.cos_moment_nm * sin_theta + effect.sin_moment_nm * cos_theta,
    };
    -effects.iter().map(down).sum::<f64>()
}

#[test]
fn the_gimbal_swings_as_a_pendulum_and_conserves_energy() {
    for effects in [vec![RING], vec![BODY], vec![RING, BODY]] {
        let (model, mut plant) = hung(&effects, 1.0, 0.7);
        let start = gimbal_energy_j(&model, &plant) + potential_j(&effects, &plant);
        let mut fastest = 0.0_f64;
        for _ in 0..100 {
            plant.advance(0.05);
            let energy = gimbal_energy_j(&model, &plant) + potential_j(&effects, &plant);
            // 5 rad/s in steps of 0.5 ms over 5 s: 1e-11 of some 0.1 J
            assert!((energy - start).abs() < 1e-10, "{effects:?}: {start} to {energy}");
            fastest = fastest.max(gimbal_energy_j(&model, &plant));
        }
        assert!(fastest > 0.05, "it did swing: {fastest} J");
    }
}

#[test]
fn an_offset_centre_hangs_at_its_analytic_angle_and_swings_at_its_analytic_frequency() {
    let small = 1e-3;
    for (effect, expected_angle) in [
        // C cos theta + S sin theta = 0, stable where S cos theta > C sin theta
        (RING, libm::atan2(-RING.cos_moment_nm, RING.sin_moment_nm)),
        (BODY, libm::atan2(BODY.cos_moment_nm, BODY.sin_moment_nm)),
        // the thesis' ring: pulled to -90 degrees
        (CgOffset { sin_moment_nm: 0.0, ..RING }, -std::f64::consts::FRAC_PI_2),
    ] {
        let place = |angle: f64| if effect.axis == Axis::Roll { (angle, 0.0) } else { (0.0, angle) };
        let angle_of = |plant: &Plant| {
            let truth = plant.truth();
            if effect.axis == Axis::Roll { truth.roll_rad } else { truth.pitch_rad }
        };
        let (roll, pitch) = place(expected_angle);
        let (model, mut resting) = hung(&[effect], roll, pitch);
        resting.advance(2.0);
        assert!((angle_of(&resting) - expected_angle).abs() < 1e-12, "{effect:?} does not rest");

        let stiffness = libm::hypot(effect.cos_moment_nm, effect.sin_moment_nm);
        let inertia = if effect.axis == Axis::Roll { model.inertia_kg_m2[0] } else { ring_and_body(&model, 0.0).0 };
        let frequency_rad_s = (stiffness / inertia).sqrt();
        let (roll, pitch) = place(expected_angle + small);
        let (_, mut swinging) = hung(&[effect], roll, pitch);
        swinging.advance(1.7);
        let expected = expected_angle + small * libm::cos(frequency_rad_s * 1.7);
        // a pendulum's period grows by amplitude^2 / 16: phase errs by 4e-7 rad, angle by 1e-3 times that
        assert!(
            (angle_of(&swinging) - expected).abs() < 1e-9,
            "{effect:?}: {} against {expected}",
            angle_of(&swinging)
        );
    }
}

/// Error against a much finer step, for the given step, over a manoeuvre with everything in motion.
fn integration_error(model: &VehicleModel, step_s: f64) -> f64 {
    let end = |step_s: f64| {
        let mut plant = Plant::new(model);
        plant.set_step_max_s(step_s);
        plant.set_attitude([0.4, -0.3, 0.1], [6.0, -4.0, 5.0]);
        plant.set_commands([0.7, 0.4, 0.5, 0.6]);
        plant.advance(0.064);
        plant.truth()
    };
    let (coarse, fine) = (end(step_s), end(step_s / 64.0));
    let rates = coarse.rate_body_rad_s.iter().zip(&fine.rate_body_rad_s);
    rates.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[test]
fn halving_the_step_divides_the_error_by_sixteen() {
    for rig in [Rig::Gimbal, Rig::Free] {
        let mut model = VehicleModel::nominal(rig);
        model.effects = vec![Effect::CgOffset(RING), Effect::CgOffset(BODY)];
        let (coarse, fine) = (integration_error(&model, 0.5e-3), integration_error(&model, 0.25e-3));
        let ratio = coarse / fine;
        // 16 in the limit; the next order of the fastest motor mode shifts it by its share, step times 600 rad/s
        assert!((12.0..22.0).contains(&ratio), "{rig:?}: {coarse:e} over {fine:e} is {ratio}");
        assert!(coarse < 1e-4, "{rig:?}: rates are known to {coarse:e} rad/s at the default step");
    }
}

proptest! {
    /// The accelerations against Lagrange's equations, all derivatives of the kinetic energy taken numerically from its
    /// definition: the body's by its angular rate, the ring's by its own.
    #[test]
    fn gimbal_accelerations_obey_lagranges_equations(
        roll in -1.5..1.5_f64, roll_rate in -5.0..5.0_f64, pitch_rate in -5.0..5.0_f64,
        tau_x in -1.0..1.0_f64, tau_y in -1.0..1.0_f64, tau_z in -1.0..1.0_f64,
    ) {
        let model = VehicleModel::nominal(Rig::Gimbal);
        let [ixx, iyy, izz] = model.inertia_kg_m2;
        let Mounting::Gimbal { ring_inertia_kg_m2: ring } = model.mounting else { panic!("not the gimbal") };
        // the body's rate: roll about its own x axis, pitch about the ring's y axis, which roll has turned
        let energy = |roll: f64, roll_rate: f64, pitch_rate: f64| {
            let ring_y_in_body = [0.0, libm::cos(roll), -libm::sin(roll)];
            let [p, q, r] = [roll_rate, pitch_rate * ring_y_in_body[1], pitch_rate * ring_y_in_body[2]];
            0.5 * (ixx * p * p + iyy * q * q + izz * r * r) + 0.5 * ring * pitch_rate * pitch_rate
        };
        // central differences; second derivatives of a function quadratic in the rates and smooth in roll
        let h = 1e-4;
        let by_roll = |f: &dyn Fn(f64) -> f64| (f(roll + h) - f(roll - h)) / (2.0 * h);
        let by_roll_rate = |roll: f64, u: f64, v: f64| (energy(roll, u + h, v) - energy(roll, u - h, v)) / (2.0 * h);
        let by_pitch_rate = |roll: f64, u: f64, v: f64| (energy(roll, u, v + h) - energy(roll, u, v - h)) / (2.0 * h);
        // virtual work of a body torque: roll turns about body x, pitch about the ring's y axis
        let force = [tau_x, tau_y * libm::cos(roll) - tau_z * libm::sin(roll)];
        // d/dt (dT/dphi') = T_(phi' phi') phi'' + T_(phi' phi) phi' = dT/dphi + Q_phi; likewise for theta
        let mass_roll = by_roll_rate(roll, 1.0, 0.0);
        let mass_pitch = by_pitch_rate(roll, 0.0, 1.0);
        let roll_acceleration = (force[0] + by_roll(&|x| energy(x, roll_rate, pitch_rate))
            - by_roll(&|x| by_roll_rate(x, roll_rate, pitch_rate)) * roll_rate) / mass_roll;
        let pitch_acceleration =
            (force[1] - by_roll(&|x| by_pitch_rate(x, roll_rate, pitch_rate)) * roll_rate) / mass_pitch;

        let gimbal = Gimbal::new(model.inertia_kg_m2, ring, &BodyChange::default());
        let (attitude, moment_nm) = (libm::sincos(roll), Gimbal::moment_nm(libm::sincos(roll), [tau_x, tau_y, tau_z]));
        let ours = gimbal.acceleration_rad_s2(attitude, [roll_rate, pitch_rate], moment_nm);
        // h^2 / 6 of the third derivative (1e-8 relative) and rounding 1e-16 / h^2 of T, over an inertia of 0.01
        prop_assert!((ours[0] - roll_acceleration).abs() < 1e-4, "{} against {}", ours[0], roll_acceleration);
        prop_assert!((ours[1] - pitch_acceleration).abs() < 1e-4, "{} against {}", ours[1], pitch_acceleration);
    }
}
