//! What CI runs. Each step says its name, what it runs and how long it took; the first failure ends it.

use std::time::Instant;

use anyhow::{Context, Result};

use crate::board;
use crate::clients;
use crate::decoders;
use crate::firmware::Target;
use crate::fmu;
use crate::mutants;
use crate::page;
use crate::process;
use crate::px4;
use crate::python;
use crate::tidy;
use crate::workspace::Workspace;

type Step = (&'static str, fn(&Workspace) -> Result<()>);

/// What all steps together may take on two quiet cores, s.
const BUDGET_S: u32 = 35 * 60;
/// What parts of the campaigns may take of it, s.
const CAMPAIGNS_BUDGET_S: u32 = 6 * 60;

/// Quick ones first.
const STEPS: [Step; 17] = [
    ("format", |workspace| process::run(workspace.cargo("fmt").args(["--check", "--all"]))),
    ("tidy", tidy::run),
    ("clippy", clippy),
    ("test", |workspace| process::run(&mut workspace.cargo("test"))),
    ("the page in a browser", page::test),
    ("other people's decoders", decoders::run),
    ("other people's clients", clients::run),
    ("the Python package", python::run),
    // after the package, whose library it shares
    ("the FMUs", fmu::check),
    ("a part of the campaigns", campaigns),
    ("documentation", documentation),
    ("core for the target", |workspace| Target::find(workspace)?.build_core()),
    ("firmware image", px4::run),
    ("clippy for the target", |workspace| Target::find(workspace)?.clippy()),
    ("emulated board", board::run),
    ("clippy for the emulated board", board::clippy),
    ("mutants of the change", mutants::in_ci),
];

/// Runs all steps in order.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let mut times = Vec::new();
    for (name, step) in STEPS {
        eprintln!("\n=== {name}");
        let start = Instant::now();
        step(workspace).with_context(|| format!("step '{name}'"))?;
        let seconds = start.elapsed().as_secs_f64();
        eprintln!("=== {name}: passed in {seconds:.1} s");
        times.push((name, seconds));
    }
    eprintln!("\nall steps passed");
    for (name, seconds) in &times {
        eprintln!("{seconds:8.1} s  {name}");
    }
    let all_s: f64 = times.iter().map(|(_, seconds)| seconds).sum();
    eprintln!("{all_s:8.1} s  in all; {BUDGET_S} s on two quiet cores are the limit");
    Ok(())
}

fn clippy(workspace: &Workspace) -> Result<()> {
    process::run(workspace.cargo("clippy").args(["--all-targets", "--", "-D", "warnings"]))?;
    // an extension of Python, and a library for other tools, are built where they are wanted only
    let packages = ["--package", "sil-python", "--package", "sil-fmu"];
    process::run(workspace.cargo("clippy").args(packages).args(["--", "-D", "warnings"]))
}

/// As `cargo test` has built them: optimised, with checks. Then what takes too long for `cargo test` itself.
fn campaigns(workspace: &Workspace) -> Result<()> {
    eprintln!("{CAMPAIGNS_BUDGET_S} s on two quiet cores are the limit");
    for campaign in ["blind_diagnosis", "controller_blame"] {
        process::run(workspace.cargo("run").args(["--package", "campaigns", "--bin", campaign, "--", "tenth"]))?;
    }
    process::run(workspace.cargo("test").args(["--package", "integration-tests", "--test", "thorough"]))
}

fn documentation(workspace: &Workspace) -> Result<()> {
    process::run(workspace.cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))
}
