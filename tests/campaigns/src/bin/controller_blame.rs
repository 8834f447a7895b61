//! The controller's share of the blame: `cargo run --release -p campaigns --bin controller_blame -- [FIRST [COUNT]]`
//! flies COUNT logs with one changed number and as many with none.

use campaigns::controller_blame::{Case, Score};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>().expect("a number"));
    let (first, count) = (arguments.next().unwrap_or(0), arguments.next().unwrap_or(20));
    let mut score = Score::default();
    for seed in first..first + count {
        for is_changed in [true, false] {
            let case = Case::new(seed, is_changed);
            score.add(&case, &case.examine());
            print!("{}", std::mem::take(&mut score.table));
        }
    }
    println!("\n{}", score.line());
}
