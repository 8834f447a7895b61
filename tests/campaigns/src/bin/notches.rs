//! Noise of the motors' commands at the rotors' lines with and without notches, and what they cost in tracking:
//! `cargo run --release -p campaigns --bin notches`, with `-- --json FILE` also as rows in a file.

use std::process::ExitCode;

use campaigns::notches::{rows, table};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let file = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => None,
        ["--json", file] => Some(file.to_owned()),
        _ => {
            eprintln!("usage: notches [--json FILE]");
            return ExitCode::from(2);
        }
    };
    let rows = rows();
    print!("{}", table(&rows));
    if let Some(file) = file
        && let Err(error) = std::fs::write(&file, serde_json::to_string_pretty(&rows).expect("plain numbers"))
    {
        eprintln!("{file}: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
