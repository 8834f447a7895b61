//! The Python package: its wheel, installed into a clean environment, the example of its page, its tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::process;
use crate::workspace::Workspace;

/// Fixed, so that a change of theirs does not fail a change of ours.
const BUILDER: &str = "maturin==1.9.6";
const PACKAGES: [&str; 7] = [
    "numpy==2.2.6",
    "pytest==8.4.2",
    "gymnasium==1.2.1",
    "optuna==5.0.0",
    "plotly==6.3.1",
    "tqdm==4.67.1",
    "ray==2.60.0",
];

/// What stands before the page's example.
const EXAMPLE: &str = "<!-- run by cargo xtask python -->\n```python\n";

/// Builds, installs and tests it.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let folder = workspace.target_dir.join("python");
    let wheels = folder.join("wheels");
    let builder = environment(&folder.join("builder"))?;
    pip(&builder, &[BUILDER])?;
    // of earlier builds none is left that could be installed instead
    if wheels.exists() {
        std::fs::remove_dir_all(&wheels)?;
    }
    let package = workspace.root.join("python");
    process::run(
        Command::new(&builder)
            // as `cargo test` has built the library
            .args(["-m", "maturin", "build", "--quiet", "--profile", "dev", "--out"])
            .arg(&wheels)
            .arg("--manifest-path")
            .arg(package.join("Cargo.toml")),
    )?;
    let python = environment(&folder.join("clean"))?;
    pip(&python, &PACKAGES)?;
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"]).arg(wheel_in(&wheels)?);
    process::run(&mut install)?;
    eprintln!("the example of python/README.md:");
    process::run(Command::new(&python).args(["-c", &example(&package)?]).current_dir(&folder))?;
    process::run(workspace.cargo("build").args(["--bin", "sil"]))?;
    let mut test = Command::new(&python);
    test.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(package.join("tests"));
    // the package that was installed is tested, not the folder of its source
    test.env("SIL", workspace.target_dir.join("debug").join("sil")).env("PYTHONDONTWRITEBYTECODE", "1");
    process::run(test.current_dir(&folder))
}

/// The interpreter of an environment, which is made where it is not there yet.
pub(crate) fn environment(folder: &Path) -> Result<PathBuf> {
    let python = folder.join("bin").join("python");
    if !python.exists() {
        process::run(Command::new("python3").args(["-m", "venv"]).arg(folder))?;
    }
    Ok(python)
}

/// Installs packages into an environment.
pub(crate) fn pip(python: &Path, packages: &[&str]) -> Result<()> {
    process::run(Command::new(python).args(["-m", "pip", "install", "--quiet"]).args(packages))
}

fn wheel_in(folder: &Path) -> Result<PathBuf> {
    let wheels = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    match &wheels[..] {
        [wheel] => Ok(wheel.path()),
        _ => bail!("{} wheels in {}, expected one", wheels.len(), folder.display()),
    }
}

fn example(package: &Path) -> Result<String> {
    let page = std::fs::read_to_string(package.join("README.md"))?;
    let (_, behind) = page.split_once(EXAMPLE).context("python/README.md has no example that is run")?;
    let (example, _) = behind.split_once("\n```").context("the example of python/README.md does not end")?;
    Ok(example.to_owned())
}
