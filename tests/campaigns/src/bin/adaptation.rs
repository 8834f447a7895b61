//! Vehicles that are not what their controller knows, as the tables of docs/learning.md: `cargo run --release -p
//! campaigns --bin adaptation`, with `-- --json FILE` also as rows in a file; `tenth` flies a tenth of it,
//! `tenthousand` as many vehicles in all.

use std::process::ExitCode;

use campaigns::adaptation::{rows, table_of_flying, table_of_learning};
use campaigns::arguments::Arguments;

/// Vehicles a row.
const VEHICLES: u64 = 200;
/// The same for ten thousand in all.
const MANY_VEHICLES: u64 = 1000;

fn main() -> ExitCode {
    let arguments = match Arguments::of_process_or("adaptation", "tenthousand") {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    let vehicles = if arguments.has_word { MANY_VEHICLES } else { VEHICLES };
    let rows = rows(vehicles / arguments.parts);
    print!("{}\n{}", table_of_learning(&rows), table_of_flying(&rows));
    arguments.write(&rows)
}
