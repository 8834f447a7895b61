//! The plant as a whole: sides, inputs, clock, what it reports.

use super::*;
use crate::model::Rig;
use crate::vehicle::propulsion::Propulsion;

/// A vehicle without lift below command 0.5, for pure rigid-body motion.
pub(super) fn unpowered(rig: Rig) -> VehicleModel {
    let mut model = VehicleModel::nominal(rig);
    model.propulsion = Propulsion::Box(crate::vehicle::propulsion::FlyingBox {
        lift_offset_n: -1.0,
        lift_slope_n: 2.0,
        reaction_torque_per_lift_m: 0.05,
        battery_v: None,
    });
    model.base_command = 0.0;
    model.rotor_drag_ns_m = 0.0;
    model
}

/// The free vehicle without the drag of its rotors: what its velocity does not act on.
fn without_drag() -> VehicleModel {
    VehicleModel::nominal(Rig::Free).with_rotor_drag(0.0)
}

/// A vehicle with effects in their short form, integrated much more finely than the tests need.
pub(super) fn with_effects(mut model: VehicleModel, effects: &[&str]) -> Plant {
    let parse = |short: &&str| crate::effects::Effect::parse(short, model.rig()).unwrap();
    model.effects = effects.iter().map(parse).collect();
    let mut plant = Plant::new(&model);
    plant.integrate_adaptively(1e-12);
    plant
}

/// Rotates a body vector into the world by a unit quaternion.
pub(super) fn world_from_body([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let rotation = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z));
    (rotation * nalgebra::Vector3::from(v)).into()
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn starts_level_at_rest_and_in_equilibrium() {
    for rig in [Rig::Gimbal, Rig::Free] {
        let model = VehicleModel::nominal(rig);
        let truth = Plant::new(&model).truth();
        let settled = model.propulsion.equilibrium(model.base_command);
        assert_eq!([truth.roll_rad, truth.pitch_rad, truth.yaw_rad], [0.0; 3]);
        assert_eq!(truth.rate_body_rad_s, [0.0; 3]);
        assert_eq!(truth.motor_speed_rad_s, [settled.speed_rad_s; 4]);
        assert_eq!(truth.lift_n, [settled.lift_n; 4]);
        let [x, y, z] = truth.specific_force_body_m_s2;
        assert!(x == 0.0 && y == 0.0 && close(z, -model.gravity_m_s2, 1e-6), "{rig:?}: {z}");
    }
}

#[test]
fn hover_is_an_equilibrium_on_every_level_and_rig() {
    for file in ["f450-gimbal", "f450-free", "generic-gimbal", "generic-free", "box-gimbal", "box-free"] {
        let path = format!("{}/../models/{file}.toml", env!("CARGO_MANIFEST_DIR"));
        let model = VehicleModel::load(path.as_ref()).unwrap();
        let mut plant = Plant::new(&model);
        plant.advance(5.0);
        let truth = plant.truth();
        assert!(truth.rate_body_rad_s.iter().all(|rate| rate.abs() < 1e-12), "{file}");
        assert!(close(truth.roll_rad, 0.0, 1e-12) && close(truth.pitch_rad, 0.0, 1e-12), "{file}");
        // command and parameters are given to 1e-8: lift to some 1e-7 N, for 5 s
        assert!(truth.velocity_ned_m_s.iter().all(|speed| speed.abs() < 2e-6), "{file}: {:?}", truth.velocity_ned_m_s);
    }
}

/// Force times lever and the reaction to the rotor's spin, motor by motor, from docs/rig.md's table of places and
/// spins.
#[test]
fn each_motor_turns_the_body_as_its_place_and_spin_demand() {
    let d = 0.226 / std::f64::consts::SQRT_2;
    // front right CCW, rear left CCW, front left CW, rear right CW; CCW from above is about -z (z is down)
    let motors = [(d, d, -1.0), (-d, -d, -1.0), (d, -d, 1.0), (-d, d, 1.0)];
    let model = VehicleModel::nominal(Rig::Gimbal);
    let airframe = Plant::new(&model).airframe;
    for (index, (x, y, spin)) in motors.into_iter().enumerate() {
        let mut lifts = [0.0; 4];
        lifts[index] = 3.0;
        let force = nalgebra::Vector3::new(0.0, 0.0, -3.0);
        let lever = nalgebra::Vector3::new(x, y, 0.0);
        let torque = lever.cross(&force);
        // air holds the propeller back, and so turns the body against its spin
        let reaction = -spin * 3.0 * 5.6977e-8 / 1.5064e-6;
        let ours = airframe.torque_body_nm(lifts);
        assert!(close(ours[0], torque.x, 1e-14) && close(ours[1], torque.y, 1e-14), "motor {}", index + 1);
        assert!(close(ours[2], reaction, 1e-14), "motor {}", index + 1);
    }
}

