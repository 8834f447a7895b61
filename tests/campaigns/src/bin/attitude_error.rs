//! `cargo run --release -p campaigns --bin attitude_error`.

use std::process::ExitCode;

use campaigns::attitude_error::{beside_the_former, drag_rows, drag_table, rows, table};
use campaigns::rows_file::RowsFile;
use clap::Parser;

/// Attitude error over vibration and gyro drift, and over the rotors' drag: the tables of docs/attitude-error.md.
#[derive(Parser)]
struct Arguments {
    /// Fly the draws that served to design the estimator
    #[arg(long)]
    design: bool,
    #[command(flatten)]
    rows: RowsFile,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut rows = beside_the_former(rows(arguments.design));
    let drags = drag_rows();
    print!("{}\n{}", table(&rows), drag_table(&drags));
    rows.extend(drags);
    arguments.rows.write(&rows)
}
