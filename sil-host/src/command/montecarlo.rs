//! `sil montecarlo`: many vehicles drawn from a model's tolerances, each flown, and what follows for those who will fly
//! one of them.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use clap::Args;
use clap::builder::RangedU64ValueParser;
use sil_host::answer::montecarlo::{StudyAnswer, StudyJson, Work, page, text};
use sil_host::montecarlo::{About, Share, StoreError, Study, Summary, collect, read_rows};

use super::flight_arguments::FlightArguments;
use super::progress_line::ProgressLine;
use super::{Failure, bad_input, failed, make_folder, print, write_file, write_json};

/// Fly many vehicles drawn from the tolerances of a model: how the figures spread, the worst cases, what they come from
#[derive(Args)]
#[command(after_help = "Example: sil montecarlo --model models/f450-free.toml --runs 1000 --report out/study.html\n\
Example: sil montecarlo --runs 100000 --shard 3/16 --out out/shard-3.parquet  (one of sixteen jobs)\n\
Example: sil montecarlo --summarise out/shard-*.parquet --report out/study.html\n\n\
Tolerances stand in the model file, in a table [tolerance]. A run is decided by the seed and its number, so that what\n\
was interrupted goes on when the command is given again. docs/montecarlo.md explains it.")]
pub struct MontecarloArguments {
    #[command(flatten)]
    flight: FlightArguments,
    /// Vehicles to draw
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = runs())]
    runs: u64,
    /// Seed of the vehicles and of their sensors' noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Fly only a share of the runs, the K-th of N, for a cluster's jobs
    #[arg(long, value_name = "K/N", default_value = "1/1")]
    shard: Shard,
    /// Where the rows go; an interrupted study goes on from what is there
    #[arg(long, value_name = "OUT.parquet", default_value = "out/montecarlo.parquet")]
    out: PathBuf,
    /// Fly nothing: make the answer from these files of rows
    #[arg(long, value_name = "F.parquet", num_args = 1.., conflicts_with_all = ["runs", "seed", "shard", "out"])]
    summarise: Vec<PathBuf>,
    /// Write a page with distributions, causes and worst cases
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the numbers as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// Rows are numbered by what a file's whole numbers hold.
fn runs() -> RangedU64ValueParser<u64> {
    RangedU64ValueParser::new().range(1..=1_000_000_000)
}

/// A share of a study.
#[derive(Clone, Copy)]
struct Shard {
    shard: u64,
    shards: u64,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((shard, shards)) if (1..=shards).contains(&shard) => Ok(Self { shard, shards }),
            _ => Err("expected K/N with K from 1 to N, such as 3/16".to_owned()),
        }
    }
}

pub fn run(arguments: &MontecarloArguments) -> Result<(), Failure> {
    let (paths, work) = if arguments.summarise.is_empty() {
        let work = fly(arguments)?;
        (vec![arguments.out.clone()], work)
    } else {
        (arguments.summarise.clone(), Work::default())
    };
    let answer = answer(&paths)?;
    print(text(&answer))?;
    if work.flown > 0 {
        let (each_ms, threads) = (1e3 * work.elapsed_s * work.threads as f64 / work.flown as f64, work.threads);
        let (flown, elapsed_s) = (work.flown, work.elapsed_s);
        print(format!("\n{flown} vehicles flown in {elapsed_s:.1} s on {threads} threads, {each_ms:.1} ms each\n"))?;
    }
    if arguments.summarise.is_empty() {
        print(format!("rows    {}\n", arguments.out.display()))?;
    }
    if let Some(report) = &arguments.report {
        write_file(report, page(&answer, &command_line(arguments)).to_html().as_bytes())?;
        print(format!("report  {}\n", report.display()))?;
    }
    write_json(arguments.json.as_deref(), &StudyJson::of(&answer, work))
}

/// Flies what is missing of the study's rows.
fn fly(arguments: &MontecarloArguments) -> Result<Work, Failure> {
    let flights = arguments.flight.flights(arguments.seed)?;
    let scenario = flights.first().map_or_else(String::new, |flight| flight.setup.scenario.name.clone());
    let others = arguments.flight.other_options();
    let options: Vec<String> =
        flights.iter().map(|flight| format!(" --controller {}{others}", flight.argument)).collect();
    let flights = flights.into_iter().map(|flight| (flight.name, flight.setup)).collect();
    let study = Study::new(flights, arguments.seed).map_err(bad_input)?;
    let about = About::of(&study, &scenario, &options);
    let Shard { shard, shards } = arguments.shard;
    let share = Share { runs: arguments.runs, shard, shards };
    make_folder(&arguments.out)?;
    let (start, line) = (Instant::now(), ProgressLine::new());
    let progress = |done: u64, total: u64| line.show_count(done, total, "vehicles");
    let collected = collect(&study, &about, &share, &arguments.out, &progress).map_err(|error| match error {
        StoreError::OtherStudy { .. } | StoreError::Draw(_) => bad_input(error),
        StoreError::File { .. } => failed(error),
    })?;
    Ok(Work { flown: collected.flown, elapsed_s: start.elapsed().as_secs_f64(), threads: rayon::current_num_threads() })
}

fn answer(paths: &[PathBuf]) -> Result<StudyAnswer, Failure> {
    let mut summary: Option<Summary> = None;
    let about = read_rows(paths, |about, row| {
        summary.get_or_insert_with(|| Summary::new(&about.plain_columns())).add(&row);
    });
    match (about.map_err(bad_input)?, summary) {
        (Some(about), Some(summary)) => Ok(StudyAnswer::new(about, summary)),
        _ => {
            let path = paths.first().map_or(Path::new("-"), PathBuf::as_path);
            Err(bad_input(format!("{}: holds no runs: a shard of fewer runs than parts has none", path.display())))
        }
    }
}

/// The command that repeats this study.
fn command_line(arguments: &MontecarloArguments) -> String {
    if !arguments.summarise.is_empty() {
        let files: Vec<String> = arguments.summarise.iter().map(|path| path.display().to_string()).collect();
        return format!("sil montecarlo --summarise {}", files.join(" "));
    }
    let MontecarloArguments { flight, runs, seed, shard: Shard { shard, shards }, .. } = arguments;
    let of_share = if *shards > 1 { format!(" --shard {shard}/{shards}") } else { String::new() };
    let (controllers, others) = (flight.controller_options(), flight.other_options());
    format!("sil montecarlo{controllers} --runs {runs} --seed {seed}{of_share}{others}")
}
