//! What a campaign's program is told: to fly a tenth, and to write its rows to a file.

use std::process::ExitCode;

use serde::Serialize;

/// What stood behind the program's name.
pub struct Arguments {
    /// 10 for a tenth of the campaign, 1 for the whole.
    pub parts: u64,
    /// Recorded flights instead of simulated ones.
    pub on_logs: bool,
    file: Option<String>,
}

impl Arguments {
    /// Those of this process; what it does not know is answered with how `program` is called.
    ///
    /// # Errors
    /// The exit status for that.
    pub fn of_process(program: &str) -> Result<Self, ExitCode> {
        Self::read(program, false)
    }

    /// The same of a program that also takes recorded flights.
    ///
    /// # Errors
    /// As [`Self::of_process`].
    pub fn of_process_or_logs(program: &str) -> Result<Self, ExitCode> {
        Self::read(program, true)
    }

    fn read(program: &str, knows_logs: bool) -> Result<Self, ExitCode> {
        let mut arguments: Vec<String> = std::env::args().skip(1).collect();
        let mut takes = |word: &str| {
            let before = arguments.len();
            arguments.retain(|argument| argument != word);
            arguments.len() < before
        };
        let parts = if takes("tenth") { 10 } else { 1 };
        let on_logs = knows_logs && takes("logs");
        match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            [] => Ok(Self { parts, on_logs, file: None }),
            ["--json", file] => Ok(Self { parts, on_logs, file: Some(file.to_owned()) }),
            _ => {
                let words = if knows_logs { "tenth | logs" } else { "tenth" };
                eprintln!("usage: {program} [{words}] [--json FILE]");
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
