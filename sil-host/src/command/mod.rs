//! One file per subcommand; each reads its arguments, calls the library and prints.

mod bench_mpc;
mod compare;
mod console;
mod demonstration;
mod diagnose;
mod flight_arguments;
mod fly;
mod hitl;
mod identify;
mod log_arguments;
mod map;
mod montecarlo;
mod output;
mod progress_line;
mod refine;
mod serve;
mod serve_simulator;
mod shell;
mod synth;
mod thesis;

use std::fmt::Display;
use std::path::{Path, PathBuf};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use output::{make_folder, print, to_stdout, write_file, write_json};
use sil_host::answer::on_rig;
use sil_host::model::{Rig, VehicleModel};

/// Quadrotor attitude control in simulation: fly the thesis' testbed, compare the simulation with measured logs.
///
/// Without a subcommand: the demonstration. It flies the test sequence under the PID cascade and under MPC, compares a
/// rig log with the simulation, names what the simulation gets wrong, and writes a report.
#[derive(Parser)]
#[command(name = "sil", version, after_help = "Example: sil fly --controller both --report out/flight.html")]
pub struct Arguments {
    /// Print nothing but errors; files are written as ever
    #[arg(long, short, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Option<Command>,
}

impl Arguments {
    /// Those of the process. Values may begin with a minus sign; JSON on stdout stands there alone.
    pub fn of_process() -> Arguments {
        let takes_value = |arg: &clap::Arg| arg.get_action().takes_values() && !arg.is_positional();
        let negative = |arg: clap::Arg| if takes_value(&arg) { arg.allow_negative_numbers(true) } else { arg };
        let matches = Arguments::command().mut_subcommands(|command| command.mut_args(negative)).get_matches();
        let json = matches.subcommand().and_then(|(_, of)| of.try_get_one::<PathBuf>("json").ok().flatten());
        let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
        if arguments.quiet || json.is_some_and(|path| path == Path::new(output::STANDARD_STREAM)) {
            output::be_quiet();
        }
        arguments
    }
}

/// Why a command stopped: exit status 2 for bad usage or bad input, 1 for a failure of its own, 3 for an answer that it
/// was to fail on.
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
    Montecarlo(montecarlo::MontecarloArguments): montecarlo::run,
    Serve(serve::ServeArguments): serve::run,
    Console(console::ConsoleArguments): console::run,
    Hitl(hitl::HitlArguments): hitl::run,
    Compare(compare::CompareArguments): compare::run,
    Diagnose(diagnose::DiagnoseArguments): diagnose::run,
    Identify(identify::IdentifyArguments): identify::run,
    Map(map::MapArguments): map::run,
    Refine(refine::RefineArguments): refine::run,
    Synth(synth::SynthArguments): synth::run,
    Thesis(thesis::ThesisArguments): thesis::run,
    BenchMpc(bench_mpc::BenchArguments): bench_mpc::run,
    Completions(shell::CompletionsArguments): shell::completions,
    Man(shell::ManArguments): shell::man,
}

/// Bad usage or bad input.
fn bad_input(error: impl Display) -> Failure {
    Failure { status: 2, message: error.to_string() }
}

/// A failure of the command's own.
fn failed(error: impl Display) -> Failure {
    Failure { status: 1, message: error.to_string() }
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
    on_rig(model, &file.display().to_string(), rig).map_err(bad_input)
}
