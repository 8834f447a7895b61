//! The FMUs: written for whoever wants them, and tested as a tool has them, by FMPy.

use std::env::consts::{ARCH, OS};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};

use crate::process;
use crate::python::{environment, pip};
use crate::workspace::Workspace;

/// Fixed, so that a change of theirs does not fail a change of ours.
const PACKAGES: [&str; 3] = ["fmpy==0.3.32", "numpy==2.2.6", "pytest==8.4.2"];

/// Rig and level of each: what is exported where nobody names a model.
const MODELS: [&str; 6] = ["f450-gimbal", "f450-free", "generic-gimbal", "generic-free", "box-gimbal", "box-free"];

/// What to make.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder for the FMUs [default: target/fmu]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// A model file, more than once for several vehicles [default: the project's F450, both rigs on all three levels]
    #[arg(long, value_name = "FILE")]
    model: Vec<PathBuf>,
    /// Test those of the project's models with FMPy (needs python3 with venv and pip)
    #[arg(long, conflicts_with_all = ["out", "model"])]
    check: bool,
    /// Print the tables of docs/fmi.md
    #[arg(long, conflicts_with_all = ["out", "model", "check"])]
    figures: bool,
}

/// Writes them, or tests them.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Result<()> {
    if (OS, ARCH) != ("linux", "x86_64") {
        bail!("FMUs are made for 64 bit Linux on x86, and on it; this is {OS} on {ARCH}");
    }
    if arguments.check {
        return check(workspace);
    }
    if arguments.figures {
        return under_test(workspace, &["figures.py"]);
    }
    process::run(workspace.cargo("build").args(["--release", "--package", "sil-fmu"]))?;
    let out = arguments.out.clone().unwrap_or_else(|| workspace.target_dir.join("fmu"));
    let shipped = MODELS.map(|name| model(workspace, name));
    let models = if arguments.model.is_empty() { &shipped[..] } else { &arguments.model[..] };
    export(&workspace.target_dir.join("release"), &out, models)
}

/// Tests them.
pub(crate) fn check(workspace: &Workspace) -> Result<()> {
    under_test(workspace, &["-m", "pytest", "-q", "-p", "no:cacheprovider", "."])
}

fn under_test(workspace: &Workspace, python_arguments: &[&str]) -> Result<()> {
    process::run(workspace.cargo("build").args(["--package", "sil-fmu"]))?;
    process::run(workspace.cargo("build").args(["--bin", "sil"]))?;
    let (folder, built) = (workspace.target_dir.join("fmu-check"), workspace.target_dir.join("debug"));
    let fmus = folder.join("fmus");
    // of earlier models none is left that could be tested instead
    if fmus.exists() {
        std::fs::remove_dir_all(&fmus)?;
    }
    export(&built, &fmus, &MODELS.map(|name| model(workspace, name)))?;
    let python = environment(&folder.join("python"))?;
    pip(&python, &PACKAGES)?;
    let mut test = Command::new(&python);
    test.args(python_arguments).current_dir(workspace.root.join("fmu").join("tests"));
    test.env("FMUS", &fmus).env("MODELS", workspace.root.join("models")).env("SIL", built.join("sil"));
    process::run(test.env("PYTHONDONTWRITEBYTECODE", "1"))
}

fn model(workspace: &Workspace, name: &str) -> PathBuf {
    workspace.root.join("models").join(format!("{name}.toml"))
}

fn export(built: &Path, out: &Path, models: &[PathBuf]) -> Result<()> {
    let mut export = Command::new(built.join("sil-fmu-export"));
    export.arg("--library").arg(built.join("libsil_fmu.so")).arg("--out").arg(out);
    process::run(export.args(models))
}
