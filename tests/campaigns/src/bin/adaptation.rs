//! Vehicles that are not what their controller knows, as the tables of docs/learning.md: `cargo run --release -p
//! campaigns --bin adaptation`, with `-- --json FILE` also as rows in a file; `tenth` flies a tenth of it.

use std::process::ExitCode;

use campaigns::adaptation::{rows, table_of_flying, table_of_learning};
use campaigns::arguments::Arguments;

/// Vehicles a row.
const VEHICLES: u64 = 200;

fn main() -> ExitCode {
    let arguments = match Arguments::of_process("adaptation") {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    let rows = rows(VEHICLES / arguments.parts);
    print!("{}\n{}", table_of_learning(&rows), table_of_flying(&rows));
    arguments.write(&rows)
}
