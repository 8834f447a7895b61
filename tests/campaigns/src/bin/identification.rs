//! `cargo run --release -p campaigns --bin identification`.

use campaigns::identification::{Drawn, Outcome, Total};
use clap::Parser;

/// Vehicles drawn at random, identified from their flights: the table of docs/identification.md.
#[derive(Parser)]
struct Arguments {
    /// As many as the page's table has, if not given
    #[arg(default_value_t = 10)]
    vehicles: u64,
}

fn main() {
    let outcomes: Vec<Outcome> = (0..Arguments::parse().vehicles).map(|seed| Outcome::of(Drawn::new(seed))).collect();
    print!("{}", Total(&outcomes));
}
