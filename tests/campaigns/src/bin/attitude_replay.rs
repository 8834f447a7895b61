//! `cargo run --release -p campaigns --bin attitude_replay`.

use campaigns::attitude_replay::{replayed, table};
use clap::Parser;

/// The estimator on measured flights, with the logs in `$SIL_DATA`: the table of docs/attitude-error.md.
#[derive(Parser)]
struct Arguments {}

fn main() {
    Arguments::parse();
    print!("{}", table(&replayed()));
}
