//! Each effect on the gimbal against a motion whose solution can be written down. The integrator's error is below 1e-10
//! (tolerance 1e-12 a step, some hundred steps); what a test allows beyond is said there.

use super::{close, unpowered, with_effects};
use crate::model::{Mounting, Rig, VehicleModel};
use crate::plant::Plant;
use crate::vehicle::propulsion::Propulsion;

const IXX: f64 = 0.011_511_8;
/// About pitch, level: ring and body.
const J: f64 = 0.036_565_1;

fn gimbal(effects: &[&str]) -> Plant {
    with_effects(unpowered(Rig::Gimbal), effects)
}

#[test]
fn a_constant_moment_accelerates_evenly() {
    let mut plant = gimbal(&["torque_bias:axis=pitch,torque_nm=0.01"]);
    plant.advance(1.3);
    assert!(close(plant.truth().pitch_rad, 0.5 * 0.01 / J * 1.3 * 1.3, 1e-10));
    assert_eq!(plant.truth().roll_rad, 0.0);
}

#[test]
fn viscous_friction_slows_exponentially() {
    for (effect, inertia, axis) in [
        ("viscous_friction:axis=roll,coefficient_nms=0.01", IXX, 0),
        ("viscous_friction:axis=pitch,coefficient_nms=0.01", J, 1),
    ] {
        let mut plant = gimbal(&[effect]);
        let mut rate = [0.0; 3];
        rate[axis] = 2.0;
        plant.set_attitude([0.0; 3], rate);
        plant.advance(0.7);
        let expected = 2.0 * libm::exp(-0.01 * 0.7 / inertia);
        assert!(close(plant.rate_body_rad_s()[axis], expected, 1e-10), "{effect}");
    }
}

#[test]
fn dry_friction_slows_evenly_and_holds() {
    let mut plant = gimbal(&["coulomb_friction:axis=roll,torque_nm=0.01"]);
    plant.set_attitude([0.0; 3], [1.0, 0.0, 0.0]);
    plant.advance(0.5);
    // far above 0.02 rad/s the hyperbolic tangent is 1 to e^-50
    assert!(close(plant.rate_body_rad_s()[0], 1.0 - 0.01 / IXX * 0.5, 1e-10));
    // below, w' = -(c/I) tanh(w/s) has the solution sinh(w/s) = sinh(w0/s) e^(-c t/(I s))
    plant.set_attitude([0.0; 3], [0.05, 0.0, 0.0]);
    plant.advance(0.06);
    let sinh = libm::sinh(0.05 / 0.02) * libm::exp(-0.01 / IXX * 0.06 / 0.02);
    assert!(close(plant.rate_body_rad_s()[0], 0.02 * libm::asinh(sinh), 1e-10));
}

#[test]
fn a_spring_swings_at_its_frequency_about_its_rest() {
    let mut plant = gimbal(&["spring:axis=pitch,stiffness_nm_rad=0.5,rest_rad=0.1"]);
    plant.set_attitude([0.0, 0.6, 0.0], [0.0; 3]);
    for step in 1..=20 {
        plant.advance(0.11);
        let expected = 0.1 + 0.5 * libm::cos((0.5 / J).sqrt() * 0.11 * f64::from(step));
        assert!(close(plant.truth().pitch_rad, expected, 1e-10), "{step}");
    }
}

