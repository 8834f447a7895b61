//! What other people's logs show. The logs are looked for in `$SIL_DATA`.
//!
//! - `cargo run --release -p campaigns --bin real_logs`: the tables of docs/real-logs.md.
//! - `... -- baseline`: CrazyPAD's flights against normal flights of their airframe.
//! - `... -- stand`: what the runs of the 3-DoF stand say of one vehicle's constants.
//! - `... -- scoreboard [OPTIONS]`: how right the diagnosis is on every log (`campaigns::real_logs::scoreboard`).
//! - `... -- injection [OPTIONS]`: are known effects named that were put into each log
//!   (`campaigns::real_logs::injection_score`)? With `--against recorded` or `--against others` the answers are
//!   those of `sil diagnose --baseline` (`campaigns::real_logs::injection_baseline`).
//!
//! Options: `--folder DIR` the logs of this folder, each as `sil diagnose LOG` takes it, with `LOG.map.toml` beside it
//! for its map, instead of those of `$SIL_DATA`; `--only TEXT` (repeatable) logs whose `VEHICLE/LOG` contains it;
//! `--quick` without halves and cuts; `--no-cuts` without cuts; `--no-stability` each answer as `sil diagnose --quick`
//! gives it; `--patience S` no further cut of a log after so many seconds; `--threads N` so many logs side by side (1);
//! `--json FILE` all figures; `--list` the logs' names alone. An injection knows `--folder`, `--only`, `--threads`,
//! `--json`, `--list` and `--against`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;

use campaigns::real_logs::injection_baseline::{self, Normal};
use campaigns::real_logs::scoreboard::{self, Effort, Entry, Scoreboard};
use campaigns::real_logs::{folder, injection_score, stand, tables};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|argument| argument == "--folder") && folder().is_none() {
        return ExitCode::SUCCESS;
    }
    let result = match arguments.split_first() {
        None => {
            tables::print();
            Ok(())
        }
        Some((first, [])) if first == "baseline" => {
            tables::print_baseline();
            Ok(())
        }
        Some((first, [])) if first == "stand" => {
            stand::print();
            Ok(())
        }
        Some((first, options)) if first == "scoreboard" => Options::read(options).and_then(|options| options.score()),
        Some((first, options)) if first == "injection" => Options::read(options).and_then(|options| options.inject()),
        Some((other, _)) => {
            Err(format!("unknown command `{other}`; it may be `baseline`, `stand`, `scoreboard` or `injection`"))
        }
    };
    result.map_or_else(
        |message| {
            eprintln!("{message}");
            ExitCode::from(2)
        },
        |()| ExitCode::SUCCESS,
    )
}

struct Options {
    folder: Option<PathBuf>,
    only: Vec<String>,
    effort: Effort,
    threads: usize,
    json: Option<String>,
    is_list: bool,
    against: Option<Normal>,
}

impl Options {
    fn read(arguments: &[String]) -> Result<Options, String> {
        let effort = Effort { stability: true, halves: true, cuts: true, patience_s: f64::INFINITY };
        let mut options =
            Options { folder: None, only: Vec::new(), effort, threads: 1, json: None, is_list: false, against: None };
        let mut arguments = arguments.iter();
        while let Some(option) = arguments.next() {
            let mut value = || arguments.next().cloned().ok_or(format!("{option} needs a value"));
            match option.as_str() {
                "--folder" => options.folder = Some(PathBuf::from(value()?)),
                "--only" => options.only.push(value()?),
                "--json" => options.json = Some(value()?),
                "--threads" => options.threads = number(&value()?)?,
                "--patience" => options.effort.patience_s = number(&value()?)?,
                "--quick" => options.effort = Effort { halves: false, cuts: false, ..options.effort },
                "--no-cuts" => options.effort.cuts = false,
                "--no-stability" => options.effort.stability = false,
                "--against" => options.against = Some(normal(&value()?)?),
                "--list" => options.is_list = true,
                other => return Err(format!("unknown option `{other}`")),
            }
        }
        Ok(options)
    }

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
        if self.is_list {
            entries.iter().for_each(|entry| println!("{}", entry.label()));
            entries.clear();
        }
        Ok(entries)
    }

    fn score(&self) -> Result<(), String> {
        let entries = self.entries()?;
        // a campaign of hours that is ended early leaves the figures that it had
        let so_far = Mutex::new(BTreeMap::new());
        let logs = scoreboard::side_by_side(
            &entries,
            self.threads,
            |entry| scoreboard::score(entry, &self.effort),
            |place, score| {
                eprint!("{}", scoreboard::of_log(score));
                let mut so_far = so_far.lock().expect("no thread panics here");
                so_far.insert(place, score.clone());
                if let Err(message) = self.write(&Scoreboard::of(so_far.values().cloned().collect())) {
                    eprintln!("{message}");
                }
            },
        );
        if self.is_list {
            return Ok(());
        }
        logs.iter().for_each(|score| print!("{}", scoreboard::of_log(score)));
        println!("\n{}", scoreboard::of_summary(&logs));
        self.write(&Scoreboard::of(logs))
    }

    fn inject(&self) -> Result<(), String> {
        let score = |entry: &Entry| match self.against {
            Some(normal) => injection_baseline::score(entry, normal),
            None => injection_score::score(entry),
        };
        let outcomes = scoreboard::side_by_side(&self.entries()?, self.threads, score, |_, outcomes| {
            outcomes.iter().for_each(|one| eprintln!("{}", injection_score::line(one)))
        });
        if self.is_list {
            return Ok(());
        }
        let outcomes = outcomes.concat();
        print!("{}", injection_score::table(&outcomes));
        self.write(&outcomes)
    }

    fn write(&self, figures: &impl serde::Serialize) -> Result<(), String> {
        let Some(file) = &self.json else { return Ok(()) };
        let text = serde_json::to_string_pretty(figures).map_err(|e| e.to_string())?;
        std::fs::write(file, text + "\n").map_err(|e| format!("{file}: {e}"))
    }
}

fn normal(text: &str) -> Result<Normal, String> {
    match text {
        "recorded" => Ok(Normal::Recorded),
        "others" => Ok(Normal::Others),
        _ => Err(format!("`{text}` is no baseline: it may be `recorded` or `others`")),
    }
}

fn number<N: std::str::FromStr>(text: &str) -> Result<N, String> {
    text.parse().map_err(|_| format!("`{text}` is no number"))
}
