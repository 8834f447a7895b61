//! The table of docs/refine.md: `cargo run --release -p campaigns --bin refinement [BENCHES]`.

use campaigns::refinement::{Drawn, Outcome, Total};
use rayon::prelude::*;

/// As many as the page's table has.
const BENCHES: u64 = 80;

fn main() {
    let benches = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(BENCHES);
    let outcomes: Vec<Outcome> = (0..benches).into_par_iter().map(|seed| Outcome::of(&Drawn::new(seed))).collect();
    print!("{}", Total(&outcomes));
}
