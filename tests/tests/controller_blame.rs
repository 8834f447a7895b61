//! A part of `cargo run --release -p campaigns --bin controller_blame`: a changed number of a controller is named and
//! measured, whatever the plant does; where nothing changed nothing is named. A quarter of the test sequence is enough
//! for that.

use campaigns::controller_blame::{Case, Score};

fn score(seed: u64, is_changed: bool) -> Score {
    let mut score = Score::default();
    let case = Case::new(seed, 8.0, is_changed);
    score.add(&case, &case.examine());
    println!("{}", score.table);
    score
}

/// A cascade beside an effect in the plant. CI's tenth has a changed MPC too.
#[test]
fn a_changed_gain_is_named() {
    let score = score(2, true);
    assert_eq!((score.named, score.sized), (1, 1), "{}", score.table);
}
