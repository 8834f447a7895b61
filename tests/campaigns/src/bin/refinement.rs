//! `cargo run --release -p campaigns --bin refinement`.

use campaigns::refinement::{Drawn, Outcome, Total};
use clap::Parser;
use rayon::prelude::*;

/// Benches of propulsions drawn at random: the table of docs/refine.md.
#[derive(Parser)]
struct Arguments {
    /// As many as the page's table has, if not given
    #[arg(default_value_t = 80)]
    benches: u64,
    /// Seed of the first one; those below the page's served the design of the estimator
    #[arg(default_value_t = 1000)]
    first: u64,
}

fn main() {
    let Arguments { benches, first } = Arguments::parse();
    let seeds = first..first.saturating_add(benches);
    let outcomes: Vec<Outcome> = seeds.into_par_iter().map(|seed| Outcome::of(&Drawn::new(seed))).collect();
    print!("{}", Total(&outcomes));
}
