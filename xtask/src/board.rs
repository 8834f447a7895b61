//! Flying the very image that `cargo fw` builds on the emulated board of tests/board.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Result, bail};

use crate::firmware::Target;
use crate::process;
use crate::px4;
use crate::workspace::Workspace;

/// As `cargo test` builds the rest, so that nothing is built twice; the emulator itself without checks (Cargo.toml).
const PACKAGE: [&str; 2] = ["--package", "emulated-board"];

/// Builds the image and its bundle, then runs the emulated board's tests on them; they print what they measured.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    check_tools()?;
    px4::run(workspace)?;
    let target = Target::find(workspace)?;
    let mut command = workspace.cargo("test");
    command.arg("--no-fail-fast").args(PACKAGE).args(["--", "--nocapture"]);
    process::run(command.env("FIRMWARE_ELF", target.image()))
}

/// Lints it, as it is built for the tests: its CPU emulator takes a minute to build.
pub(crate) fn clippy(workspace: &Workspace) -> Result<()> {
    check_tools()?;
    let mut command = workspace.cargo("clippy");
    process::run(command.args(PACKAGE).args(["--all-targets", "--", "-D", "warnings"]))
}

/// The CPU emulator is C, and its bindings are made by libclang.
pub(crate) fn check_tools() -> Result<()> {
    let cmake = Command::new("cmake").arg("--version").stdout(Stdio::null()).status();
    if !cmake.is_ok_and(|status| status.success()) {
        bail!(
            "the emulated board needs cmake and libclang to build its CPU emulator\n  \
             Debian: apt-get install gcc cmake make pkg-config libclang-dev"
        );
    }
    let has_libclang = std::env::var_os("LIBCLANG_PATH").is_some()
        || ["/usr/lib/llvm-14/lib", "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib"]
            .into_iter()
            .any(|folder| holds_libclang(Path::new(folder)));
    if !has_libclang {
        eprintln!(
            "no libclang where Debian puts it: if the build fails, apt-get install libclang-dev or set LIBCLANG_PATH"
        );
    }
    Ok(())
}

fn holds_libclang(folder: &Path) -> bool {
    let entries = folder.read_dir().into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.file_name().to_string_lossy().starts_with("libclang"))
}
