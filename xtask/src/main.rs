//! `cargo xtask`: what CI runs, and what a developer would otherwise type by hand.

mod bench_mcu;
mod board;
mod call_graph;
mod ci;
mod clients;
mod decoders;
mod firmware;
mod fmu;
mod image;
mod mutants;
mod page;
mod panic_freedom;
mod process;
mod px4;
mod python;
mod self_test;
mod sysroot;
mod thumb;
mod tidy;
mod toolchain;
mod workspace;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use crate::firmware::Target;
use crate::workspace::Workspace;

#[derive(Parser)]
#[command(name = "cargo xtask", about)]
struct Cli {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Build the firmware image, check it and print its size (also: cargo fw)
    Fw {
        /// With bounds on roll and pitch in the MPC, and what they cost; leaves that image
        #[arg(long)]
        bounded_angles: bool,
    },
    /// Build the image and pack it for upload over USB by QGroundControl
    Px4,
    /// Check that the control core alone compiles for the flight controller
    CoreTarget,
    /// Lint the firmware and the control core as compiled for the flight controller
    ClippyTarget,
    /// Fly the firmware image on the emulated board (needs cmake, libclang and a C compiler)
    BoardTest,
    /// Have a board make one of its self-tests by a debug probe (needs probe-rs and the board)
    SelfTest(self_test::Arguments),
    /// Count the MPC's instructions on an emulated Cortex-M4F, on the instances of the benchmark (needs what board-test
    /// needs)
    BenchMcu(bench_mcu::Arguments),
    /// Change the control core bit by bit and see whether its unit tests notice (cargo-mutants; hours for all of it)
    Mutants(mutants::Arguments),
    /// Hold the readers of logs against pyulog and pymavlink (needs python3 with venv and pip)
    Decoders,
    /// Have ground stations' own clients fly the simulated vehicle and the emulated board (needs python3 with venv and
    /// pip, cmake, libclang)
    Clients,
    /// Build the page that runs in a browser, one file (target/page/sil.html)
    Page,
    /// Test that page in a browser (needs chromium and chromium-driver)
    PageTest,
    /// Time that page in a browser: its start, a log's answer, a slider's move (a quiet machine)
    PageSpeed,
    /// Build the Python package, install it into a clean environment and test it (needs python3 with venv and pip)
    Python,
    /// Write plant, plant with IMU and control core as FMUs (FMI 3.0) for other co-simulation tools, or test them
    Fmu(fmu::Arguments),
    /// Check the rules that neither the compiler nor clippy knows
    Tidy,
    /// Run all that CI runs, two steps at a time
    Ci(ci::Arguments),
}

fn main() -> ExitCode {
    match run(&Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: &Task) -> Result<()> {
    let workspace = Workspace::find()?;
    match task {
        Task::Fw { bounded_angles: false } => Target::find(&workspace)?.build_image().map(drop),
        Task::Fw { bounded_angles: true } => Target::find(&workspace)?.build_image_with_bounded_angles(),
        Task::Px4 => px4::run(&workspace),
        Task::CoreTarget => Target::find(&workspace)?.check_core(),
        Task::ClippyTarget => Target::find(&workspace)?.clippy(),
        Task::BoardTest => board::run(&workspace),
        Task::SelfTest(arguments) => self_test::run(&workspace, arguments),
        Task::BenchMcu(arguments) => bench_mcu::run(&workspace, arguments),
        Task::Mutants(arguments) => mutants::run(&workspace, arguments),
        Task::Decoders => decoders::run(&workspace),
        Task::Clients => clients::run(&workspace),
        Task::Page => page::build(&workspace).map(drop),
        Task::PageTest => page::test(&workspace),
        Task::PageSpeed => page::speed(&workspace),
        Task::Python => python::run(&workspace),
        Task::Fmu(arguments) => fmu::run(&workspace, arguments),
        Task::Tidy => tidy::run(&workspace),
        Task::Ci(arguments) => ci::run(&workspace, arguments),
    }
}
