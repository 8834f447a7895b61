//! A part of `cargo run --release -p campaigns --bin controller_blame`: a changed number of a controller is named and
//! measured, whatever the plant does; where nothing changed nothing is named.

use campaigns::controller_blame::{Case, Score};

/// Both controllers, with and without an effect in the plant.
#[test]
fn a_changed_gain_is_named_and_an_unchanged_one_is_not() {
    let mut score = Score::default();
    for (seed, is_changed) in [(0, true), (2, true), (10, true), (1, true), (6, false), (7, false)] {
        let case = Case::new(seed, is_changed);
        score.add(&case, &case.examine());
    }
    println!("{}", score.table);
    assert_eq!((score.named, score.silent), (4, 2), "{}", score.table);
    assert_eq!(score.sized, 4, "{}", score.table);
}
