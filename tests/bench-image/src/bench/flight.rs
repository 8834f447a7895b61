//! The problem that flies: the vehicle of the board's image with its tuning at 400 Hz, motors' lag, disturbance and the
//! shaped reference ahead. Angles, rates, present inputs and set-points are those of the instance file, 10 ms apart.

use core::fmt::Write;
use core::hint::black_box;

use shared_control::attitude::angle;
use shared_control::config::{Controller, Tuning, mpc_settings};
use shared_control::mpc::{Mpc, MpcError, MpcSettings, MpcState};
use shared_control::signals::{Plan, PlanRequest};
use shared_control::vehicle::VehicleParameters;

use super::{Theta, data, refuse, report, roi_begin, roi_end};
use crate::start::Console;

const VEHICLE: VehicleParameters = VehicleParameters::F450_GIMBAL;
const LOOP_RATE_HZ: f32 = 400.0;
/// Steps of the loop between two instances.
const STEPS: usize = 4;
/// Share of the greatest torque that a constant disturbance takes.
const DISTURBANCE_SHARE: f32 = 0.1;

#[inline(never)]
fn prepare(settings: &MpcSettings) -> Result<Mpc<{ data::CONTROL_HORIZON }>, MpcError> {
    Mpc::prepare(settings)
}

/// From a request to the first torques, the preview of the reference included.
#[inline(never)]
fn solve(
    mpc: &Mpc<{ data::CONTROL_HORIZON }>,
    state: &mut MpcState<{ data::CONTROL_HORIZON }>,
    request: &PlanRequest,
) -> Plan {
    mpc.plan(state, request)
}

/// The next request. The motors are where they were asked to be an instance before; headings count from their
/// reference.
fn advance(request: &mut PlanRequest, settings: &MpcSettings, theta: &Theta) {
    let [roll, roll_rate, pitch, pitch_rate, yaw, yaw_rate, prev0, prev1, prev2, r0, r1, r2] = *theta;
    let torque_max_nm = settings.torque_max_nm();
    let share = [prev0, prev1, prev2].into_iter().zip(data::SETTINGS.input_max).map(|(input, most)| input / most);
    request.step += 1;
    request.angle_rad = [roll, pitch, yaw - r2];
    request.rate_rad_s = [roll_rate, pitch_rate, yaw_rate];
    request.motor_nm = request.torque_prev_nm;
    for ((torque_nm, share), most_nm) in request.torque_prev_nm.iter_mut().zip(share).zip(torque_max_nm) {
        *torque_nm = share * most_nm;
    }
    request.disturbance_nm = torque_max_nm.map(|most_nm| DISTURBANCE_SHARE * most_nm);
    (request.setpoint.roll_rad, request.setpoint.pitch_rad) = (r0, r1);
    for _ in 0..STEPS {
        angle::shape(&settings.preview.shaping, &mut request.reference, &request.setpoint, 1.0 / LOOP_RATE_HZ);
    }
}

pub(super) fn run(console: &mut Console) -> core::fmt::Result {
    let [roll_max_rad, ..] = data::SETTINGS.output_max_rad;
    let tuning = Tuning { mpc_tilt_max_rad: roll_max_rad, ..Tuning::for_flight(&VEHICLE, Controller::Mpc, false) };
    let settings = mpc_settings(&VEHICLE, &tuning, LOOP_RATE_HZ);
    let mpc = match prepare(black_box(&settings)) {
        Ok(mpc) => mpc,
        Err(error) => return refuse(console, error),
    };
    let mut state = MpcState::new();
    writeln!(console, "prepared {} bytes, state {} bytes", size_of_val(&mpc), size_of_val(&state))?;
    let mut request = PlanRequest { lift_per_motor_n: 1.0, ..PlanRequest::default() };
    for (index, theta) in black_box(&data::INSTANCES).iter().enumerate() {
        advance(&mut request, &settings, theta);
        roi_begin();
        let plan = solve(&mpc, &mut state, black_box(&request));
        roi_end();
        report(console, data::CASE, index, plan.status, plan.iterations, plan.torque_nm)?;
    }
    Ok(())
}
