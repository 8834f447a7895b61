//! The controller's share of the blame: `cargo run --release -p campaigns --bin controller_blame -- [FIRST [COUNT]]`
//! flies COUNT logs (20) with one changed number and as many with none. `tenth` in their place flies a tenth of them,
//! and fails where one is not named.

use std::process::ExitCode;

use campaigns::controller_blame::{Case, Score};

fn main() -> ExitCode {
    let is_tenth = std::env::args().nth(1).is_some_and(|argument| argument == "tenth");
    let mut arguments =
        std::env::args().skip(1 + usize::from(is_tenth)).map(|argument| argument.parse::<u64>().expect("a number"));
    let (first, count) = (arguments.next().unwrap_or(0), arguments.next().unwrap_or(if is_tenth { 2 } else { 20 }));
    let mut score = Score::default();
    for seed in first..first + count {
        for is_changed in [true, false] {
            let case = Case::new(seed, f64::INFINITY, is_changed);
            score.add(&case, &case.examine());
            print!("{}", std::mem::take(&mut score.table));
        }
    }
    println!("\n{}", score.line());
    let is_right = score.named == score.changed && score.sized == score.changed && score.silent == score.nominal;
    if is_tenth && !is_right { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
