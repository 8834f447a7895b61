//! Effects that only a flying body knows, against motions whose solution can be written down.

use super::{close, unpowered, with_effects, without_drag, world_from_body};
use crate::model::{Mounting, Rig, VehicleModel};
use crate::vehicle::propulsion::Propulsion;

const MASS_KG: f64 = 1.2;

/// `m v' = -k (v - w)`: the vehicle drifts with the air.
#[test]
fn rotor_drag_takes_the_vehicle_along_with_the_wind() {
    let model = unpowered(Rig::Free);
    let effects = ["rotor_drag:coefficient_ns_m=0.5", "wind:north_m_s=3,east_m_s=-2,drag_area_m2=0"];
    let mut plant = with_effects(model, &effects);
    plant.advance(1.7);
    let share = 1.0 - libm::exp(-0.5 * 1.7 / MASS_KG);
    let truth = plant.truth();
    assert!(
        close(truth.velocity_ned_m_s[0], 3.0 * share, 1e-9) && close(truth.velocity_ned_m_s[1], -2.0 * share, 1e-9)
    );
    // along the rotors' axis there is no drag
    assert!(close(truth.velocity_ned_m_s[2], 9.81 * 1.7, 1e-9));
    // the accelerometer feels it: the level body's x axis points north
    assert!(close(truth.specific_force_body_m_s2[0], 0.5 / MASS_KG * 3.0 * (1.0 - share), 1e-9));
}

/// With u the speed against the air, `m u' = -1/2 rho A u^2` has the solution `u0 / (1 + u0 c t)`, c = rho A / 2m.
#[test]
fn wind_pushes_with_the_square_of_the_airspeed() {
    let effects = ["wind:north_m_s=0,east_m_s=6,drag_area_m2=0.05"];
    let mut plant = with_effects(without_drag(), &effects);
    plant.advance(4.0);
    let c = 1.225 * 0.05 / (2.0 * MASS_KG);
    let expected = 6.0 - 6.0 / (1.0 + 6.0 * c * 4.0);
    // hover is exact to the 1e-8 of the base command: 1e-6 m/s of fall in 4 s
    let velocity = plant.truth().velocity_ned_m_s;
    assert!(close(velocity[1], expected, 1e-6) && close(velocity[0], 0.0, 1e-9), "{velocity:?} {expected}");
}

/// Drag acts along the body's axes: turned about the vertical, tilted, the force stays against the motion.
#[test]
fn drag_of_the_frame_does_not_depend_on_the_attitude() {
    let drift = |attitude: [f64; 3]| {
        let mut plant = with_effects(unpowered(Rig::Free), &["wind:north_m_s=4,east_m_s=3,drag_area_m2=0.05"]);
        plant.set_attitude(attitude, [0.0; 3]);
        plant.advance(2.0);
        plant.truth().velocity_ned_m_s
    };
    let (level, turned) = (drift([0.0; 3]), drift([0.4, -0.7, 2.1]));
    for axis in 0..3 {
        assert!(close(level[axis], turned[axis], 1e-9), "{level:?} {turned:?}");
    }
}

/// Air from ahead lifts the nose, air from the right the right side; at rest in a wind, before anything has turned or
/// drifted, `I q' = c w`.
#[test]
fn air_across_the_rotors_lifts_the_side_that_it_comes_from() {
    let effects = ["speed_stability:coefficient_ns=0.002", "wind:north_m_s=-3,east_m_s=-2,drag_area_m2=0"];
    let model = unpowered(Rig::Free);
    let [ixx, iyy, _] = model.inertia_kg_m2;
    let mut plant = with_effects(model, &effects);
    plant.advance(0.05);
    let [p, q, r] = plant.truth().rate_body_rad_s;
    // the air turns out of the body's axes by the angle, 1e-3, and nothing else is left out
    assert!(close(q, 0.002 * 3.0 / iyy * 0.05, 1e-5) && close(p, -0.002 * 2.0 / ixx * 0.05, 1e-5), "{p} {q}");
    assert!(q > 0.02 && p < -0.01 && close(r, 0.0, 1e-9));
}

#[test]
fn the_ground_lifts_and_a_heavier_vehicle_sinks() {
    let model = VehicleModel::nominal(Rig::Free);
    let lift_n = with_effects(model.clone(), &[]).lifts_n()[0];
    let near = with_effects(model.clone(), &["ground_effect:height_m=0.127,rotor_radius_m=0.127"]);
    // one radius above ground: 1 / (1 - 1/16)
    assert!(close(near.lifts_n()[0], lift_n * 16.0 / 15.0, 1e-12));
    let mut rising = near.clone();
    rising.advance(1.0);
    let ratio: f64 = 0.25 * 0.127 / (0.127 - rising.truth().position_ned_m[2]);
    assert!(
        rising.truth().position_ned_m[2] < -0.01 && close(rising.lifts_n()[0], lift_n / (1.0 - ratio * ratio), 1e-9)
    );

    let mut heavy = with_effects(model, &["mass_error:scale=1.1"]);
    heavy.advance(0.5);
    assert!(close(heavy.truth().velocity_ned_m_s[2], 9.81 * (1.0 - 1.0 / 1.1) * 0.5, 1e-6));
}