#[test]
fn commands_are_clamped_and_nonsense_stops_the_motor() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let after = |commands: [f64; 4]| {
        let mut plant = Plant::new(&model);
        plant.set_commands(commands);
        plant.advance(0.01);
        plant.motor_speed_rad_s()
    };
    assert_eq!(after([-1.0, 2.0, f64::NAN, f64::INFINITY]), after([0.0, 1.0, 0.0, 1.0]));
}

/// A motor that rings: cut off from full speed it would swing through zero.
#[test]
fn a_rotor_that_is_cut_off_stops_and_stays() {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    let Propulsion::Device(device) = &mut model.propulsion else { panic!("not the device") };
    device.esc = crate::vehicle::propulsion::Esc::Duty { battery_v: 11.1 };
    device.speed_offset_rad_s = 0.0;
    let mut plant = Plant::new(&model);
    plant.set_motor_equilibrium([1.0; 4]);
    plant.set_commands([0.0; 4]);
    let mut stopped = false;
    for _ in 0..400 {
        plant.advance(0.1e-3);
        let speed = plant.motor_speed_rad_s()[0];
        assert!(speed >= 0.0, "{speed}");
        stopped |= speed == 0.0;
    }
    assert!(stopped && plant.motor_speed_rad_s()[0] < 1e-3, "{:?}", plant.motor_speed_rad_s());
}

#[test]
fn a_disturbance_torque_accelerates_by_the_inertia() {
    let torque_nm = 0.01;
    for (rig, inertias) in [(Rig::Gimbal, [0.0115118, 0.0365651]), (Rig::Free, [0.0115118, 0.0115118])] {
        for axis in 0..2 {
            let mut plant = Plant::new(&VehicleModel::nominal(rig));
            let mut torque = [0.0; 3];
            torque[axis] = torque_nm;
            plant.set_disturbance_torque_body_nm(torque);
            plant.advance(0.2);
            let rate = plant.rate_body_rad_s()[axis];
            // about one axis the motion is uniformly accelerated, which the method integrates exactly
            assert!(close(rate, torque_nm / inertias[axis] * 0.2, 1e-12), "{rig:?}, axis {axis}: {rate}");
        }
    }
    // the locked yaw axis feels nothing while the body is level
    let mut plant = Plant::new(&VehicleModel::nominal(Rig::Gimbal));
    plant.set_disturbance_torque_body_nm([0.0, 0.0, 0.1]);
    plant.advance(0.2);
    assert_eq!(plant.rate_body_rad_s(), [0.0; 3]);
}

/// Beside lift and gravity, which hold each other: felt at once, and along the body's axes.
#[test]
fn a_disturbance_force_accelerates_by_the_mass() {
    let model = without_drag();
    let mut plant = Plant::new(&model);
    let felt_before = plant.specific_force_body_m_s2();
    let force_n = [0.3, -0.6, 1.2];
    plant.set_disturbance_force_body_n(force_n);
    let felt = plant.specific_force_body_m_s2();
    plant.advance(0.2);
    let velocity = plant.truth().velocity_ned_m_s;
    for axis in 0..3 {
        // 1.2 kg
        assert!(close(felt[axis] - felt_before[axis], force_n[axis] / 1.2, 1e-12), "{felt:?}");
        let hover_m_s2 = if axis == 2 { felt_before[2] + model.gravity_m_s2 } else { 0.0 };
        assert!(close(velocity[axis], (force_n[axis] / 1.2 + hover_m_s2) * 0.2, 1e-9), "{velocity:?}");
    }
}

#[test]
fn advance_takes_whole_steps_and_ends_on_time() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let started = || {
        let mut plant = Plant::new(&model);
        plant.set_commands([0.6, 0.4, 0.55, 0.45]);
        plant
    };
    let (mut whole, mut pieces, mut odd) = (started(), started(), started());
    whole.advance(2.5e-3);
    for _ in 0..5 {
        pieces.advance(0.5e-3);
    }
    // durations that are no multiple of the step
    odd.advance(0.7e-3);
    odd.advance(1.8e-3);
    assert!(close(whole.time_s(), 2.5e-3, 1e-15) && close(odd.time_s(), 2.5e-3, 1e-15));
    let (whole, pieces, odd) = (whole.truth(), pieces.truth(), odd.truth());
    assert!(close(whole.roll_rad, pieces.roll_rad, 1e-15) && close(whole.pitch_rad, pieces.pitch_rad, 1e-15));
    // other step sizes: equal to within the method's error, some 1e-5 of the motion
    assert!(whole.roll_rad != 0.0 && close(odd.roll_rad / whole.roll_rad, 1.0, 1e-4));
    let mut still = started();
    let before = still.truth();
    for duration_s in [0.0, -1.0, f64::NAN] {
        still.advance(duration_s);
    }
    assert_eq!(still.truth(), before);
}

