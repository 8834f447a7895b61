//! What a simulation gets wrong, and why.

mod accuracy;
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
mod subject;

use crate::fidelity::{FidelityError, SensorNoise};
use crate::log::Log;
use fit::model_of;
use search::Search;
pub use subject::Subject;

/// First trial: names.
pub fn trial(log: &Log, subject: &Subject<'_>) -> Result<(), FidelityError> {
    let noise = SensorNoise::of(log);
    let shooting = subject.shooting(log, &noise)?;
    let nominal = || subject.model();
    let catalogue = effects::catalogue(&subject.scope(log));
    let search = Search {
        shooting: &shooting,
        nominal: &nominal,
        catalogue: &catalogue,
        always: Vec::new(),
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
            term.effect.told(&term.values),
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
    for candidate in [&found.nominal, &found.chosen] {
        let driven = shooting.drive(model_of(&nominal, &candidate.fit.terms), None);
        let errors = accuracy::prediction_errors(&shooting, &driven, &search.held_out);
        for place in [0, 1, 3, 4] {
            let (rms, floor) = accuracy::root_mean_square(&errors, place).unwrap_or_default();
            print!("  {:.4} ({:.4})", rms.to_degrees(), floor.to_degrees());
        }
        println!();
    }
    println!("{:.2} s", begin.elapsed().as_secs_f64());
    Ok(())
}
