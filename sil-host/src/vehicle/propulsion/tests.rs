use super::*;
use crate::model::{Rig, VehicleModel};

fn device(rig: Rig) -> DevicePropulsion {
    match VehicleModel::nominal(rig).propulsion {
        Propulsion::Device(device) => device,
        other => panic!("the nominal model is the specific device, not {other:?}"),
    }
}

fn level(file: &str) -> VehicleModel {
    let path = format!("{}/../models/{file}.toml", env!("CARGO_MANIFEST_DIR"));
    VehicleModel::load(path.as_ref()).unwrap()
}

/// Integrates one motor (all four alike) for `duration_s`, with `steps` steps.
fn settle(propulsion: &Propulsion, command: f64, from: RotorState, duration_s: f64, steps: usize) -> RotorState {
    let drive = [propulsion.drive(command); 4];
    let mut rotors = from;
    for _ in 0..steps {
        crate::plant::integrate::runge_kutta_4(&mut rotors, duration_s / steps as f64, |_, rotors| {
            propulsion.derivative(&drive, rotors)
        });
    }
    rotors
}

fn at(speed: f64, current: f64) -> RotorState {
    [speed, speed, speed, speed, current, current, current, current]
}

#[test]
fn nothing_changes_in_equilibrium() {
    for file in ["f450-gimbal", "f450-free", "generic-gimbal", "generic-free", "box-gimbal", "box-free"] {
        let propulsion = level(file).propulsion;
        for command in [0.0, 0.1, 0.3, 0.5, 0.8, 1.0] {
            let settled = propulsion.equilibrium(command);
            let drive = [propulsion.drive(command); 4];
            let rotors = at(settled.speed_rad_s, settled.current_a);
            let change = propulsion.derivative(&drive, &rotors);
            // rates reach 1e5 rad/s² and 1e5 A/s in a step of command: 1e-7 of that is rounding
            assert!(change.iter().all(|rate| rate.abs() < 1e-2), "{file} at {command}: {change:?}");
            let lifts = propulsion.lifts_n(&drive, &rotors);
            assert!(lifts.iter().all(|lift| (lift - settled.lift_n).abs() < 1e-12), "{file} at {command}");
        }
    }
}

/// The figures that docs/rig.md states of the thesis' propulsion.
#[test]
fn the_thesis_propulsion_has_the_lift_slopes_it_is_known_for() {
    let propulsion = VehicleModel::nominal(Rig::Gimbal).propulsion;
    let slope = |command: f64| (propulsion.lift_n(command + 1e-5) - propulsion.lift_n(command - 1e-5)) / 2e-5;
    // stated with two digits
    for (command, expected) in [(0.2, 3.3), (0.5, 1.9), (1.0, 0.96)] {
        assert!((slope(command) / expected - 1.0).abs() < 0.03, "{command}: {}", slope(command));
    }
    // C.1 by hand: 16.45 e^0.0852 - 12.95 e^-2.141
    let Propulsion::Device(device) = propulsion else { panic!("not the device") };
    assert!((device.voltage_v(0.5) - (17.912_98 - 1.522_02)).abs() < 1e-4, "{}", device.voltage_v(0.5));
    assert!(4.0 * propulsion.lift_n(1.0) < 8.0, "at most 8 N in all");
}

/// Without aerodynamic drag the motor is linear in (w, i); here the solution is written down for the complex pair
/// `s = -a +- j b` and compared over the whole transient.
#[test]
fn a_step_of_command_follows_the_analytic_solution_of_the_linear_motor() {
    let linear = DevicePropulsion { drag_nm_s2: 0.0, ..device(Rig::Gimbal) };
    let propulsion = Propulsion::Device(linear);
    let (before, after) = (propulsion.equilibrium(0.4), propulsion.equilibrium(0.6));
    let inertia = linear.motor_inertia_kg_m2 + linear.rotor_inertia_kg_m2;
    let (resistance, inductance, loss) = (linear.resistance_ohm, linear.inductance_h, linear.loss_nm_s);
    let torque_constant = 1.0 / linear.speed_constant_rad_s_v;
    // L J w'' + (R J + L M) w' + (R M + 1/A^2) w = u / A
    let a = (resistance * inertia + inductance * loss) / (2.0 * inductance * inertia);
    let square = (resistance * loss + torque_constant * torque_constant) / (inductance * inertia);
    let b = (square - a * a).sqrt();
    assert!(b > 0.0, "a complex pair");
    // w - w_end = e^(-a t) (c cos b t + d sin b t), with w(0) and w'(0) = 0 given
    let c = before.speed_rad_s - after.speed_rad_s;
    let d = a * c / b;
    for time_s in [0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3, 16e-3] {
        let rotors = settle(&propulsion, 0.6, at(before.speed_rad_s, before.current_a), time_s, 4000);
        let decay = libm::exp(-a * time_s);
        let (sin, cos) = libm::sincos(b * time_s);
        let speed = after.speed_rad_s + decay * (c * cos + d * sin);
        let acceleration = decay * ((b * d - a * c) * cos - (a * d + b * c) * sin);
        let current = (inertia * acceleration + loss * speed) / torque_constant;
        // steps of 4 us leave an integration error of about 1e-12 of the step of 70 rad/s; the rest is rounding
        assert!((rotors[0] - speed).abs() < 1e-8, "{time_s}: {} rad/s against {speed}", rotors[0]);
        assert!((rotors[4] - current).abs() < 1e-8, "{time_s}: {} A against {current}", rotors[4]);
    }
}

