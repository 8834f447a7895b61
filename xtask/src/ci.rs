//! What CI runs: steps, two side by side, because most of them leave a processor idle half of the time (the compiler on
//! one large crate, an emulator, a browser, a download).
//!
//! Each step is a process of its own (`cargo xtask ci --step NAME`), whose output is kept and shown whole when it ends.
//! After the first failure none begins.

use std::env;
use std::fs::{self, File};
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, bail};

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

struct Step {
    name: &'static str,
    run: fn(&Workspace) -> Result<()>,
}

/// What all steps together may take on two quiet cores, s.
const BUDGET_S: u32 = 35 * 60;
/// What parts of the campaigns, with the thorough tests, may take of it, s.
const CAMPAIGNS_BUDGET_S: u32 = 6 * 60;
/// Tests that are ignored for another reason: one writes the fuzz targets' first inputs, one needs what step 'other
/// people's decoders' installs, one takes a minute.
const NOT_THOROUGH: [&str; 3] = ["fuzz_seeds", "decoders_read_the_same", "none_of_a_thousand"];
/// Steps at a time.
const LANES: usize = 2;

/// In the order in which they begin: quick ones, then by turns what builds for the host and what does not, because
/// cargo lets one build at a time into a folder. What takes long is not last.
const STEPS: [Step; 18] = [
    step("format", |workspace| process::run(workspace.cargo("fmt").args(["--check", "--all"]))),
    step("tidy", tidy::run),
    step("clippy", clippy),
    step("firmware image", px4::run),
    step("test", |workspace| process::run(&mut workspace.cargo("test"))),
    step("the page", |workspace| page::build(workspace).map(drop)),
    step("emulated board", board::run),
    step("clippy for the target", |workspace| Target::find(workspace)?.clippy()),
    step("the page in a browser", page::test),
    step("thorough tests", thorough),
    step("a part of the campaigns", campaigns),
    step("other people's clients", clients::run),
    step("the Python package", python::run),
    step("the FMUs", fmu::check),
    step("other people's decoders", decoders::run),
    step("documentation", documentation),
    step("clippy for the emulated board", board::clippy),
    step("mutants of the change", mutants::in_ci),
];

const fn step(name: &'static str, run: fn(&Workspace) -> Result<()>) -> Step {
    Step { name, run }
}

/// Which steps.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Only this one, here, as it goes
    #[arg(long, value_name = "NAME")]
    step: Option<String>,
}

/// Runs one step, or all.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Result<()> {
    let Some(name) = &arguments.step else { return Run::new(workspace)?.all() };
    let Some(step) = STEPS.iter().find(|step| step.name == name) else {
        let names: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        bail!("no step '{name}'; there are: {}", names.join(", "));
    };
    (step.run)(workspace)
}

/// One run of all steps.
struct Run {
    /// This program.
    program: PathBuf,
    /// Where the steps' output is kept.
    folder: PathBuf,
    waiting: Mutex<std::slice::Iter<'static, Step>>,
    ended: Mutex<Vec<Ended>>,
}

struct Ended {
    step: &'static Step,
    seconds: f64,
    passed: bool,
}

impl Run {
    fn new(workspace: &Workspace) -> Result<Self> {
        let folder = workspace.target_dir.join("ci");
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let waiting = Mutex::new(STEPS.iter());
        Ok(Self { program: env::current_exe()?, folder, waiting, ended: Mutex::new(Vec::new()) })
    }

    fn all(&self) -> Result<()> {
        let start = Instant::now();
        thread::scope(|scope| {
            let lanes: Vec<_> = (0..LANES).map(|_| scope.spawn(|| self.lane())).collect();
            lanes.into_iter().try_for_each(|lane| lane.join().unwrap_or_else(|_| bail!("a lane panicked")))
        })?;
        let ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        let failed: Vec<&str> = ended.iter().filter(|of| !of.passed).map(|of| of.step.name).collect();
        if !failed.is_empty() {
            bail!("failed: {}; what it said stands above and in {}", failed.join(", "), self.folder.display());
        }
        eprintln!("\nall steps passed");
        for Ended { step, seconds, .. } in ended.iter() {
            eprintln!("{seconds:8.1} s  {}", step.name);
        }
        let all_s = start.elapsed().as_secs_f64();
        eprintln!("{all_s:8.1} s  in all, {LANES} steps at a time; {BUDGET_S} s on two quiet cores are the limit");
        Ok(())
    }

