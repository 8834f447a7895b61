//! `cargo run --release -p campaigns --bin notches`.

use std::process::ExitCode;

use campaigns::notches::{rows, table};
use campaigns::rows_file::RowsFile;
use clap::Parser;

/// Noise of the motors' commands at the rotors' lines with and without notches, and what they cost in tracking.
#[derive(Parser)]
struct Arguments {
    #[command(flatten)]
    rows: RowsFile,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let rows = rows();
    print!("{}", table(&rows));
    arguments.rows.write(&rows)
}
