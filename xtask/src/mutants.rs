//! Does any unit test notice when the control core is changed? cargo-mutants changes one operator, result or match arm
//! at a time; what no test notices is missed. `.cargo/mutants.toml` has what is left out, each with its reason.
//!
//! The whole crate takes hours: `--shard k/n` does its k-th part. `--in-diff BASE` tries the lines that changed since
//! BASE; a change too large for CI is sampled there.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::process;
use crate::workspace::Workspace;

/// The version whose mutants the figures in the repository are of.
const VERSION: &str = "27.1.0";
const PACKAGE: &str = "shared-control";

/// A change of at most so many mutants CI tries whole: each takes about ten seconds on two cores.
const TRIED_IN_CI: usize = 40;
/// Of a larger one about so many: what they say is told, and fails nothing.
const SAMPLED_IN_CI: usize = 15;

/// Exit status of cargo-mutants when every mutant was caught, and when some were not: missed, or not at an end in time.
const ALL_CAUGHT: i32 = 0;
const SOME_LEFT: [i32; 2] = [2, 3];

/// Which mutants.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Only the k-th of n parts, k from 0: k/n
    #[arg(long, value_name = "K/N")]
    shard: Option<String>,
    /// Only lines that changed since this commit
    #[arg(long, value_name = "BASE")]
    in_diff: Option<String>,
    /// Only this source file
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
}

/// Tries the mutants that the arguments choose; prints what came of them, file by file. Missed ones are the answer, not
/// an error.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Result<()> {
    let tool = Tool::find_or_install(workspace)?;
    let mut selection: Vec<String> = Vec::new();
    if let Some(base) = &arguments.in_diff {
        let Some(diff) = change_since(workspace, base)? else {
            println!("no change of {PACKAGE} since {base}");
            return Ok(());
        };
        selection.extend(["--in-diff".into(), diff.display().to_string()]);
    }
    if let Some(file) = &arguments.file {
        selection.extend(["--file".into(), file.display().to_string()]);
    }
    if let Some(shard) = &arguments.shard {
        selection.extend(["--shard".into(), shard.clone()]);
    }
    tool.try_mutants(workspace, &selection)?.print();
    Ok(())
}

/// The step of CI: the mutants of the change since `MUTANTS_BASE`, or since the commit before, in a bounded time. A
/// small change must leave none missed; of a large one every so many are tried, and what is missed is only told.
pub(crate) fn in_ci(workspace: &Workspace) -> Result<()> {
    let base = std::env::var("MUTANTS_BASE").unwrap_or_else(|_| "HEAD~1".into());
    if !exists(workspace, &base)? {
        println!("skipped: this checkout has no commit {base}");
        return Ok(());
    }
    let Some(diff) = change_since(workspace, &base)? else {
        println!("skipped: no change of {PACKAGE} since {base}");
        return Ok(());
    };
    let tool = Tool::find_or_install(workspace)?;
    let in_diff = ["--in-diff".to_owned(), diff.display().to_string()];
    let count = tool.count(workspace, &in_diff)?;
    match count {
        0 => println!("skipped: nothing in the change since {base} can be mutated"),
        1..=TRIED_IN_CI => {
            let found = tool.try_mutants(workspace, &in_diff)?;
            found.print();
            ensure!(
                found.missed.is_empty(),
                "mutants that no unit test notices: test them, or leave them out in .cargo/mutants.toml with the reason"
            );
        }
        _ => {
            let parts = count.div_ceil(SAMPLED_IN_CI);
            println!(
                "{count} mutants since {base}: one of {parts} is tried; all with: cargo xtask mutants --in-diff {base}"
            );
            let sample = [&in_diff[..], &["--shard".into(), format!("0/{parts}")]].concat();
            tool.try_mutants(workspace, &sample)?.print();
        }
    }
    Ok(())
}

/// cargo-mutants: the one on the path if it is of this version, else one under the target folder.
struct Tool {
    program: PathBuf,
}

impl Tool {
    fn find_or_install(workspace: &Workspace) -> Result<Self> {
        let root = workspace.target_dir.join("tools");
        let installed = root.join("bin/cargo-mutants");
        if let Some(program) = [PathBuf::from("cargo-mutants"), installed.clone()].into_iter().find(|p| is_version(p)) {
            return Ok(Self { program });
        }
        // what it does itself takes no time beside the tests that it runs: unoptimised it is installed in half the time
        let mut install = workspace.cargo("install");
        install.args(["cargo-mutants", "--locked", "--debug", "--version", VERSION, "--root"]).arg(&root);
        process::run(&mut install)?;
        Ok(Self { program: installed })
    }

    fn command(&self, workspace: &Workspace, selection: &[String]) -> Command {
        let mut command = Command::new(&self.program);
        command.args(["mutants", "--package", PACKAGE, "--colors", "never"]);
        command.args(selection).current_dir(&workspace.root);
        command
    }

