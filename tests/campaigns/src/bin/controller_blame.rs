//! Which number of a controller differs from the modelled one:
//! `cargo run --release -p campaigns --bin controller_blame -- [FIRST [COUNT]]` flies COUNT logs (20) with one changed
//! number and as many with none. `tenth` in their place flies a tenth of them, and fails where one is not named.

use std::process::ExitCode;

use campaigns::controller_blame::{Case, Score};
use rayon::prelude::*;

fn main() -> ExitCode {
    let is_tenth = std::env::args().nth(1).is_some_and(|argument| argument == "tenth");
    let mut arguments =
        std::env::args().skip(1 + usize::from(is_tenth)).map(|argument| argument.parse::<u64>().expect("a number"));
    let (first, count) = (arguments.next().unwrap_or(0), arguments.next().unwrap_or(if is_tenth { 2 } else { 20 }));
    let cases: Vec<(u64, bool)> = (first..first + count).flat_map(|seed| [(seed, true), (seed, false)]).collect();
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
    if is_tenth && !is_right { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
