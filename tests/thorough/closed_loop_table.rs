//! `docs/closed-loop.md` is what the code gives.

use campaigns::closed_loop_table::{PAGE, page};

#[test]
fn the_page_has_every_figure_as_it_is() {
    let committed = std::fs::read_to_string(PAGE).unwrap();
    let page = page();
    for (line, is) in page.lines().zip(committed.lines()) {
        assert_eq!(
            line, is,
            "docs/closed-loop.md is behind: cargo run --release -p campaigns --bin closed_loop_table -- --write"
        );
    }
    assert_eq!(page.lines().count(), committed.lines().count(), "docs/closed-loop.md has other rows");
}
