//! Attitude error over vibration and gyro drift, and over the rotors' drag, as the tables of docs/attitude-error.md:
//! `cargo run --release -p campaigns --bin attitude_error`, with `-- --json FILE` also as rows in a file;
//! `--design` flies the draws that served to design the estimator.

use std::process::ExitCode;

use campaigns::attitude_error::{beside_the_former, drag_rows, drag_table, rows, table};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let design = arguments.iter().any(|argument| argument == "--design");
    let arguments: Vec<_> = arguments.into_iter().filter(|argument| argument != "--design").collect();
    let file = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => None,
        ["--json", file] => Some(file.to_owned()),
        _ => {
            eprintln!("usage: attitude_error [--design] [--json FILE]");
            return ExitCode::from(2);
        }
    };
    let mut rows = beside_the_former(rows(design));
    let drags = drag_rows();
    print!("{}\n{}", table(&rows), drag_table(&drags));
    rows.extend(drags);
    if let Some(file) = file
        && let Err(error) = std::fs::write(&file, serde_json::to_string_pretty(&rows).expect("plain numbers"))
    {
        eprintln!("{file}: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