#[test]
fn a_body_with_a_product_of_inertia_conserves_energy_and_momentum() {
    let mut model = unpowered(Rig::Free);
    model.inertia_kg_m2 = [0.011, 0.014, 0.02];
    assert!(matches!(model.mounting, Mounting::Free { .. }));
    let product = 0.005;
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    let mut plant = with_effects(model, &["inertia_coupling:product_kg_m2=0.005"]);
    plant.set_attitude([0.2, -0.3, 0.4], [3.0, -2.0, 5.0]);
    let invariants = |plant: &crate::plant::Plant| {
        let truth = plant.truth();
        let [p, q, r] = truth.rate_body_rad_s;
        let momentum = [ixx * p + product * q, product * p + iyy * q, izz * r];
        let energy_j = 0.5 * (momentum[0] * p + momentum[1] * q + momentum[2] * r);
        (energy_j, world_from_body(truth.q_world_from_body, momentum))
    };
    let start = invariants(&plant);
    plant.advance(5.0);
    let end = invariants(&plant);
    assert!((end.0 / start.0 - 1.0).abs() < 1e-9);
    for axis in 0..3 {
        assert!(close(end.1[axis], start.1[axis], 1e-10), "{start:?} {end:?}");
    }
}

/// Without reaction torque nothing turns the vehicle from outside while its rotors speed up in pairs: the momentum of
/// body and rotors keeps its size and its direction, whatever passes from one to the other.
#[test]
fn body_and_rotors_conserve_their_angular_momentum() {
    let mut model = VehicleModel::nominal(Rig::Free);
    let Propulsion::Device(device) = &mut model.propulsion else { panic!("not the device") };
    device.reaction_torque_nm_s2 = 0.0;
    model.inertia_kg_m2 = [0.011, 0.014, 0.02];
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    let mut plant = with_effects(model, &["rotor_inertia:inertia_kg_m2=3e-4"]);
    plant.set_attitude([0.2, -0.3, 0.4], [1.0, -0.7, 0.5]);
    let state = |plant: &crate::plant::Plant| {
        let truth = plant.truth();
        let ([p, q, r], [w1, w2, w3, w4]) = (truth.rate_body_rad_s, truth.motor_speed_rad_s);
        // about z, down: 1 and 2 turn counter-clockwise from above
        let rotors = 3e-4 * (w3 + w4 - w1 - w2);
        (r, world_from_body(truth.q_world_from_body, [ixx * p, iyy * q, izz * r + rotors]))
    };
    let (yaw_rate, start) = state(&plant);
    // motors 1 and 2 turn the nose to the right, and begin to at once
    plant.set_commands([0.7, 0.7, 0.4, 0.4]);
    plant.advance(0.02);
    assert!(state(&plant).0 > yaw_rate + 0.1, "{:?}", state(&plant));
    for _ in 0..20 {
        plant.advance(0.1);
        let (_, now) = state(&plant);
        for axis in 0..3 {
            assert!(close(now[axis], start[axis], 1e-9), "{start:?} {now:?}");
        }
    }
}

/// The axes that the gimbal locks or shares, about the body in free flight.
#[test]
fn torques_act_about_the_bodys_axes() {
    for (axis, name, inertia) in [(0, "roll", 0.0115118), (1, "pitch", 0.0115118), (2, "yaw", 0.020)] {
        let bias = format!("torque_bias:axis={name},torque_nm=0.01");
        let error = format!("inertia_error:axis={name},scale=1.25");
        let mut plant = with_effects(unpowered(Rig::Free), &[&bias, &error]);
        plant.advance(0.3);
        assert!(close(plant.rate_body_rad_s()[axis], 0.01 / (1.25 * inertia) * 0.3, 1e-10), "{name}");
        let mut spring = with_effects(unpowered(Rig::Free), &[&format!("spring:axis={name},stiffness_nm_rad=0.2")]);
        let mut attitude = [0.0; 3];
        attitude[axis] = 0.3;
        spring.set_attitude(attitude, [0.0; 3]);
        spring.advance(0.4);
        let truth = spring.truth();
        let angle = [truth.roll_rad, truth.pitch_rad, truth.yaw_rad][axis];
        assert!(close(angle, 0.3 * libm::cos((0.2_f64 / inertia).sqrt() * 0.4), 1e-9), "{name}: {angle}");
    }
}
