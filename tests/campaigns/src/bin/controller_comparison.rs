//! MPC against the cascade: `cargo run --release -p campaigns --bin controller_comparison -- [scan | tune |
//! DRAWS]`. `scan` tunes both at several shapings, `tune` writes the controller files under tests/campaigns/comparison, otherwise
//! the tables over so many draws (200) come out.

use campaigns::comparison::campaign;

fn main() {
    // flights are many and short; more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let argument = std::env::args().nth(1);
    match argument.as_deref() {
        Some("scan") => print!("{}", campaign::scan()),
        Some("tune") => {
            let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("comparison");
            let [mpc, cascade] = campaign::tune();
            for (name, text) in [("mpc.toml", mpc), ("cascade.toml", cascade)] {
                std::fs::write(folder.join(name), &text).expect("the folder is there");
                print!("{text}");
            }
        }
        count => {
            let draws = count.map_or(campaign::DRAWS, |count| count.parse().expect("a number of draws"));
            print!("{}", campaign::report(draws));
        }
    }
}
