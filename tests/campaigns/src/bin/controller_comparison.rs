//! MPC against the cascade: `cargo run --release -p campaigns --bin controller_comparison -- [scan | tune | DRAWS]
//! [--json FILE]`. `scan` tunes both at several shapings, `tune` writes the controller files under
//! tests/campaigns/comparison, otherwise the tables over so many draws (200) come out, and their figures as JSON.

use std::process::ExitCode;

use campaigns::comparison::campaign;

fn main() -> ExitCode {
    // flights are many and short; more threads than this are somebody else's
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (count, file) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["scan"] => {
            print!("{}", campaign::scan());
            return ExitCode::SUCCESS;
        }
        ["tune"] => return tune(),
        [] => (Ok(campaign::DRAWS), None),
        ["--json", file] => (Ok(campaign::DRAWS), Some(file.to_owned())),
        [count] => (count.parse(), None),
        [count, "--json", file] => (count.parse(), Some(file.to_owned())),
        _ => (Ok(0), None),
    };
    let Ok(count @ 1..) = count else {
        eprintln!("usage: controller_comparison [scan | tune | DRAWS] [--json FILE]");
        return ExitCode::from(2);
    };
    let results = campaign::results(count);
    print!("{}", campaign::report(&results));
    if let Some(file) = file
        && let Err(error) = std::fs::write(&file, serde_json::to_string(&results).expect("plain numbers"))
    {
        eprintln!("{file}: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

fn tune() -> ExitCode {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("comparison");
    let [mpc, cascade, indi] = campaign::tune();
    for (name, text) in [("mpc.toml", mpc), ("cascade.toml", cascade), ("indi.toml", indi)] {
        std::fs::write(folder.join(name), &text).expect("the folder is there");
        print!("{text}");
    }
    ExitCode::SUCCESS
}
