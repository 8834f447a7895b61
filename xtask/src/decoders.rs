//! Holding the readers of flight controllers' logs against the decoders of PX4's and ArduPilot's own people.

use std::process::Command;

use anyhow::Result;

use crate::process;
use crate::workspace::Workspace;

/// Fixed, so that a change of theirs does not fail a change of ours.
const PACKAGES: [&str; 2] = ["pyulog==1.3.0", "pymavlink==2.4.50"];

/// Installs them in an environment of their own, once, and runs the tests that use them.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let folder = workspace.target_dir.join("decoders");
    let python = folder.join("bin").join("python");
    if !python.exists() {
        process::run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
    }
    process::run(Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(PACKAGES))?;
    let mut test = workspace.cargo("test");
    test.args(["--test", "integration", "decoders_read_the_same", "--", "--ignored", "--nocapture"]);
    process::run(test.env("DECODERS_PYTHON", &python))
}
