//! `cargo run --release -p campaigns --bin adaptation`.

use std::process::ExitCode;

use campaigns::adaptation::{rows, table_of_flying, table_of_learning};
use campaigns::rows_file::RowsFile;
use clap::{Parser, ValueEnum};

/// Vehicles that are not what their controller knows: the tables of docs/learning.md, 200 vehicles a row.
#[derive(Parser)]
struct Arguments {
    part: Option<Part>,
    #[command(flatten)]
    rows: RowsFile,
}

#[derive(Clone, Copy, ValueEnum)]
enum Part {
    /// 20 vehicles a row
    Tenth,
    /// 1000 vehicles a row, ten thousand in all
    Tenthousand,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let vehicles = match arguments.part {
        Some(Part::Tenth) => 20,
        None => 200,
        Some(Part::Tenthousand) => 1000,
    };
    let rows = rows(vehicles);
    print!("{}\n{}", table_of_learning(&rows), table_of_flying(&rows));
    arguments.rows.write(&rows)
}
