//! `cargo run --release -p campaigns --bin active_limits`.

use std::process::ExitCode;

use campaigns::active_limits::{find, tables};
use campaigns::rows_file::{Part, RowsFile};
use clap::Parser;

/// Samples on each kind of body: that many without a loss leave less than 1 of 10,000, but for a chance of 1 in 1,000.
const SAMPLES: u64 = 69_080;
/// Throws: less than 3 of 1,000.
const THROWS: u64 = 2_300;

/// The MPC while the motors are at their limits: the tables of docs/mpc-against-cascade.md.
#[derive(Parser)]
struct Arguments {
    part: Option<Part>,
    #[command(flatten)]
    rows: RowsFile,
}

fn main() -> ExitCode {
    let Arguments { part, rows } = Arguments::parse();
    let findings = find(SAMPLES / Part::divisor(part), THROWS / Part::divisor(part));
    print!("{}", tables(&findings));
    rows.write(&findings)
}
