//! MPC against the cascade: `cargo run --release -p campaigns --bin controller_comparison -- [scan | tune |
//! front [free] | chosen [DRAWS] | free [DRAWS] | shipped [DRAWS] | DRAWS] [--json FILE]`. `scan` tunes both at some
//! shapings, `tune` writes the controller files of those tuned for RMS, `front` makes the Pareto study, on the gimbal
//! or in free flight, and writes the files of its balanced points, all under tests/campaigns/comparison; `chosen` flies
//! those of the gimbal over so many draws (200), `free` those of free flight and what follows from the vehicle,
//! `shipped` the latter on both rigs; otherwise all that were tuned for RMS and parts of them are flown. Rows of the
//! last five as JSON.

use std::path::Path;
use std::process::ExitCode;

use campaigns::comparison::campaign;
use serde::Serialize;
use sil_host::model::Rig;

fn main() -> ExitCode {
    // flights are many and short; more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let named = words.iter().position(|word| word == "--json");
    let file = named.filter(|&place| place + 2 == words.len()).and_then(|place| words.drain(place..).nth(1));
    let file = file.as_deref();
    let ended = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["scan"] if file.is_none() => {
            print!("{}", campaign::scan());
            Some(ExitCode::SUCCESS)
        }
        ["tune"] if file.is_none() => {
            tune();
            Some(ExitCode::SUCCESS)
        }
        ["front"] => Some(front(Rig::Gimbal, file)),
        ["front", "free"] => Some(front(Rig::Free, file)),
        ["chosen"] => Some(show(&campaign::chosen(campaign::DRAWS), file)),
        ["chosen", count] => draws(count).map(|count| show(&campaign::chosen(count), file)),
        ["free"] => Some(show(&campaign::in_free_flight(campaign::DRAWS), file)),
        ["free", count] => draws(count).map(|count| show(&campaign::in_free_flight(count), file)),
        ["shipped"] => Some(shipped(campaign::DRAWS, file)),
        ["shipped", count] => draws(count).map(|count| shipped(count, file)),
        [] => Some(all(campaign::DRAWS, file)),
        [count] => draws(count).map(|count| all(count, file)),
        _ => None,
    };
    ended.unwrap_or_else(|| {
        eprintln!(
            "usage: controller_comparison [scan | tune | front [free] | chosen [DRAWS] | free [DRAWS] | \
             shipped [DRAWS] | DRAWS] [--json FILE]"
        );
        ExitCode::from(2)
    })
}

fn draws(word: &str) -> Option<u64> {
    word.parse().ok().filter(|&count| count > 0)
}

fn all(count: u64, file: Option<&str>) -> ExitCode {
    let results = campaign::results(count);
    print!("{}", campaign::report(&results));
    write_rows(file, &results)
}

fn shipped(count: u64, file: Option<&str>) -> ExitCode {
    let both = campaign::shipped(count);
    print!("{}", both.each_ref().map(campaign::shown_report).join("\n"));
    write_rows(file, &both)
}

fn show(shown: &campaign::Shown, file: Option<&str>) -> ExitCode {
    print!("{}", campaign::shown_report(shown));
    write_rows(file, shown)
}

fn front(rig: Rig, file: Option<&str>) -> ExitCode {
    let outcome = campaign::front(rig);
    print!("{}", campaign::front_report(&outcome));
    let names = match rig {
        Rig::Gimbal => ["mpc.toml", "cascade.toml"],
        Rig::Free => ["mpc-free.toml", "cascade-free.toml"],
    };
    for (name, text) in names.into_iter().zip(&outcome.files) {
        match text {
            Some(text) => keep(name, text),
            None => eprintln!("{name}: no point within the limits, the file stays"),
        }
    }
    write_rows(file, &outcome.rows)
}

fn tune() {
    let names = ["mpc-for-rms.toml", "cascade-for-rms.toml", "indi.toml"];
    names.into_iter().zip(&campaign::tune()).for_each(|(name, text)| keep(name, text));
}

/// Writes a controller file, and shows it.
fn keep(name: &str, text: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("comparison");
    std::fs::write(folder.join(name), text).expect("the folder is there");
    println!("\n{name}:\n{text}");
}

fn write_rows(file: Option<&str>, rows: &impl Serialize) -> ExitCode {
    if let Some(file) = file
        && let Err(error) = std::fs::write(file, serde_json::to_string(rows).expect("plain numbers"))
    {
        eprintln!("{file}: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
