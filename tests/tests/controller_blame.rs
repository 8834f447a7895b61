//! A part of `cargo run --release -p campaigns --bin controller_blame`: a changed number of a controller is named and
//! measured, whatever the plant does; where nothing changed nothing is named. A third of the test sequence is enough
//! for that.

use campaigns::controller_blame::{Case, Score};

/// A changed cascade and a nominal MPC, an effect in the plant beside both. CI's tenth has a changed MPC too.
#[test]
fn a_changed_gain_is_named_and_an_unchanged_one_is_not() {
    let mut score = Score::default();
    for (seed, is_changed) in [(2, true), (7, false)] {
        let case = Case::new(seed, 10.5, is_changed);
        score.add(&case, &case.examine());
    }
    println!("{}", score.table);
    assert_eq!((score.named, score.silent), (1, 1), "{}", score.table);
    assert_eq!(score.sized, 1, "{}", score.table);
}
