//! The sequence of solves: of the problem that flies, of the thesis' regulation problem, or of every option that can be
//! chosen.

#![allow(unsafe_code)] // names that an emulator finds

use core::fmt::{Display, Write};
use core::hint::black_box;

use shared_control::signals::PlanStatus;

use crate::start::Console;

mod flight;
mod options;
mod regulation;

/// `CASE`, `PROBLEM`, `CONTROL_HORIZON`, `SETTINGS` and `INSTANCES`, written by `cargo xtask bench-mcu`.
mod data {
    use super::{Problem, Theta};
    use shared_control::mpc::ProblemSettings;

    include!(env!("BENCH_DATA"));
}

/// theta = \[roll, roll rate, pitch, pitch rate, yaw, yaw rate, u_prev (3), r (3)\].
type Theta = [f32; 12];

/// What the image solves; the other problem's code is left out of it.
#[allow(dead_code)] // one of them, in each image
#[derive(Clone, Copy)]
enum Problem {
    Flight,
    Regulation,
    Options,
}

/// Marks the start of what is counted.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn roi_begin() {
    // not the same as the other, or the linker makes one of both
    black_box(1);
}

/// Marks its end.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn roi_end() {
    black_box(2);
}

/// Solves all instances in order, each starting from what the last left.
pub(crate) fn run(console: &mut Console) -> core::fmt::Result {
    match data::PROBLEM {
        Problem::Flight => flight::run(console),
        Problem::Regulation => regulation::run(console),
        Problem::Options => options::run(console),
    }
}

fn refuse(console: &mut Console, error: impl Display) -> core::fmt::Result {
    writeln!(console, "the settings are refused: {error}")
}

/// One line per solve: how it ended, and the three inputs or torques.
fn report(
    console: &mut Console,
    case: &str,
    index: usize,
    status: PlanStatus,
    iterations: u16,
    [u0, u1, u2]: [f32; 3],
) -> core::fmt::Result {
    let status = match status {
        PlanStatus::Solved => "solved",
        PlanStatus::IterationLimit => "iteration_limit",
        PlanStatus::Infeasible => "infeasible",
        PlanStatus::NumericalError => "numerical_error",
        PlanStatus::Curtailed => "curtailed",
    };
    writeln!(console, "{case} {index} {status} {iterations} {u0:e} {u1:e} {u2:e}")
}
