//! The blind campaigns: `cargo run --release -p campaigns --bin blind_diagnosis -- [CAMPAIGN [COUNT [FIRST
//! [FOLDER]]]]`, CAMPAIGN one of singles, nominal, lost-commands, pairs, triples, outside, free, reality; all of them
//! without one. Tables go to the terminal, every case before them as it is done; logs go to the folder, where one is
//! given, and beside them the true vehicles and the model files that are wrong on purpose.
//!
//! `tenth` in the campaign's place runs a fixed tenth of each, and fails where fewer answers are right than there were.

use std::process::ExitCode;

use campaigns::blind::{BesideReality, Campaign, DURATION_S, Outcome, campaign};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.first().is_some_and(|first| first == "tenth") {
        return tenth();
    }
    // cases are many; more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let number = |place: usize| arguments.get(place).map(|text| text.parse::<u64>().expect("a number"));
    let chosen = |campaign: &&Campaign| arguments.first().is_none_or(|name| name == campaign.name());
    for campaign in Campaign::ALL.iter().filter(chosen) {
        let first = number(2).unwrap_or(0);
        let seeds: Vec<u64> = (first..first + number(1).unwrap_or(campaign.cases())).collect();
        let score = campaign.run(&seeds, DURATION_S, |case, outcome| {
            print_case(outcome);
            if let Some(folder) = arguments.get(3) {
                let file = |end: &str| format!("{folder}/{}-{}{end}", campaign.name(), case.seed);
                std::fs::write(file(".csv"), &case.csv).expect("the folder is there");
                std::fs::write(file("-truth.toml"), case.vehicle.to_toml()).expect("the folder is there");
                if let Some(reality) = &case.reality {
                    std::fs::write(file(".toml"), reality.given.to_toml()).expect("the folder is there");
                }
            }
        });
        println!("\n{}", campaign.report(&score));
    }
    ExitCode::SUCCESS
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