#[test]
fn the_default_step_follows_the_fastest_motor_closely() {
    for rig in [Rig::Gimbal, Rig::Free] {
        let propulsion = VehicleModel::nominal(rig).propulsion;
        let start = propulsion.equilibrium(0.4);
        let from = at(start.speed_rad_s, start.current_a);
        let step_s = propulsion.step_max_s().min(crate::plant::STEP_MAX_S);
        for steps in [1, 2, 4, 8, 16] {
            let duration_s = step_s * steps as f64;
            let (coarse, fine) = (
                settle(&propulsion, 0.6, from, duration_s, steps),
                settle(&propulsion, 0.6, from, duration_s, 64 * steps),
            );
            // the stated accuracy of the default step: a ten-thousandth of the speed's change
            let change = propulsion.equilibrium(0.6).speed_rad_s - start.speed_rad_s;
            assert!((coarse[0] - fine[0]).abs() < 1e-4 * change, "{rig:?}, {steps} steps");
        }
    }
}

#[test]
fn levels_agree_at_the_base_command() {
    for rig in ["gimbal", "free"] {
        let device = level(&format!("f450-{rig}"));
        for name in ["box", "generic"] {
            let simple = level(&format!("{name}-{rig}"));
            assert_eq!(simple.base_command, device.base_command);
            assert_eq!(simple.inertia_kg_m2, device.inertia_kg_m2);
            assert_eq!(simple.mounting, device.mounting);
            let base = device.base_command;
            let (ours, theirs) = (simple.propulsion.equilibrium(base), device.propulsion.equilibrium(base));
            // the files give six to seven digits
            assert!((ours.lift_n / theirs.lift_n - 1.0).abs() < 1e-6, "{name}-{rig}");
            assert!((ours.reaction_torque_nm / theirs.reaction_torque_nm - 1.0).abs() < 2e-6, "{name}-{rig}");
            let slope =
                |propulsion: &Propulsion| (propulsion.lift_n(base + 1e-5) - propulsion.lift_n(base - 1e-5)) / 2e-5;
            assert!((slope(&simple.propulsion) / slope(&device.propulsion) - 1.0).abs() < 1e-6, "{name}-{rig}");
        }
    }
}

/// The lag of a step response is the area between it and its end, over its height: for the generic rotor its time
/// constant, for the device whatever winding and inertia make of it.
#[test]
fn the_generic_rotor_lags_as_much_as_the_device() {
    for rig in ["gimbal", "free"] {
        let lag_s = |model: &VehicleModel| {
            let base = model.base_command;
            let step = 1e-4;
            let (from, to) = (model.propulsion.equilibrium(base), model.propulsion.equilibrium(base + step));
            let mut rotors = at(from.speed_rad_s, from.current_a);
            let step_s = 1e-5;
            let mut area = 0.0;
            for _ in 0..100_000 {
                let before = rotors[0];
                rotors = settle(&model.propulsion, base + step, rotors, step_s, 1);
                area += (to.speed_rad_s - 0.5 * (before + rotors[0])) * step_s;
            }
            area / (to.speed_rad_s - from.speed_rad_s)
        };
        let (generic, device) = (lag_s(&level(&format!("generic-{rig}"))), lag_s(&level(&format!("f450-{rig}"))));
        // the step of 1e-4 leaves a nonlinearity of that order
        assert!((generic / device - 1.0).abs() < 1e-3, "{rig}: {generic} s against {device} s");
    }
}

#[test]
fn a_stopped_rotor_does_not_turn_backwards() {
    // full reverse voltage: the winding pulls backwards at once
    let device = device(Rig::Free);
    let change = device.derivative(&[-11.0; 4], &at(0.0, -50.0));
    assert_eq!(change[..4], [0.0; 4]);
    // and starts again under forward torque
    assert!(device.derivative(&[11.0; 4], &at(0.0, 50.0))[0] > 0.0);
    // no voltage, no speed
    assert_eq!(device.equilibrium(0.0), (0.0, 0.0));
}
