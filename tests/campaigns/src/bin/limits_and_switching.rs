//! `cargo run --release -p campaigns --bin limits_and_switching`.

use campaigns::limits_and_switching::{Flown, route};
use clap::Parser;
use sil_host::controller_file::{ReferenceName, TuningChange};
use sil_host::effects::Effect;
use sil_host::model::{Rig, VehicleModel};

/// Flights with different noise that each row is the mean of.
const SEEDS: u64 = 3;

/// Roll and pitch together, to each corner and back, degrees.
const CORNERS_DEG: [(f64, f64); 8] =
    [(60.0, 60.0), (0.0, 0.0), (60.0, -60.0), (0.0, 0.0), (-60.0, 60.0), (0.0, 0.0), (-60.0, -60.0), (0.0, 0.0)];

/// What the motors' limits and several linearisations do in flight: the tables of docs/motor-limits.md and
/// docs/switching-mpc.md.
#[derive(Parser)]
struct Arguments {}

fn main() {
    Arguments::parse();
    let gimbal = VehicleModel::nominal(Rig::Gimbal);
    motor_limits(&gimbal);
    let gravity = Effect::parse("cg_offset:axis=pitch,cos_moment_nm=0.1", Rig::Gimbal).expect("an effect");
    switching("gimbal", &gimbal);
    switching("gimbal, ring's moment 0.1 N m", &VehicleModel { effects: vec![gravity], ..gimbal });
    switching("free flight", &VehicleModel::nominal(Rig::Free));
}

fn motor_limits(model: &VehicleModel) {
    let shaped = TuningChange { mpc_linearisations: Some(4), ..TuningChange::default() };
    let raw = TuningChange { mpc_reference: Some(ReferenceName::Setpoint), ..shaped };
    for throttle in [0.35, 0.5, 0.7] {
        println!("\nThrottle {throttle}\n\n{}", Flown::TABLE_HEAD);
        for (reference, tuning) in [("shaped", shaped), ("raw steps", raw)] {
            let limits =
                |reserve| TuningChange { mpc_motor_limits: Some(true), mpc_torque_reserve: Some(reserve), ..tuning };
            for (name, tuning) in
                [("boxes", tuning), ("motors, reserve 1/2", limits(0.5)), ("motors, reserve 0", limits(0.0))]
            {
                let flown = Flown::mean(model, tuning, &route(&CORNERS_DEG, Some(throttle)), SEEDS);
                println!("| {reference}: {name} | {flown}");
            }
        }
    }
}

fn switching(title: &str, model: &VehicleModel) {
    println!("\n{title}\n\n{}", Flown::TABLE_HEAD);
    let pitch_while_rolled =
        |roll: f64, pitch: f64| vec![(roll, 0.0), (roll, pitch), (roll, 0.0), (roll, -pitch), (roll, 0.0)];
    let small = CORNERS_DEG.map(|(roll, pitch)| (roll / 6.0, pitch / 6.0)).to_vec();
    for (name, positions_deg) in [
        ("60 in pitch while rolled 60", pitch_while_rolled(60.0, 60.0)),
        ("20 in pitch while rolled 60", pitch_while_rolled(60.0, 20.0)),
        ("20 in pitch while rolled 45", pitch_while_rolled(45.0, 20.0)),
        ("60 in both together", CORNERS_DEG.to_vec()),
        ("60 in pitch while level", pitch_while_rolled(0.0, 60.0)),
        ("10 in both together", small),
    ] {
        for linearisations in [1, 2, 4] {
            let tuning = TuningChange { mpc_linearisations: Some(linearisations), ..TuningChange::default() };
            let flown = Flown::mean(model, tuning, &route(&positions_deg, None), SEEDS);
            println!("| {name}: {linearisations} | {flown}");
        }
    }
}
