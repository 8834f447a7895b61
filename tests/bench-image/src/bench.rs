//! The sequence of solves.

#![allow(unsafe_code)] // names that an emulator finds

use core::fmt::Write;
use core::hint::black_box;

use shared_control::mpc::{MpcError, ProblemSettings, Regulation, RegulationMpc, RegulationRequest, RegulationState};
use shared_control::signals::PlanStatus;

use crate::start::Console;

/// `CASE`, `CONTROL_HORIZON`, `SETTINGS` and `INSTANCES`, written by `cargo xtask bench-mcu`.
mod data {
    use super::ProblemSettings;

    include!(env!("BENCH_DATA"));
}

/// theta = \[roll, roll rate, pitch, pitch rate, yaw, yaw rate, u_prev (3), r (3)\].
type Theta = [f32; 12];

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

#[inline(never)]
fn prepare(settings: &ProblemSettings) -> Result<RegulationMpc<{ data::CONTROL_HORIZON }>, MpcError> {
    RegulationMpc::prepare(settings)
}

/// From theta to the first inputs.
#[inline(never)]
fn solve(
    mpc: &RegulationMpc<{ data::CONTROL_HORIZON }>,
    state: &mut RegulationState<{ data::CONTROL_HORIZON }>,
    theta: &Theta,
) -> Regulation {
    let [roll, roll_rate, pitch, pitch_rate, yaw, yaw_rate, prev0, prev1, prev2, r0, r1, r2] = *theta;
    let request = RegulationRequest {
        angle_rad: [roll, pitch, yaw],
        rate_rad_s: [roll_rate, pitch_rate, yaw_rate],
        input_prev: [prev0, prev1, prev2],
        reference_rad: [r0, r1, r2],
    };
    mpc.plan(state, &request)
}

/// Solves all instances in order, each starting from what the last left.
pub(crate) fn run(console: &mut Console) -> core::fmt::Result {
    let mpc = match prepare(black_box(&data::SETTINGS)) {
        Ok(mpc) => mpc,
        Err(error) => return writeln!(console, "the settings are refused: {error}"),
    };
    let mut state = RegulationState::new();
    writeln!(console, "prepared {} bytes, state {} bytes", size_of_val(&mpc), size_of_val(&state))?;
    for (index, theta) in black_box(&data::INSTANCES).iter().enumerate() {
        roi_begin();
        let plan = solve(&mpc, &mut state, theta);
        roi_end();
        let status = match plan.status {
            PlanStatus::Solved => "solved",
            PlanStatus::IterationLimit => "iteration_limit",
            PlanStatus::Infeasible => "infeasible",
            PlanStatus::NumericalError => "numerical_error",
        };
        let [u0, u1, u2] = plan.input;
        writeln!(console, "{} {index} {status} {} {u0:e} {u1:e} {u2:e}", data::CASE, plan.iterations)?;
    }
    Ok(())
}
