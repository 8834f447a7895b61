//! What many campaigns' programs are told: to fly a tenth, and to write their rows to a file.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde::Serialize;

/// How much of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// A tenth of it.
    Tenth,
}

impl Part {
    /// By what its numbers of flights are divided.
    pub fn divisor(part: Option<Part>) -> u64 {
        if part == Some(Part::Tenth) { 10 } else { 1 }
    }
}

/// Where the rows go besides the tables.
#[derive(Clone, Debug, Default, Args)]
pub struct RowsFile {
    /// Write the rows to this file as JSON, too.
    #[arg(long = "json", value_name = "FILE")]
    file: Option<PathBuf>,
}

impl RowsFile {
    /// Writes the rows, where a file was named; what is in its way is told, and fails.
    pub fn write(&self, rows: &impl Serialize) -> ExitCode {
        match self.written(rows) {
            Ok(()) => ExitCode::SUCCESS,
            Err(reason) => {
                eprintln!("{reason}");
                ExitCode::FAILURE
            }
        }
    }

    /// The same, for who goes on after it.
    ///
    /// # Errors
    /// What is in its way.
    pub fn written(&self, rows: &impl Serialize) -> Result<(), String> {
        let Some(file) = &self.file else { return Ok(()) };
        let text = serde_json::to_string_pretty(rows).map_err(|reason| reason.to_string())?;
        std::fs::write(file, text + "\n").map_err(|reason| format!("{}: {reason}", file.display()))
    }
}
