//! `cargo run --release -p campaigns --bin real_logs`. The logs are looked for in `$SIL_DATA`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;

use campaigns::real_logs::injection_baseline::{self, Normal};
use campaigns::real_logs::scoreboard::{self, Effort, Entry, Scoreboard};
use campaigns::real_logs::{folder, injection_score, stand, tables};
use campaigns::rows_file::RowsFile;
use clap::{Args, Parser, Subcommand};

/// What other people's logs show, in `$SIL_DATA`: the tables of docs/real-logs.md.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// CrazyPAD's flights against normal flights of their airframe
    Baseline,
    /// What the runs of the 3-DoF stand say of one vehicle's constants
    Stand,
    /// How right the diagnosis is on every log
    Scoreboard {
        #[command(flatten)]
        logs: Logs,
        /// Without halves and cuts
        #[arg(long)]
        quick: bool,
        /// Without cuts
        #[arg(long)]
        no_cuts: bool,
        /// Each answer as `sil diagnose --quick` gives it
        #[arg(long)]
        no_stability: bool,
        /// No further cut of a log after so many seconds
        #[arg(long, value_name = "SECONDS", default_value_t = f64::INFINITY, hide_default_value = true)]
        patience: f64,
    },
    /// Are known effects named that were put into each log?
    Injection {
        #[command(flatten)]
        logs: Logs,
        /// Answers of `sil diagnose --baseline`, the log as it was recorded or other logs of the vehicle being normal
        #[arg(long)]
        against: Option<Normal>,
    },
}

#[derive(Args)]
struct Logs {
    /// The logs of this folder instead of those of `$SIL_DATA`, each with LOG.map.toml beside it for its map
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    /// Logs whose VEHICLE/LOG contains it; repeatable
    #[arg(long, value_name = "TEXT")]
    only: Vec<String>,
    /// So many logs side by side
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
    /// The logs' names alone
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    figures: RowsFile,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let logs = match &arguments.command {
        Some(Command::Scoreboard { logs, .. } | Command::Injection { logs, .. }) => Some(logs),
        _ => None,
    };
    if logs.is_none_or(|logs| logs.folder.is_none()) && folder().is_none() {
        return ExitCode::SUCCESS;
    }
    let result = match arguments.command {
        None => {
            tables::print();
            Ok(())
        }
        Some(Command::Baseline) => {
            tables::print_baseline();
            Ok(())
        }
        Some(Command::Stand) => {
            stand::print();
            Ok(())
        }
        Some(Command::Scoreboard { logs, quick, no_cuts, no_stability, patience }) => {
            let (halves, cuts) = (!quick, !quick && !no_cuts);
            logs.score(&Effort { stability: !no_stability, halves, cuts, patience_s: patience })
        }
        Some(Command::Injection { logs, against }) => logs.inject(against),
    };
    result.map_or_else(
        |message| {
            eprintln!("{message}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}

impl Logs {
    /// The logs that are chosen; none where only their names are wanted, which it prints.
    fn entries(&self) -> Result<Vec<Entry>, String> {
        let is_chosen = |label: &str| self.only.is_empty() || self.only.iter().any(|text| label.contains(text));
        let mut entries = match &self.folder {
            None => scoreboard::entries(),
            Some(folder) => {
                let mut paths = scoreboard::files_of(folder)?;
                paths.retain(|path| is_chosen(&path.to_string_lossy()));
                let read = scoreboard::side_by_side(&paths, self.threads, |path| Entry::of_file(path), |_, _| ());
                let said = |(path, read): (&PathBuf, Result<Entry, String>)| {
                    read.inspect_err(|reason| println!("{}: no answer: {reason}\n", path.display())).ok()
                };
                paths.iter().zip(read).filter_map(said).collect()
            }
        };
        entries.retain(|entry| self.folder.is_some() || is_chosen(&entry.label()));
        if self.list {
            entries.iter().for_each(|entry| println!("{}", entry.label()));
            entries.clear();
        }
        Ok(entries)
    }

    fn score(&self, effort: &Effort) -> Result<(), String> {
        let entries = self.entries()?;
        // a campaign of hours that is ended early leaves the figures that it had
        let so_far = Mutex::new(BTreeMap::new());
        let logs = scoreboard::side_by_side(
            &entries,
            self.threads,
            |entry| scoreboard::score(entry, effort),
            |place, score| {
                eprint!("{}", scoreboard::of_log(score));
                let mut so_far = so_far.lock().expect("no thread panics here");
                so_far.insert(place, score.clone());
                if let Err(message) = self.figures.written(&Scoreboard::of(so_far.values().cloned().collect())) {
                    eprintln!("{message}");
                }
            },
        );
        if self.list {
            return Ok(());
        }
        logs.iter().for_each(|score| print!("{}", scoreboard::of_log(score)));
        println!("\n{}", scoreboard::of_summary(&logs));
        self.figures.written(&Scoreboard::of(logs))
    }

    fn inject(&self, against: Option<Normal>) -> Result<(), String> {
        let score = |entry: &Entry| match against {
            Some(normal) => injection_baseline::score(entry, normal),
            None => injection_score::score(entry),
        };
        let outcomes = scoreboard::side_by_side(&self.entries()?, self.threads, score, |_, outcomes| {
            outcomes.iter().for_each(|one| eprintln!("{}", injection_score::line(one)))
        });
        if self.list {
            return Ok(());
        }
        let outcomes = outcomes.concat();
        print!("{}", injection_score::table(&outcomes));
        self.figures.written(&outcomes)
    }
}
