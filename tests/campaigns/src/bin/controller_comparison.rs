//! `cargo run --release -p campaigns --bin controller_comparison`.

use std::path::Path;
use std::process::ExitCode;

use campaigns::comparison::campaign::{self, DRAWS};
use campaigns::rows_file::RowsFile;
use clap::{Parser, Subcommand, ValueEnum};
use sil_host::model::Rig;

/// MPC against the cascade: the tables of docs/mpc-against-cascade.md and docs/tuning.md. Without a command all that
/// were tuned for RMS and parts of them are flown.
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    flights: Flights,
}

#[derive(clap::Args)]
struct Flights {
    /// Vehicles and gusts that are drawn
    #[arg(default_value_t = DRAWS, value_parser = clap::value_parser!(u64).range(1..))]
    draws: u64,
    #[command(flatten)]
    rows: RowsFile,
}

#[derive(Subcommand)]
enum Command {
    /// Tune both at some shapings
    Scan,
    /// Write the controller files of those tuned for RMS, under tests/campaigns/comparison
    Tune,
    /// Make the Pareto study, and write the files of its balanced points, under tests/campaigns/comparison
    Front {
        #[arg(value_enum, default_value_t = On::Gimbal)]
        rig: On,
        #[command(flatten)]
        rows: RowsFile,
    },
    /// Fly the balanced points of the gimbal
    Chosen(Flights),
    /// Fly those of free flight, and what follows from the vehicle
    Free(Flights),
    /// Fly what follows from the vehicle, on both rigs
    Shipped(Flights),
}

#[derive(Clone, Copy, ValueEnum)]
enum On {
    /// The thesis' testbed
    Gimbal,
    /// In free flight
    Free,
}

fn main() -> ExitCode {
    // flights are many and short; more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let arguments = Arguments::parse();
    match arguments.command {
        Some(Command::Scan) => {
            print!("{}", campaign::scan());
            ExitCode::SUCCESS
        }
        Some(Command::Tune) => {
            let names = ["mpc-for-rms.toml", "cascade-for-rms.toml", "indi.toml"];
            names.into_iter().zip(&campaign::tune()).for_each(|(name, text)| keep(name, text));
            ExitCode::SUCCESS
        }
        Some(Command::Front { rig: On::Gimbal, rows }) => front(Rig::Gimbal, &rows),
        Some(Command::Front { rig: On::Free, rows }) => front(Rig::Free, &rows),
        Some(Command::Chosen(Flights { draws, rows })) => show(&campaign::chosen(draws), &rows),
        Some(Command::Free(Flights { draws, rows })) => show(&campaign::in_free_flight(draws), &rows),
        Some(Command::Shipped(Flights { draws, rows })) => {
            let both = campaign::shipped(draws);
            print!("{}", both.each_ref().map(campaign::shown_report).join("\n"));
            rows.write(&both)
        }
        None => {
            let results = campaign::results(arguments.flights.draws);
            print!("{}", campaign::report(&results));
            arguments.flights.rows.write(&results)
        }
    }
}

fn show(shown: &campaign::Shown, rows: &RowsFile) -> ExitCode {
    print!("{}", campaign::shown_report(shown));
    rows.write(shown)
}

fn front(rig: Rig, rows: &RowsFile) -> ExitCode {
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
    rows.write(&outcome.rows)
}

/// Writes a controller file, and shows it.
fn keep(name: &str, text: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("comparison");
    std::fs::write(folder.join(name), text).expect("the folder is there");
    println!("\n{name}:\n{text}");
}
