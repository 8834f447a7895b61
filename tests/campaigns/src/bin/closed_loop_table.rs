//! `cargo run --release -p campaigns --bin closed_loop_table`.

use campaigns::closed_loop_table::{PAGE, page};
use clap::Parser;

/// Overshoot, settling and effort of both controllers under each effect: prints docs/closed-loop.md.
#[derive(Parser)]
struct Arguments {
    /// Write the page instead
    #[arg(long)]
    write: bool,
}

fn main() -> std::io::Result<()> {
    let arguments = Arguments::parse();
    // more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    if arguments.write {
        return std::fs::write(PAGE, page());
    }
    print!("{}", page());
    Ok(())
}
