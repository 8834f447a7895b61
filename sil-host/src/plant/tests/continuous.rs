//! The plant under an integrator that is not its own.

use super::Plant;
use crate::effects::Effect;
use crate::model::{Rig, VehicleModel};
use crate::vehicle::propulsion::{FlyingBox, Propulsion};

/// Heun's method, another than the plant's, with the stops that the plant wants.
fn integrate(plant: &mut Plant, until_s: f64, step_s: f64) {
    let mut now_s = plant.time_s();
    while now_s < until_s - 1e-12 {
        let next_s = plant.next_event_s().unwrap_or(until_s).min(until_s).min(now_s + step_s);
        let (from, duration_s) = (plant.states(), next_s - now_s);
        let first = plant.derivatives(now_s);
        let along = |slopes: &[f64]| -> Vec<f64> {
            from.iter().zip(slopes).map(|(state, slope)| state + duration_s * slope).collect()
        };
        plant.set_states(&along(&first));
        let second = plant.derivatives(next_s);
        let mean: Vec<f64> = first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect();
        plant.set_states(&along(&mean));
        plant.pass_to(next_s);
        plant.tidy();
        now_s = next_s;
    }
}

/// On each rig, with what acts late, lags, sets in and sags.
#[test]
fn a_foreign_integrator_finds_the_same_motion() {
    for (rig, effects) in [
        (Rig::Gimbal, &[][..]),
        (Rig::Free, &[]),
        (Rig::Gimbal, &["actuation_delay:delay_s=0.0123", "step_disturbance:axis=roll,torque_nm=0.05,start_s=0.0301"]),
        (Rig::Free, &["motor_lag:time_constant_s=0.03", "weak_motor:motor=3,scale=0.9"]),
    ] {
        let mut model = VehicleModel::generic(rig);
        for short in effects {
            model.effects.push(Effect::parse_for(short, rig, model.inertia_kg_m2).unwrap());
        }
        let (mut own, mut foreign) = (Plant::new(&model), Plant::new(&model));
        for step in 1..=20 {
            let base = model.base_command;
            let push = 0.05 * f64::from(step % 4);
            let commands = [base - push, base + push, base + push, base];
            own.set_commands(commands);
            foreign.set_commands(commands);
            own.advance(0.005);
            integrate(&mut foreign, own.time_s(), 2e-5);
        }
        assert!((own.time_s() - foreign.time_s()).abs() < 1e-12);
        let (own_states, foreign_states) = (own.states(), foreign.states());
        assert_eq!(own_states.len(), own.state_names().len());
        assert!(own_states[0].abs() + own_states[6 % own_states.len()].abs() > 1e-3, "it moves: {own_states:?}");
        for (state, name) in own.state_names().iter().enumerate() {
            // Heun's error at this step, of speeds of a thousand and of the rest of about one
            let size = own_states[state].abs().max(1.0);
            let difference = (own_states[state] - foreign_states[state]).abs() / size;
            assert!(difference < 3e-6, "{} with {effects:?}: {difference:e}", name.name);
        }
        assert!((own.battery_v() - foreign.battery_v()).abs() < 1e-12);
    }
}

#[test]
fn between_two_stops_the_plant_can_be_seen_without_stopping() {
    let mut model = VehicleModel::generic(Rig::Gimbal);
    model.effects.push(Effect::parse_for("motor_lag:time_constant_s=0.03", Rig::Gimbal, model.inertia_kg_m2).unwrap());
    model.propulsion = Propulsion::Box(FlyingBox {
        lift_offset_n: 0.0,
        lift_slope_n: 4.0,
        reaction_torque_per_lift_m: 0.02,
        battery_v: None,
    });
    let mut plant = Plant::new(&model);
    plant.set_commands([1.0; 4]);
    // by hand: the lag's exponential from the base command on, times the slope
    let lift_n = |after_s: f64| 4.0 * (1.0 + (model.base_command - 1.0) * (-after_s / 0.03_f64).exp());
    for after_s in [0.0, 0.01, 0.05] {
        assert!((plant.truth_at(after_s).lift_n[2] - lift_n(after_s)).abs() < 1e-12);
    }
    assert_eq!(plant.time_s(), 0.0);
}

#[test]
fn what_an_integrator_oversteps_is_put_right() {
    let mut plant = Plant::new(&VehicleModel::generic(Rig::Free));
    assert!(!plant.needs_tidying());
    let mut states = plant.states();
    states[7] = 0.1;
    plant.set_states(&states);
    assert!(plant.needs_tidying());
    plant.tidy();
    assert!(!plant.needs_tidying());
    assert!((plant.states()[7] - 0.1 / 1.01_f64.sqrt()).abs() < 1e-15);
    let mut states = plant.states();
    states[14] = -3.0;
    plant.set_states(&states);
    assert!(plant.needs_tidying());
    plant.tidy();
    assert_eq!(plant.states()[14], 0.0);
}

#[test]
fn each_level_has_the_states_of_its_motors() {
    let box_model = include_str!("../../../../models/box-gimbal.toml");
    for (model, states) in [
        (VehicleModel::parse(box_model, "models/box-gimbal.toml").unwrap(), 4),
        (VehicleModel::generic(Rig::Gimbal), 4 + 4),
        (VehicleModel::nominal(Rig::Gimbal), 4 + 8),
        (VehicleModel::nominal(Rig::Free), 13 + 8),
    ] {
        let plant = Plant::new(&model);
        assert_eq!(plant.state_names().len(), states);
        assert_eq!(plant.states().len(), states);
        assert_eq!(plant.derivatives(0.0).len(), states);
    }
}
