//! The thesis' problem: double integrators, constant reference.

use core::hint::black_box;

use core::fmt::Write;

use shared_control::mpc::{MpcError, ProblemSettings, Regulation, RegulationMpc, RegulationRequest, RegulationState};

use super::{Theta, data, refuse, report, roi_begin, roi_end};
use crate::start::Console;

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

pub(super) fn run(console: &mut Console) -> core::fmt::Result {
    let mpc = match prepare(black_box(&data::SETTINGS)) {
        Ok(mpc) => mpc,
        Err(error) => return refuse(console, error),
    };
    let mut state = RegulationState::new();
    writeln!(console, "prepared {} bytes, state {} bytes", size_of_val(&mpc), size_of_val(&state))?;
    for (index, theta) in black_box(&data::INSTANCES).iter().enumerate() {
        roi_begin();
        let plan = solve(&mpc, &mut state, theta);
        roi_end();
        report(console, data::CASE, index, plan.status, plan.iterations, plan.input)?;
    }
    Ok(())
}