    fn count(&self, workspace: &Workspace, selection: &[String]) -> Result<usize> {
        Ok(process::output(self.command(workspace, selection).arg("--list"))?.lines().count())
    }

    /// Builds in a copy of the tree. What it depends on is kept between runs.
    fn try_mutants(&self, workspace: &Workspace, selection: &[String]) -> Result<Found> {
        let folder = workspace.target_dir.join("mutants");
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let mut command = self.command(workspace, selection);
        command.arg("--output").arg(&folder).env("CARGO_TARGET_DIR", folder.join("target"));
        let status = command.status().context("cannot start cargo-mutants")?;
        match status.code() {
            Some(code) if code == ALL_CAUGHT || SOME_LEFT.contains(&code) => Found::read(&folder.join("mutants.out")),
            _ => bail!("cargo-mutants failed ({status}): are the unit tests green?"),
        }
    }
}

fn is_version(program: &Path) -> bool {
    let output = Command::new(program).args(["mutants", "--version"]).output();
    output.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).trim() == format!("cargo-mutants {VERSION}"))
}

fn exists(workspace: &Workspace, commit: &str) -> Result<bool> {
    let mut git = Command::new("git");
    git.args(["rev-parse", "--quiet", "--verify", &format!("{commit}^{{commit}}")]).current_dir(&workspace.root);
    Ok(git.output().context("cannot start git")?.status.success())
}

/// The core's change since a commit, as a file; none if there is none.
fn change_since(workspace: &Workspace, base: &str) -> Result<Option<PathBuf>> {
    let mut git = Command::new("git");
    git.args(["diff", "--find-renames", base, "--", &format!("{PACKAGE}/src")]).current_dir(&workspace.root);
    let diff = process::output(&mut git)?;
    if diff.is_empty() {
        return Ok(None);
    }
    let path = workspace.target_dir.join("mutants.diff");
    fs::write(&path, diff).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Some(path))
}

/// What came of the mutants: their names, which begin with their file.
struct Found {
    caught: Vec<String>,
    missed: Vec<String>,
    timeout: Vec<String>,
    unviable: Vec<String>,
}

impl Found {
    fn read(folder: &Path) -> Result<Self> {
        let names = |file: &str| -> Result<Vec<String>> {
            let path = folder.join(file);
            let text = fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
            Ok(text.lines().map(str::to_owned).collect())
        };
        Ok(Self {
            caught: names("caught.txt")?,
            missed: names("missed.txt")?,
            timeout: names("timeout.txt")?,
            unviable: names("unviable.txt")?,
        })
    }

    /// Caught, missed, timed out and unviable, by file.
    fn by_file(&self) -> BTreeMap<&str, [usize; 4]> {
        let mut files = BTreeMap::new();
        for (column, names) in [&self.caught, &self.missed, &self.timeout, &self.unviable].into_iter().enumerate() {
            for name in names {
                let file = name.split(':').next().unwrap_or(name);
                files.entry(file).or_insert([0; 4])[column] += 1;
            }
        }
        files
    }

    /// A mutant on which the tests never end is noticed too.
    fn missed_percent(&self) -> f64 {
        let noticed = self.caught.len() + self.timeout.len();
        100.0 * self.missed.len() as f64 / (noticed + self.missed.len()).max(1) as f64
    }

    fn print(&self) {
        println!("caught missed timeout unviable  file");
        for (file, [caught, missed, timeout, unviable]) in self.by_file() {
            println!("{caught:6} {missed:6} {timeout:7} {unviable:8}  {file}");
        }
        println!("{:.1} % missed", self.missed_percent());
        self.missed.iter().for_each(|name| println!("missed: {name}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn mutants_are_counted_by_file_and_those_that_do_not_compile_count_for_nothing() {
        let found = Found {
            caught: names(&["a.rs:1:2: replace + with -", "a.rs:3:4: replace f -> u8 with 1", "b.rs:1:1: x"]),
            missed: names(&["b.rs:2:2: replace > with >="]),
            timeout: names(&["a.rs:9:9: replace < with >"]),
            unviable: names(&["b.rs:5:5: y", "b.rs:6:6: z"]),
        };
        assert_eq!(found.by_file().into_iter().collect::<Vec<_>>(), [("a.rs", [2, 0, 1, 0]), ("b.rs", [1, 1, 0, 2])]);
        assert_eq!(found.missed_percent(), 20.0);
    }

    #[test]
    fn nothing_tried_is_nothing_missed() {
        let found = Found { caught: vec![], missed: vec![], timeout: vec![], unviable: vec![] };
        assert_eq!(found.missed_percent(), 0.0);
    }
}
