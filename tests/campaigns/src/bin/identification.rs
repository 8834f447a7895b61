//! The table of docs/identification.md: `cargo run --release -p campaigns --bin identification [VEHICLES]`.

use campaigns::identification::{Drawn, Outcome, Total};

/// As many as the page's table has.
const VEHICLES: u64 = 10;

fn main() {
    let vehicles = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(VEHICLES);
    let outcomes: Vec<Outcome> = (0..vehicles).map(|seed| Outcome::of(Drawn::new(seed))).collect();
    print!("{}", Total(&outcomes));
}
