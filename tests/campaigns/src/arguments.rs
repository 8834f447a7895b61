//! What a campaign's program is told: to fly a tenth, and to write its rows to a file.

use std::process::ExitCode;

use serde::Serialize;

/// What stood behind the program's name.
pub struct Arguments {
    /// 10 for a tenth of the campaign, 1 for the whole.
    pub parts: u64,
    /// The program's other word stood there.
    pub has_word: bool,
    file: Option<String>,
}

impl Arguments {
    /// Those of this process; what it does not know is answered with how `program` is called.
    ///
    /// # Errors
    /// The exit status for that.
    pub fn of_process(program: &str) -> Result<Self, ExitCode> {
        Self::read(program, None)
    }

    /// The same of a program that also takes another word.
    ///
    /// # Errors
    /// As [`Self::of_process`].
    pub fn of_process_or(program: &str, word: &str) -> Result<Self, ExitCode> {
        Self::read(program, Some(word))
    }

    fn read(program: &str, word: Option<&str>) -> Result<Self, ExitCode> {
        let mut arguments: Vec<String> = std::env::args().skip(1).collect();
        let mut takes = |word: &str| {
            let before = arguments.len();
            arguments.retain(|argument| argument != word);
            arguments.len() < before
        };
        let parts = if takes("tenth") { 10 } else { 1 };
        let has_word = word.is_some_and(takes);
        match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            [] => Ok(Self { parts, has_word, file: None }),
            ["--json", file] => Ok(Self { parts, has_word, file: Some(file.to_owned()) }),
            _ => {
                let or_word = word.map_or_else(String::new, |word| format!(" | {word}"));
                eprintln!("usage: {program} [tenth{or_word}] [--json FILE]");
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
