//! The `sil` command: reads the command line, calls the library, prints, and decides the exit status.

mod command;

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = command::Arguments::of_process();
    match command::run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // nobody may be listening; the status still shows it
            let _ = writeln!(std::io::stderr(), "error: {}", failure.message);
            ExitCode::from(failure.status)
        }
    }
}
