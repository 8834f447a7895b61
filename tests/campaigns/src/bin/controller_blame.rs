//! `cargo run --release -p campaigns --bin controller_blame`.

use std::process::ExitCode;

use campaigns::controller_blame::{Case, Score};
use clap::{Parser, Subcommand};
use rayon::prelude::*;

/// Which number of a controller differs from the modelled one: flies logs with one changed number, and as many with
/// none (docs/thesis-case.md).
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    part: Option<Part>,
    /// Seed of the first log
    #[arg(default_value_t = 0)]
    first: u64,
    /// Logs of each kind
    #[arg(default_value_t = 20)]
    count: u64,
}

#[derive(Clone, Copy, Subcommand)]
enum Part {
    /// Fly a tenth of them, and fail where a number is not named
    Tenth,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let count = if arguments.part.is_some() { arguments.count / 10 } else { arguments.count };
    let seeds = arguments.first..arguments.first.saturating_add(count);
    let cases: Vec<(u64, bool)> = seeds.flat_map(|seed| [(seed, true), (seed, false)]).collect();
    let examined = |(seed, is_changed): &(u64, bool)| {
        let case = Case::new(*seed, f64::INFINITY, *is_changed);
        let examination = case.examine();
        (case, examination)
    };
    let examined: Vec<_> = cases.par_iter().with_max_len(1).map(examined).collect();
    let mut score = Score::default();
    for (case, examination) in &examined {
        score.add(case, examination);
    }
    println!("{}\n{}", score.table, score.line());
    let is_right = score.named == score.changed && score.sized == score.changed && score.silent == score.nominal;
    if arguments.part.is_some() && !is_right { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
