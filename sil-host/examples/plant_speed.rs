//! How long plant and sensors take for one control period and one sample: `cargo run --release --example plant_speed`.

use std::time::Instant;

use sil_host::effects::Effect;
use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::Plant;
use sil_host::sensors::Sensors;

const PERIODS: usize = 400_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for rig in [Rig::Gimbal, Rig::Free] {
        let nominal = VehicleModel::nominal(rig);
        println!("{}: {:.0} ns per IMU sample", nominal.name, sample_ns(&nominal));
        let mut extended = nominal.clone();
        let effect = Effect::parse("cg_offset:axis=pitch,cos_moment_nm=0.1", rig)?;
        extended.effects.push(effect);
        for (model, what) in [(&nominal, "nominal"), (&extended, "with cg_offset")] {
            println!("{}, {what}: {:.0} ns per 2.5 ms", model.name, period_ns(model));
        }
    }
    Ok(())
}

/// Best of seven runs, the commands changing every period.
fn period_ns(model: &VehicleModel) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..7 {
        let mut plant = Plant::new(model);
        let base = model.base_command;
        let start = Instant::now();
        for period in 0..PERIODS {
            let step = if period % 16 < 8 { 0.01 } else { -0.01 };
            plant.set_commands([base + step, base - step, base + step, base - step]);
            plant.advance(2.5e-3);
        }
        assert!(plant.truth().roll_rad.is_finite());
        best = best.min(start.elapsed().as_secs_f64() / PERIODS as f64);
    }
    best * 1e9
}

/// Best of seven runs of reading the IMU of a vehicle at rest.
fn sample_ns(model: &VehicleModel) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..7 {
        let plant = Plant::new(model);
        let mut sensors = Sensors::new(&model.noise, 1);
        let start = Instant::now();
        for period in 0..PERIODS {
            std::hint::black_box(sensors.imu(std::hint::black_box(&plant), period as u64));
        }
        best = best.min(start.elapsed().as_secs_f64() / PERIODS as f64);
    }
    best * 1e9
}
