//! What a campaign's program is told: to fly a tenth, and to write its rows to a file.

use std::process::ExitCode;

use serde::Serialize;

/// What stood behind the program's name.
pub struct Arguments {
    /// 10 for a tenth of the campaign, 1 for the whole.
    pub parts: u64,
    /// Recorded flights instead of simulated ones; only of a program that says so.
    pub on_logs: bool,
    file: Option<String>,
}

impl Arguments {
    /// Those of this process; what it does not know is answered with how `program` is called.
    ///
    /// # Errors
    /// The exit status for that.
    pub fn of_process(program: &str) -> Result<Self, ExitCode> {
        let mut arguments: Vec<String> = std::env::args().skip(1).collect();
        let parts = if arguments.iter().any(|argument| argument == "tenth") { 10 } else { 1 };
        arguments.retain(|argument| argument != "tenth");
        let on_logs = program == "motor_loss" && arguments.first().is_some_and(|argument| argument == "logs");
        arguments.drain(..usize::from(on_logs));
        match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            [] => Ok(Self { parts, on_logs, file: None }),
            ["--json", file] => Ok(Self { parts, on_logs, file: Some(file.to_owned()) }),
            _ => {
                eprintln!("usage: {program} [tenth] [--json FILE]");
                Err(ExitCode::from(2))
            }
        }
    }

    /// Writes the rows, where a file was named.
    ///
    /// # Panics
    /// If they are no plain numbers and texts.
    pub fn write(&self, rows: &impl Serialize) -> ExitCode {
        if let Some(file) = &self.file
            && let Err(error) = std::fs::write(file, serde_json::to_string_pretty(rows).expect("plain numbers"))
        {
            eprintln!("{file}: {error}");
            return ExitCode::FAILURE;
        }
        ExitCode::SUCCESS
    }
}
