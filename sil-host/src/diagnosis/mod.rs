//! What a simulation gets wrong, and why.

mod actuation;
mod body;
pub mod effects;
mod fit;
mod hints;
mod linear;
mod prediction;
mod search;
mod sensor;
mod shooting;

use crate::fidelity::{FidelityError, SensorNoise};
use crate::log::Log;
use crate::model::{Rig, VehicleModel};
use actuation::{Commands, Drive};
use body::Body;
use prediction::Model;
use search::Search;
use shooting::{RigChannels, Shooting};

/// First trial: names.
pub fn trial(log: &Log, model: &VehicleModel) -> Result<(), FidelityError> {
    let windows = crate::fidelity::cut_windows(log)?;
    let noise = SensorNoise::of(log);
    println!("noise {noise:?}");
    let motors =
        log.motors().ok_or(FidelityError::MissingColumn { column: "motor1".into(), why: "drives the plant" })?;
    let commands = Commands {
        time_s: log.time_s.clone(),
        value: (0..log.rows()).map(|row| [0, 1, 2, 3].map(|m: usize| motors[m][row])).collect(),
    };
    let gimbal = model.rig() == Rig::Gimbal;
    let rig = RigChannels {
        start_components: if gimbal { vec![0, 1, 3, 4] } else { vec![0, 1, 2, 3, 4, 5] },
        compared: if gimbal { vec![0, 1, 3, 4, 5] } else { vec![0, 1, 2, 3, 4, 5] },
        wraps: true,
    };
    let shooting = Shooting::new(log, commands, windows, &noise, &rig);
    let nominal = || Model::nominal(Drive::of(model), Body::of(model));
    let scope = effects::Scope {
        axes: [true, true, !gimbal],
        rates: [true, true, log.rate_rad_s[2].is_some()],
        angles: [true, true, false],
        turns: [true, true, !gimbal],
        motors: true,
        battery: log.battery_v.is_some(),
        coupled: true,
    };
    let catalogue = effects::catalogue(&scope);
    let search = Search {
        shooting: &shooting,
        nominal: &nominal,
        catalogue: &catalogue,
        training: shooting.part(false),
        held_out: shooting.part(true),
    };
    let begin = std::time::Instant::now();
    let found = search.run();
    let dof = shooting.degrees_of_freedom(&search.held_out);
    println!(
        "nominal: training {:.0}, held out {:.0}, dof {dof:.0}",
        found.nominal.fit.training, found.nominal.held_out
    );
    println!("chosen: training {:.0}, held out {:.0}", found.chosen.fit.training, found.chosen.held_out);
    for (index, term) in found.chosen.fit.terms.iter().enumerate() {
        println!(
            "  {} {:?} {:?} {:?} +- {:?}",
            term.effect.name(),
            term.effect.axis(),
            term.effect.motor(),
            term.values,
            found.chosen.fit.std_of(index)
        );
        for other in &found.alternatives[index] {
            let term = other.fit.terms.last().unwrap();
            println!(
                "      or {} {:?} {:?} {:?}: held out {:.0}",
                term.effect.name(),
                term.effect.axis(),
                term.effect.motor(),
                term.values,
                other.held_out
            );
        }
    }
    println!("{:.2} s", begin.elapsed().as_secs_f64());
    Ok(())
}