/// `J theta'' + b theta' + k theta = A sin(w t)` has in steady state the amplitude A over the modulus of `k - J w^2 + j
/// b w`.
#[test]
fn a_periodic_torque_swings_a_damped_spring_with_the_amplitude_of_the_steady_state() {
    let (k, b, amplitude_nm, frequency_hz) = (0.5, 0.1, 0.02, 1.3);
    let mut plant = gimbal(&[
        "spring:axis=pitch,stiffness_nm_rad=0.5",
        "viscous_friction:axis=pitch,coefficient_nms=0.1",
        "periodic_disturbance:axis=pitch,amplitude_nm=0.02,frequency_hz=1.3,phase_rad=0.4",
    ]);
    // the transient decays by b / 2J = 1.4 /s: to 1e-12 in 20 s
    plant.advance(20.0);
    let omega = core::f64::consts::TAU * frequency_hz;
    let (stiff, damped) = (k - J * omega * omega, b * omega);
    let amplitude_rad = amplitude_nm / libm::hypot(stiff, damped);
    for _ in 0..10 {
        plant.advance(0.07);
        let phase = omega * plant.time_s() + 0.4 - libm::atan2(damped, stiff);
        assert!(close(plant.truth().pitch_rad, amplitude_rad * libm::sin(phase), 1e-10));
    }
}

/// The onset lies between the control steps and between the integrator's, in both methods.
#[test]
fn a_step_of_torque_sets_in_at_its_very_time() {
    for adaptive in [false, true] {
        let mut model = unpowered(Rig::Gimbal);
        let effect = "step_disturbance:axis=pitch,torque_nm=0.05,start_s=0.10137";
        model.effects = vec![crate::effects::Effect::parse(effect, Rig::Gimbal).unwrap()];
        let mut plant = Plant::new(&model);
        if adaptive {
            plant.integrate_adaptively(1e-12);
        }
        for _ in 0..80 {
            plant.advance(2.5e-3);
        }
        let since_s = 0.2 - 0.10137;
        // uniform acceleration, which both methods integrate exactly
        assert!(close(plant.truth().pitch_rad, 0.5 * 0.05 / J * since_s * since_s, 1e-13));
        assert!(close(plant.truth().euler_rate_rad_s[1], 0.05 / J * since_s, 1e-12));
    }
}

#[test]
fn a_larger_inertia_accelerates_less() {
    for (axis, name, inertia) in [(0, "roll", IXX), (1, "pitch", J)] {
        let bias = format!("torque_bias:axis={name},torque_nm=0.01");
        let error = format!("inertia_error:axis={name},scale=1.25");
        let mut plant = gimbal(&[&bias, &error]);
        plant.advance(0.8);
        assert!(close(plant.truth().euler_rate_rad_s[axis], 0.01 / (1.25 * inertia) * 0.8, 1e-10));
    }
}

/// Kinetic energy with scaled inertias and with `P p q`, and the momentum about pitch, which no torque changes: J(phi)
/// and its slope must be scaled alike, and the coupling have the term that the rotating axes bring.
#[test]
fn changed_inertias_conserve_energy_and_the_momentum_about_pitch() {
    for (effects, scales, product) in [
        (&["inertia_error:axis=roll,scale=0.8", "inertia_error:axis=pitch,scale=1.4"][..], [0.8, 1.4], 0.0),
        (&["inertia_coupling:product_kg_m2=0.004"], [1.0, 1.0], 0.004),
        (&["inertia_error:axis=pitch,scale=0.7", "inertia_coupling:product_kg_m2=-0.003"], [1.0, 0.7], -0.003),
    ] {
        let model = VehicleModel::nominal(Rig::Gimbal);
        let Mounting::Gimbal { ring_inertia_kg_m2: ring } = model.mounting else { panic!("not the gimbal") };
        let [ixx, iyy, izz] = model.inertia_kg_m2;
        let invariants = |plant: &Plant| {
            let truth = plant.truth();
            let (sin, cos) = libm::sincos(truth.roll_rad);
            let [roll_rate, pitch_rate, _] = truth.euler_rate_rad_s;
            let j = scales[1] * (ring + iyy * cos * cos + izz * sin * sin);
            let [p, q, _] = truth.rate_body_rad_s;
            let energy_j =
                0.5 * scales[0] * ixx * roll_rate * roll_rate + 0.5 * j * pitch_rate * pitch_rate + product * p * q;
            (energy_j, j * pitch_rate + product * cos * roll_rate)
        };
        let mut plant = with_effects(model, effects);
        plant.set_attitude([0.3, 0.2, 0.0], [2.0, 4.0 * libm::cos(0.3), -4.0 * libm::sin(0.3)]);
        let start = invariants(&plant);
        for _ in 0..40 {
            plant.advance(0.05);
            let now = invariants(&plant);
            assert!(
                (now.0 / start.0 - 1.0).abs() < 1e-9 && (now.1 / start.1 - 1.0).abs() < 1e-9,
                "{effects:?}: {now:?}"
            );
        }
    }
}

