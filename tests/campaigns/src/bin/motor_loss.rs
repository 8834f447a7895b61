//! `cargo run --release -p campaigns --bin motor_loss`.

use std::process::ExitCode;

use campaigns::motor_loss::{alarm_table, alarms, real_logs, rows, table};
use campaigns::rows_file::RowsFile;
use clap::{Parser, ValueEnum};

/// Flights of each failure, 14,560 in all with a core that can notice it; and minutes without one, 100 hours in all.
const SEEDS: u64 = 140;
const MINUTES: u64 = 750;

/// Motors that fail in free flight: the tables of docs/motor-loss.md.
#[derive(Parser)]
struct Arguments {
    part: Option<Part>,
    #[command(flatten)]
    rows: RowsFile,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// A tenth of it
    Tenth,
    /// Flights that other people recorded instead, in `$SIL_DATA`
    Logs,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.part == Some(Part::Logs) {
        let (quiet, found) = real_logs::searched();
        print!("{}", real_logs::table(&quiet, &found));
        return arguments.rows.write(&serde_json::json!({ "as_recorded": quiet, "with_losses": found }));
    }
    let divisor = if arguments.part.is_some() { 10 } else { 1 };
    let (rows, alarms) = (rows(SEEDS / divisor), alarms(MINUTES / divisor));
    print!("{}\n{}", table(&rows), alarm_table(&alarms));
    arguments.rows.write(&serde_json::json!({ "failures": rows, "alarms": alarms }))
}
