//! The table of docs/refine.md: `cargo run --release -p campaigns --bin refinement [BENCHES [FIRST]]`.

use campaigns::refinement::{Drawn, Outcome, Total};
use rayon::prelude::*;

/// As many as the page's table has.
const BENCHES: u64 = 80;
/// The page's first; those below served the design of the estimator.
const FIRST: u64 = 1000;

fn main() {
    let number = |place: usize| std::env::args().nth(place).map(|text| text.parse::<u64>().expect("a number"));
    let (benches, first) = (number(1).unwrap_or(BENCHES), number(2).unwrap_or(FIRST));
    let outcomes: Vec<Outcome> =
        (first..first + benches).into_par_iter().map(|seed| Outcome::of(&Drawn::new(seed))).collect();
    print!("{}", Total(&outcomes));
}
