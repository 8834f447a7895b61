//! The most passes that the MPC's solver can take, found by following every way that they can go:
//! `cargo run --release -p campaigns --bin worst_case -- regulation | flight | held [DOUBT [M...]]`. DOUBT is how far a
//! wish may be off (0); M are the numbers of inputs (regulation: 1 to 30; flight, over all requests: 1 to 5; held, under references that
//! stand still: 1 to 10).

use campaigns::worst_case::campaign;

fn main() {
    // more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let doubt = arguments.get(1).map_or(0.0, |doubt| doubt.parse().expect("a doubt"));
    let asked = arguments.iter().skip(2).map(|inputs| inputs.parse().expect("a number of inputs"));
    let asked: Vec<usize> = asked.collect();
    let inputs = |most: usize| if asked.is_empty() { (1..=most).collect() } else { asked.clone() };
    let known = match arguments.first().map(String::as_str) {
        Some("flight") => campaign::flights(&inputs(5), doubt),
        Some("held") => campaign::held_references(&inputs(10), doubt),
        _ => campaign::regulations(&inputs(30), doubt),
    };
    println!("{}\n{}", campaign::table(&known), campaign::details(&known));
}
