//! `cargo run --release -p campaigns --bin blind_diagnosis`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use campaigns::blind::{BesideReality, Campaign, Case, DURATION_S, Outcome, campaign};
use clap::{Parser, Subcommand};

/// The blind campaigns of docs/diagnosis.md: effects are hidden in simulated logs and looked for. Tables go to the
/// terminal, every case before them as it is done.
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    part: Option<Part>,
    /// One of `singles`, `nominal`, `lost-commands`, `pairs`, `triples`, `outside`, `free` and `reality`; all of them
    /// if none is given
    #[arg(value_parser = campaign_of)]
    campaign: Option<Campaign>,
    /// Cases of each, instead of all
    count: Option<u64>,
    /// Seed of the first one
    #[arg(default_value_t = 0)]
    first: u64,
    /// Where the logs go, and beside them the true vehicles and the model files that are wrong on purpose
    folder: Option<PathBuf>,
}

#[derive(Clone, Copy, Subcommand)]
enum Part {
    /// Run a fixed tenth of each, and fail where fewer answers are right than there were
    Tenth,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.part.is_some() {
        return tenth();
    }
    // cases are many; more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let is_chosen = |campaign: &&Campaign| arguments.campaign.is_none_or(|chosen| chosen == **campaign);
    for campaign in Campaign::ALL.iter().filter(is_chosen) {
        let last = arguments.first.saturating_add(arguments.count.unwrap_or(campaign.cases()));
        let seeds: Vec<u64> = (arguments.first..last).collect();
        let score = campaign.run(&seeds, DURATION_S, |case, outcome| {
            print_case(outcome);
            if let Some(folder) = &arguments.folder
                && let Err(reason) = keep(folder, *campaign, case)
            {
                eprintln!("{}: {reason}", folder.display());
            }
        });
        println!("\n{}", campaign.report(&score));
    }
    ExitCode::SUCCESS
}

fn campaign_of(name: &str) -> Result<Campaign, String> {
    let named = Campaign::ALL.into_iter().find(|campaign| campaign.name() == name);
    named.ok_or_else(|| format!("it may be {}", Campaign::ALL.map(Campaign::name).join(", ")))
}

fn keep(folder: &Path, campaign: Campaign, case: &Case) -> std::io::Result<()> {
    let file = |end: &str| folder.join(format!("{}-{}{end}", campaign.name(), case.seed));
    std::fs::write(file(".csv"), &case.csv)?;
    std::fs::write(file("-truth.toml"), case.vehicle.to_toml())?;
    case.reality.as_ref().map_or(Ok(()), |reality| std::fs::write(file(".toml"), reality.given.to_toml()))
}

/// All campaigns' cases side by side, on all cores; printed in their order.
fn tenth() -> ExitCode {
    let mut is_as_good = true;
    for (campaign, score) in campaign::tenth(DURATION_S) {
        for outcome in score.outcomes.iter().filter(|outcome| !outcome.is_right()) {
            print_case(outcome);
        }
        let (_, least) = campaign.tenth();
        println!("{:13} {:2} right of {}, at least {least}", campaign.name(), score.right(), score.outcomes.len());
        is_as_good &= score.right() >= least;
    }
    if is_as_good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn print_case(outcome: &Outcome) {
    let sizes: Vec<String> =
        outcome.sizes.iter().map(|size| format!("{:.2} % {:+.1} sigma", 100.0 * size.error, size.deviations)).collect();
    println!(
        "{:4} {} {} -> {} {:?} {:?} ratio {:.2} {} Hz; {} {}",
        outcome.seed,
        if outcome.is_right() { "right" } else { "WRONG" },
        outcome.label,
        outcome.found.join(" + "),
        outcome.confounded,
        outcome.verdict,
        outcome.ratio,
        outcome.log_rate_hz,
        sizes.join(", "),
        outcome.signature
    );
    if let Some(beside) = &outcome.beside_reality {
        if let Some(share) = beside.shown {
            println!("     {:.1} % of the error hangs on the cause", 100.0 * share);
        }
        for (figure, truth, told) in beside.figures.iter().filter(|figure| !BesideReality::holds(figure)) {
            println!("     {figure:?}: {truth:.4}, told {told}");
        }
        if !beside.false_names.is_empty() || !beside.wrong_sizes.is_empty() {
            println!("     false {:?}, wrong {:?}", beside.false_names, beside.wrong_sizes);
        }
    }
    if let Some(gain) = outcome.gain {
        println!("     {gain:.3?}");
    }
}
