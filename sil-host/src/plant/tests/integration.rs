//! The two integrators against each other and against finer ones, looks between steps, the nominal path's bits.

use super::{Plant, close};
use crate::effects::Effect;
use crate::model::{Rig, VehicleModel};

/// Everything in motion, a new command every 2.5 ms, for a second; all components of the state that are not angles of
/// rotors.
fn flown(model: &VehicleModel, prepare: impl Fn(&mut Plant)) -> Vec<f64> {
    let mut plant = Plant::new(model);
    prepare(&mut plant);
    plant.set_attitude([0.4, -0.3, 0.1], [1.0, -2.0, 0.5]);
    let base = model.base_command;
    for step in 0..400 {
        let (sin, cos) = libm::sincos(f64::from(step) * 0.13);
        plant.set_commands([base + 0.04 * sin, base - 0.04 * sin, base + 0.03 * cos, base - 0.03 * cos]);
        plant.advance(2.5e-3);
    }
    let truth = plant.truth();
    let angles = [truth.roll_rad, truth.pitch_rad];
    [&angles[..], &truth.rate_body_rad_s, &truth.motor_speed_rad_s].concat()
}

fn with(rig: Rig, effects: &[&str]) -> VehicleModel {
    let mut model = VehicleModel::nominal(rig);
    model.effects = effects.iter().map(|short| Effect::parse(short, rig).unwrap()).collect();
    model
}

/// `sil synth` promises 0.01 % of the state. The reference is the other method with steps of 10 us, where its error is
/// (1/50)^4 of that at the default step.
#[test]
fn synthetic_logs_are_integrated_to_a_hundredth_of_a_percent() {
    let effects = [
        "coulomb_friction:axis=pitch,torque_nm=0.02",
        "inertia_coupling:product_kg_m2=0.002",
        "motor_lag:time_constant_s=0.01",
        "actuation_delay:delay_s=0.0037",
        "periodic_disturbance:axis=roll,amplitude_nm=0.02,frequency_hz=7",
        "step_disturbance:axis=pitch,torque_nm=0.02,start_s=0.3333",
    ];
    for (rig, effects) in [(Rig::Gimbal, &effects[..]), (Rig::Gimbal, &[]), (Rig::Free, &effects), (Rig::Free, &[])] {
        let model = with(rig, effects);
        let ours = flown(&model, |plant| plant.integrate_adaptively(crate::synthesis::TOLERANCE));
        let reference = flown(&model, |plant| plant.set_step_max_s(1e-5));
        let usual = flown(&model, |_| ());
        let largest = |states: &[f64]| {
            let relative = states.iter().zip(&reference).map(|(a, b)| (a - b).abs() / b.abs().max(0.1));
            relative.fold(0.0, f64::max)
        };
        println!("{rig:?}, {} effects: {:.1e} adaptive, {:.1e} usual", effects.len(), largest(&ours), largest(&usual));
        // a hundred times better than promised
        assert!(largest(&ours) < 1e-6, "{rig:?}: {ours:?} {reference:?}");
    }
}

#[test]
fn a_look_between_steps_sees_what_a_plant_that_stops_there_is_in() {
    let model = with(Rig::Gimbal, &["cg_offset:axis=pitch,cos_moment_nm=0.1"]);
    let started = || {
        let mut plant = Plant::new(&model);
        plant.integrate_adaptively(1e-12);
        plant.set_commands([0.6, 0.4, 0.55, 0.45]);
        plant
    };
    let mut looking = started();
    let times_s = [0.0, 0.0017, 0.005, 0.00731, 0.00731, 0.01];
    looking.look_at(times_s);
    for _ in 0..4 {
        looking.advance(2.5e-3);
    }
    let seen = looking.take_seen();
    assert_eq!(seen.len(), times_s.len());
    for (seen, time_s) in seen.iter().zip(times_s) {
        let mut stopping = started();
        stopping.advance(time_s);
        let expected = stopping.truth();
        assert!(close(seen.time_s, time_s, 1e-9), "{} {time_s}", seen.time_s);
        assert!(close(seen.roll_rad, expected.roll_rad, 1e-12) && close(seen.pitch_rad, expected.pitch_rad, 1e-12));
        assert!(close(seen.rate_body_rad_s[1], expected.rate_body_rad_s[1], 1e-10));
    }
    assert!(looking.take_seen().is_empty());
}

/// The bits of the nominal vehicle's motion, so that no change of the effects' code reaches it unseen.
#[test]
fn the_nominal_motion_has_the_bits_it_always_had() {
    for (rig, expected) in [(Rig::Gimbal, 0x92cc_2078_aefb_e427), (Rig::Free, 0xe6d7_61b5_07db_405b)] {
        let bits = flown(&VehicleModel::nominal(rig), |_| ()).into_iter().map(f64::to_bits);
        // FNV-1a over words
        let hash = bits.fold(0xcbf2_9ce4_8422_2325_u64, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3));
        assert_eq!(hash, expected, "{rig:?}: {hash:#x}");
    }
}
