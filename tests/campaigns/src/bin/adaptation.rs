//! Vehicles that are not what their controller knows, as the tables of docs/learning.md: `cargo run --release -p
//! campaigns --bin adaptation`, with `-- --json FILE` also as rows in a file; `tenth` flies a tenth of it.

use std::process::ExitCode;

use campaigns::adaptation::{rows, table_of_flying, table_of_learning};

/// Vehicles a row.
const VEHICLES: u64 = 200;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let parts = if arguments.iter().any(|argument| argument == "tenth") { 10 } else { 1 };
    let arguments: Vec<_> = arguments.into_iter().filter(|argument| argument != "tenth").collect();
    let file = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => None,
        ["--json", file] => Some(file.to_owned()),
        _ => {
            eprintln!("usage: adaptation [tenth] [--json FILE]");
            return ExitCode::from(2);
        }
    };
    let rows = rows(VEHICLES / parts);
    print!("{}\n{}", table_of_learning(&rows), table_of_flying(&rows));
    if let Some(file) = file
        && let Err(error) = std::fs::write(&file, serde_json::to_string_pretty(&rows).expect("plain numbers"))
    {
        eprintln!("{file}: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
