//! Overshoot, settling and effort of both controllers under each effect: `cargo run --release -p campaigns --bin
//! closed_loop_table` prints docs/closed-loop.md, with `-- --write` it writes it.

use campaigns::closed_loop_table::{PAGE, page};

fn main() -> std::io::Result<()> {
    // more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    if std::env::args().any(|argument| argument == "--write") {
        return std::fs::write(PAGE, page());
    }
    print!("{}", page());
    Ok(())
}
