//! Motors that fail in free flight, as the tables of docs/motor-loss.md: `cargo run --release -p campaigns --bin
//! motor_loss`, with `-- --json FILE` also as rows in a file; `tenth` flies a tenth of it. `-- logs` goes through
//! flights that other people recorded instead.

use std::process::ExitCode;

use campaigns::arguments::Arguments;
use campaigns::motor_loss::{alarm_table, alarms, real_logs, rows, table};

/// Flights of each failure, 14,560 in all with a core that can notice it; and minutes without one, 100 hours in all.
const SEEDS: u64 = 140;
const MINUTES: u64 = 750;

fn main() -> ExitCode {
    let arguments = match Arguments::of_process_or("motor_loss", "logs") {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    if arguments.has_word {
        let (quiet, found) = real_logs::searched();
        print!("{}", real_logs::table(&quiet, &found));
        return arguments.write(&serde_json::json!({ "as_recorded": quiet, "with_losses": found }));
    }
    let (rows, alarms) = (rows(SEEDS / arguments.parts), alarms(MINUTES / arguments.parts));
    print!("{}\n{}", table(&rows), alarm_table(&alarms));
    arguments.write(&serde_json::json!({ "failures": rows, "alarms": alarms }))
}