#[test]
fn attitude_that_is_set_is_reported() {
    let (angles, rates) = ([0.5, -0.4, 1.2], [0.3, -0.2, 0.1]);
    let mut free = Plant::new(&VehicleModel::nominal(Rig::Free));
    free.set_attitude(angles, rates);
    let truth = free.truth();
    for (ours, set) in [truth.roll_rad, truth.pitch_rad, truth.yaw_rad].into_iter().zip(angles) {
        assert!(close(ours, set, 1e-14));
    }
    assert_eq!(truth.rate_body_rad_s, rates);

    let mut gimbal = Plant::new(&VehicleModel::nominal(Rig::Gimbal));
    let (sin, cos) = libm::sincos(0.5);
    // a motion that the gimbal allows: phi' = 0.3, theta' = -0.2
    gimbal.set_attitude(angles, [0.3, -0.2 * cos, 0.2 * sin]);
    let truth = gimbal.truth();
    assert_eq!([truth.roll_rad, truth.pitch_rad, truth.yaw_rad], [0.5, -0.4, 0.0]);
    for (ours, expected) in truth.euler_rate_rad_s.into_iter().zip([0.3, -0.2, 0.0]) {
        assert!(close(ours, expected, 1e-15), "{:?}", truth.euler_rate_rad_s);
    }
}

#[test]
fn euler_rates_are_the_derivatives_of_the_angles() {
    for rig in [Rig::Gimbal, Rig::Free] {
        let mut plant = Plant::new(&unpowered(rig));
        plant.set_attitude([0.5, -0.4, 0.3], [0.9, 0.7, -0.5]);
        let before = plant.truth();
        let rates = plant.truth().euler_rate_rad_s;
        let step_s = 1e-6;
        plant.advance(step_s);
        let after = plant.truth();
        let differences = [
            (after.roll_rad - before.roll_rad) / step_s,
            (after.pitch_rad - before.pitch_rad) / step_s,
            (after.yaw_rad - before.yaw_rad) / step_s,
        ];
        for (rate, difference) in rates.into_iter().zip(differences) {
            // a forward difference over 1 us errs by half the acceleration times that, 1e-6; rounding 1e-10
            assert!(close(rate, difference, 3e-6), "{rig:?}: {rates:?} against {differences:?}");
        }
    }
}

/// On the gimbal the pivot rests: the specific force is gravity's reaction, (0, 0, -g) of the world seen from the body.
#[test]
fn the_resting_accelerometer_reads_gravity_from_every_attitude() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    for (roll, pitch) in [(0.3, 0.0), (0.0, 0.3), (-1.0, 0.7), (2.5, -1.2)] {
        let mut plant = Plant::new(&model);
        plant.set_attitude([roll, pitch, 0.0], [0.0; 3]);
        let truth = plant.truth();
        let world = world_from_body(truth.q_world_from_body, truth.specific_force_body_m_s2);
        for (ours, expected) in world.into_iter().zip([0.0, 0.0, -model.gravity_m_s2]) {
            assert!(close(ours, expected, 1e-14), "({roll}, {pitch}): {world:?}");
        }
    }
}

/// Newton's law: acceleration is gravity plus what the accelerometer feels, turned into the world. Nose up pulls the
/// vehicle backwards, right side down to the right.
#[test]
fn a_tilted_vehicle_accelerates_where_its_lift_points() {
    let model = without_drag();
    for (angles, north, east) in
        [([0.0, 0.3, 0.0], -1.0, 0.0), ([0.3, 0.0, 0.0], 0.0, 1.0), ([0.4, -0.5, 2.0], 0.0, 0.0)]
    {
        let mut plant = Plant::new(&model);
        plant.set_attitude(angles, [0.0; 3]);
        let truth = plant.truth();
        let felt = world_from_body(truth.q_world_from_body, truth.specific_force_body_m_s2);
        plant.advance(0.1);
        let speed = plant.truth().velocity_ned_m_s;
        for (axis, gravity) in [0.0, 0.0, model.gravity_m_s2].into_iter().enumerate() {
            // without torque the attitude stays, and so does the acceleration
            assert!(close(speed[axis], (felt[axis] + gravity) * 0.1, 1e-12), "{angles:?}: {speed:?}");
        }
        assert!(speed[0] * north >= 0.0 && speed[1] * east >= 0.0, "{angles:?}: {speed:?}");
        assert!(north == 0.0 || speed[0].abs() > 0.2, "{angles:?}: {speed:?}");
        assert!(east == 0.0 || speed[1].abs() > 0.2, "{angles:?}: {speed:?}");
    }
}

mod continuous;
mod effects_in_free_flight;
mod effects_of_actuators;
mod effects_on_gimbal;
mod integration;
mod physics;
