//! One file per subcommand; each reads its arguments, calls the library and prints.

mod baseline_report;
mod bench_mpc;
mod compare;
mod compare_report;
mod demonstration;
mod diagnose;
mod diagnose_evidence;
mod diagnose_report;
mod diagnose_text;
mod figures;
mod flight_report;
mod flight_text;
mod flown;
mod fly;
mod hitl;
mod identify;
mod log_arguments;
mod log_subject;
mod map;
mod progress_line;
mod synth;
mod text_table;

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::Path;

use clap::{Parser, Subcommand, ValueEnum};
use sil_host::model::{Rig, VehicleModel};

/// Quadrotor attitude control in simulation: fly the thesis' testbed, compare the simulation with measured logs.
///
/// Without a subcommand: the demonstration. It flies the test sequence under the PID cascade and under MPC, compares a
/// rig log with the simulation, names what the simulation gets wrong, and writes a report.
#[derive(Parser)]
#[command(name = "sil", version, after_help = "Example: sil fly --controller both --report out/flight.html")]
pub struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

/// Why a command stopped: exit status 2 for bad usage or bad input, 1 for a failure of its own.
pub struct Failure {
    /// Exit status.
    pub status: u8,
    /// What stands on stderr.
    pub message: String,
}

/// Makes the enum of all subcommands, and runs them.
macro_rules! commands {
    ($($name:ident($arguments:ty): $run:path,)*) => {
        #[derive(Subcommand)]
        enum Command { $($name($arguments),)* }

        /// Runs a command line.
        pub fn run(arguments: Arguments) -> Result<(), Failure> {
            match arguments.command {
                None => demonstration::run(),
                $(Some(Command::$name(arguments)) => $run(&arguments),)*
            }
        }
    };
}

commands! {
    Fly(fly::FlyArguments): fly::run,
    Hitl(hitl::HitlArguments): hitl::run,
    Compare(compare::CompareArguments): compare::run,
    Diagnose(diagnose::DiagnoseArguments): diagnose::run,
    Identify(identify::IdentifyArguments): identify::run,
    Map(map::MapArguments): map::run,
    Synth(synth::SynthArguments): synth::run,
    BenchMpc(bench_mpc::BenchArguments): bench_mpc::run,
}

/// Bad usage or bad input.
fn bad_input(error: impl Display) -> Failure {
    Failure { status: 2, message: error.to_string() }
}

/// A failure of the command's own.
fn failed(error: impl Display) -> Failure {
    Failure { status: 1, message: error.to_string() }
}

/// Prints to stdout. Who closed it (`sil fly | head`) has seen enough; the files are still written.
fn print(text: impl Display) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match write!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(failed(format!("the output: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// The rigs on the command line that a whole vehicle can hang in.
#[derive(Clone, Copy, ValueEnum)]
enum RigArgument {
    /// The thesis' testbed: roll and pitch free, yaw locked, no translation.
    Gimbal,
    /// Free flight.
    Free,
}

impl From<RigArgument> for Rig {
    fn from(rig: RigArgument) -> Rig {
        match rig {
            RigArgument::Gimbal => Rig::Gimbal,
            RigArgument::Free => Rig::Free,
        }
    }
}

/// The model of a file, or the project's own model of the rig; both given must agree.
fn vehicle_model(file: Option<&Path>, rig: Option<Rig>) -> Result<VehicleModel, Failure> {
    let Some(file) = file else {
        return Ok(VehicleModel::nominal(rig.unwrap_or(Rig::Gimbal)));
    };
    let model = VehicleModel::load(file).map_err(bad_input)?;
    match rig {
        Some(rig) if rig != model.rig() => Err(bad_input(format!(
            "{} is a model for the rig {}, but --rig says {}",
            file.display(),
            model.rig().name(),
            rig.name()
        ))),
        _ => Ok(model),
    }
}

/// Writes a file, making its folder; a failure names it.
fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    make_folder(path)?;
    std::fs::write(path, bytes).map_err(|error| failed(format!("{}: cannot be written: {error}", path.display())))
}

/// Makes the folder that a file will lie in.
fn make_folder(path: &Path) -> Result<(), Failure> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => std::fs::create_dir_all(folder)
            .map_err(|error| failed(format!("{}: cannot be made: {error}", folder.display()))),
        _ => Ok(()),
    }
}

/// Writes a value as JSON, if a file was requested.
fn write_json(path: Option<&Path>, value: &impl serde::Serialize) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let mut text = serde_json::to_string_pretty(value).map_err(failed)?;
    text.push('\n');
    write_file(path, text.as_bytes())
}
