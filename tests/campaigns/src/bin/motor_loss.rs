//! Motors that fail in free flight, as the tables of docs/motor-loss.md: `cargo run --release -p campaigns --bin
//! motor_loss`, with `-- --json FILE` also as rows in a file; `tenth` flies a tenth of it.

use std::process::ExitCode;

use campaigns::motor_loss::{alarm_table, alarms, rows, table};

/// Flights of each failure, and minutes without one in each of hover, steps and gusts.
const SEEDS: u64 = 60;
const MINUTES: u64 = 240;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let parts = if arguments.iter().any(|argument| argument == "tenth") { 10 } else { 1 };
    let arguments: Vec<_> = arguments.into_iter().filter(|argument| argument != "tenth").collect();
    let file = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => None,
        ["--json", file] => Some(file.to_owned()),
        _ => {
            eprintln!("usage: motor_loss [tenth] [--json FILE]");
            return ExitCode::from(2);
        }
    };
    let (rows, alarms) = (rows(SEEDS / parts), alarms(MINUTES / parts));
    print!("{}\n{}", table(&rows), alarm_table(&alarms));
    let both = serde_json::json!({ "failures": rows, "alarms": alarms });
    if let Some(file) = file
        && let Err(error) = std::fs::write(&file, serde_json::to_string_pretty(&both).expect("plain numbers"))
    {
        eprintln!("{file}: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
