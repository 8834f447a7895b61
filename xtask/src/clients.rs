//! Holding the link against the programs that people connect with: released clients fly a vehicle of `sil serve`, and
//! the firmware's own image on the emulated board.

use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use anyhow::Result;

use crate::board;
use crate::firmware::Target;
use crate::process;
use crate::workspace::Workspace;

/// Fixed, so that a change of theirs does not fail a change of ours. With what they need of others, and no more:
/// MAVProxy's own list has what its windows and maps take.
const PACKAGES: [&str; 11] = [
    "pymavlink==2.4.50",
    "MAVProxy==1.8.75",
    "mavsdk==3.17.4",
    "pyserial==3.5",
    "fastcrc==0.5.0",
    "lxml==6.1.3",
    "grpcio==1.85.1",
    "protobuf==7.36.2",
    "typing_extensions==4.16.0",
    "pyulog==1.3.0",
    "numpy==2.4.6",
];

/// What the clients do, a file each under `tests/clients`; the last is no ground station but a simulator that `sil`
/// connects to.
const SCRIPTS: [&str; 8] =
    ["connect.py", "metadata.py", "lossy.py", "signing.py", "console.py", "companion.py", "logs.py", "lock_step.py"];
/// What they do with the board, over TELEM1 and over USB; the last, from a flight to a better one, by `sil`, too.
const BOARD_SCRIPTS: [&str; 3] = ["board.py", "board_usb.py", "better.py"];

/// Installs them in an environment of their own, once, and lets each meet the simulated vehicle, and then the board.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let folder = workspace.target_dir.join("clients");
    let python = folder.join("bin").join("python");
    if !python.exists() {
        process::run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
    }
    let install = ["-m", "pip", "install", "--quiet", "--no-deps"];
    process::run(Command::new(&python).args(install).args(PACKAGES))?;
    process::run(workspace.cargo("build").args(["--bin", "sil"]))?;
    let sil = workspace.target_dir.join("debug").join("sil");
    let meet = |script: &str, vehicle: &[PathBuf]| -> Result<()> {
        let start = Instant::now();
        let path = workspace.root.join("tests").join("clients").join(script);
        process::run(Command::new(&python).arg(path).args(vehicle))?;
        eprintln!("{script}: {:.1} s", start.elapsed().as_secs_f64());
        Ok(())
    };
    for script in SCRIPTS {
        meet(script, std::slice::from_ref(&sil))?;
    }
    board::check_tools()?;
    let image = Target::find(workspace)?.build_image()?;
    process::run(workspace.cargo("build").args(["--package", "emulated-board", "--example", "serve_image"]))?;
    let server = workspace.target_dir.join("debug").join("examples").join("serve_image");
    let board = [server, image, sil];
    BOARD_SCRIPTS.into_iter().try_for_each(|script| meet(script, &board))
}
