//! The blind campaigns: `cargo run --release -p campaigns --bin blind_diagnosis -- [CAMPAIGN [COUNT [FIRST [FOLDER]]]]`, CAMPAIGN
//! one of singles, nominal, lost-commands, pairs, triples, outside, free; all of them without one. Tables go to the terminal, every case before
//! them as it is done; logs go to the folder, where one is given.

use campaigns::blind::{Campaign, Case, Outcome};

fn main() {
    // cases are many; more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |place: usize| arguments.get(place).map(|text| text.parse::<u64>().expect("a number"));
    let chosen = |campaign: &&Campaign| arguments.first().is_none_or(|name| name == campaign.name());
    for campaign in Campaign::ALL.iter().filter(chosen) {
        let first = number(2).unwrap_or(0);
        let seeds: Vec<u64> = (first..first + number(1).unwrap_or(campaign.cases())).collect();
        let score = campaign.run(&seeds, |case, outcome| {
            tell(case, outcome);
            if let Some(folder) = arguments.get(3) {
                let file = format!("{folder}/{}-{}.csv", campaign.name(), case.seed);
                std::fs::write(file, &case.csv).expect("the folder is there");
            }
        });
        println!("\n{}", campaign.report(&score));
    }
}

fn tell(case: &Case, outcome: &Outcome) {
    let right =
        outcome.all_named() && outcome.false_findings == 0 && outcome.first_is_right != outcome.hidden.is_empty();
    let sizes: Vec<String> =
        outcome.sizes.iter().map(|size| format!("{:.2} % {:+.1} sigma", 100.0 * size.error, size.deviations)).collect();
    println!(
        "{:4} {} {} -> {} {:?} {:?} ratio {:.2} {} Hz; {} {}",
        case.seed,
        if right { "right" } else { "WRONG" },
        case.label(),
        outcome.found.join(" + "),
        outcome.confounded,
        outcome.verdict,
        outcome.ratio,
        outcome.log_rate_hz,
        sizes.join(", "),
        outcome.signature
    );
    if let Some(gain) = outcome.gain {
        println!("     {gain:.3?}");
    }
}