/// Without reaction torque only the ring's bearing holds the vehicle, and has no torque about pitch: the momentum of
/// ring, body and rotors about it is constant.
#[test]
fn rotors_conserve_the_momentum_about_pitch() {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    let Propulsion::Device(device) = &mut model.propulsion else { panic!("not the device") };
    device.reaction_torque_nm_s2 = 0.0;
    let Mounting::Gimbal { ring_inertia_kg_m2: ring } = model.mounting else { panic!("not the gimbal") };
    let [_, iyy, izz] = model.inertia_kg_m2;
    let momentum = |plant: &Plant| {
        let truth = plant.truth();
        let (sin, cos) = libm::sincos(truth.roll_rad);
        let [w1, w2, w3, w4] = truth.motor_speed_rad_s;
        let j = ring + iyy * cos * cos + izz * sin * sin;
        // the rotors' part lies along the body's z axis, whose share in pitch is -sin(roll)
        j * truth.euler_rate_rad_s[1] - 2e-4 * (w3 + w4 - w1 - w2) * sin
    };
    let mut plant = with_effects(model, &["rotor_inertia:inertia_kg_m2=2e-4"]);
    plant.set_attitude([0.5, 0.2, 0.0], [0.4, 0.0, 0.0]);
    let start = momentum(&plant);
    plant.set_commands([0.7, 0.7, 0.3, 0.3]);
    for _ in 0..20 {
        plant.advance(0.05);
        assert!(close(momentum(&plant), start, 1e-10), "{start} {}", momentum(&plant));
    }
    // what the body took over
    assert!(plant.truth().euler_rate_rad_s[1].abs() > 0.1, "{:?}", plant.truth());
}

/// Two springs on coupled axes: the modes solve `det(K - w^2 M) = 0`.
#[test]
fn coupled_axes_swing_in_their_modes() {
    let (k_roll, k_pitch, product) = (0.3, 0.5, 0.004);
    // w^4 (I J - P^2) - w^2 (I k_pitch + J k_roll) + k_roll k_pitch = 0
    let (a, b, c) = (IXX * J - product * product, -(IXX * k_pitch + J * k_roll), k_roll * k_pitch);
    for sign in [-1.0, 1.0] {
        let square = (-b + sign * (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
        // first row: (k_roll - w^2 I) roll = w^2 P pitch
        let (roll, pitch) = (square * product, k_roll - square * IXX);
        let scale = 1e-4 / libm::hypot(roll, pitch);
        let mut plant = gimbal(&[
            "spring:axis=roll,stiffness_nm_rad=0.3",
            "spring:axis=pitch,stiffness_nm_rad=0.5",
            "inertia_coupling:product_kg_m2=0.004",
        ]);
        plant.set_attitude([scale * roll, scale * pitch, 0.0], [0.0; 3]);
        plant.advance(3.1);
        let swing = libm::cos(square.sqrt() * 3.1);
        let truth = plant.truth();
        // what is not linear is of third order in 1e-4 rad, and grows over some ten periods
        assert!(close(truth.roll_rad, scale * roll * swing, 1e-10), "{sign}: {}", truth.roll_rad);
        assert!(close(truth.pitch_rad, scale * pitch * swing, 1e-10), "{sign}: {}", truth.pitch_rad);
    }
}
