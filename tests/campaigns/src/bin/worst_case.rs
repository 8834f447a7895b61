//! `cargo run --release -p campaigns --bin worst_case`.

use campaigns::worst_case::campaign;
use clap::{Parser, ValueEnum};

/// The most passes that the MPC's solver can take, found by following every way that they can go: the tables of
/// docs/solver.md.
#[derive(Parser)]
struct Arguments {
    #[arg(value_enum, default_value_t = Problems::Regulation)]
    problems: Problems,
    /// How far a wish may be off
    #[arg(default_value_t = 0.0)]
    doubt: f64,
    /// Numbers of inputs, instead of all
    inputs: Vec<usize>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Problems {
    /// 1 to 30 inputs
    Regulation,
    /// Over all requests, 1 to 5 inputs
    Flight,
    /// Under references that stand still, 1 to 10 inputs
    Held,
}

fn main() {
    let Arguments { problems, doubt, inputs: asked } = Arguments::parse();
    // more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let inputs = |most: usize| if asked.is_empty() { (1..=most).collect() } else { asked.clone() };
    let known = match problems {
        Problems::Regulation => campaign::regulations(&inputs(30), doubt),
        Problems::Flight => campaign::flights(&inputs(5), doubt),
        Problems::Held => campaign::held_references(&inputs(10), doubt),
    };
    println!("{}\n{}", campaign::table(&known), campaign::details(&known));
}