    /// Runs what waits, step by step, until nothing does or something has failed.
    fn lane(&self) -> Result<()> {
        while let Some(step) = self.next() {
            let ended = self.run(step)?;
            self.ended.lock().unwrap_or_else(PoisonError::into_inner).push(ended);
        }
        Ok(())
    }

    fn next(&self) -> Option<&'static Step> {
        let has_failed = self.ended.lock().unwrap_or_else(PoisonError::into_inner).iter().any(|of| !of.passed);
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        if has_failed { None } else { waiting.next() }
    }

    fn run(&self, step: &'static Step) -> Result<Ended> {
        let name = step.name;
        let path = self.folder.join(format!("{}.log", name.replace([' ', '\''], "-")));
        let log = File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
        eprintln!("    {name} begins");
        let start = Instant::now();
        let mut command = Command::new(&self.program);
        command.args(["ci", "--step", name]).stdout(log.try_clone()?).stderr(log);
        let passed = command.status().with_context(|| format!("cannot start step '{name}'"))?.success();
        let seconds = start.elapsed().as_secs_f64();
        let said = fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let said = String::from_utf8_lossy(&said);
        let outcome = if passed { "passed" } else { "FAILED" };
        // in one piece, so that the other lane's lines do not come between
        eprint!("\n=== {name}\n{said}=== {name}: {outcome} in {seconds:.1} s\n");
        Ok(Ended { step, seconds, passed })
    }
}

fn clippy(workspace: &Workspace) -> Result<()> {
    // what `cargo test` leaves out is not among all targets
    let targets = ["--all-targets", "--test", "thorough"];
    process::run(workspace.cargo("clippy").args(targets).args(["--", "-D", "warnings"]))?;
    // an extension of Python, and a library for other tools, are built where they are wanted only
    let packages = ["--package", "sil-python", "--package", "sil-fmu"];
    process::run(workspace.cargo("clippy").args(packages).args(["--", "-D", "warnings"]))
}

/// As `cargo test` has built them: optimised, with checks.
fn campaigns(workspace: &Workspace) -> Result<()> {
    eprintln!("with the thorough tests, {CAMPAIGNS_BUDGET_S} s on two quiet cores are the limit");
    for campaign in ["blind_diagnosis", "controller_blame"] {
        process::run(workspace.cargo("run").args(["--bin", campaign, "--", "tenth"]))?;
    }
    Ok(())
}

/// What takes too long for `cargo test` itself: a program of its own, and tests that stand among the quick ones and are
/// ignored there.
fn thorough(workspace: &Workspace) -> Result<()> {
    process::run(workspace.cargo("test").args(["--test", "thorough"]))?;
    let mut ignored = workspace.cargo("test");
    let packages = ["sil-host", "sil-page", "campaigns", "integration-tests"];
    ignored.args(packages.iter().flat_map(|name| ["--package", *name])).arg("--lib");
    let programs = ["commands", "effects", "requests", "integration"];
    ignored.args(programs.iter().flat_map(|name| ["--test", *name])).args(["--", "--ignored"]);
    process::run(ignored.args(NOT_THOROUGH.iter().flat_map(|name| ["--skip", *name])))
}

fn documentation(workspace: &Workspace) -> Result<()> {
    process::run(workspace.cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_has_a_name_and_a_log_of_its_own() {
        let names: std::collections::BTreeSet<&str> = STEPS.iter().map(|step| step.name).collect();
        assert_eq!(names.len(), STEPS.len());
    }
}
