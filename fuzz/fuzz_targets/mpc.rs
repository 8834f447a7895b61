//! The MPC that flies on raw bytes: settings, control horizon, then requests one after another with the same warm
//! start.
//!
//! `cargo +nightly fuzz run mpc`, in the project's root. Whatever the bytes: no panic, no hang, a torque that is a
//! number inside its bounds, and "solved" only for requests that are numbers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use shared_control::config::{Tuning, mpc_settings};
use shared_control::mpc::schedule::Schedule;
use shared_control::mpc::{HORIZON, Mpc, MpcSettings, MpcState, ReferenceAhead};
use shared_control::signals::{PlanRequest, PlanStatus};
use shared_control::vehicle::VehicleParameters;
use words::Words;

mod words;

const VEHICLE: VehicleParameters = VehicleParameters::F450_FREE;

/// What the board's vehicle and tuning say, changed where the bytes say so: a word of 0 leaves a setting as it is, so
/// that requests are reached that settings of raw bits would never be accepted for.
fn settings(words: &mut Words<'_>) -> MpcSettings {
    let tuning = Tuning {
        mpc_motor_limits: words.next() % 4 == 1,
        mpc_linearisations: 1 + words.next() as usize % 4,
        ..Tuning::for_vehicle(&VEHICLE)
    };
    let mut settings = mpc_settings(&VEHICLE, &tuning, 400.0);
    let problem = &mut settings.problem;
    problem.horizon = HORIZON - words.next() as usize % HORIZON;
    problem.output_max_rad = [0, 1, 2].map(|_| Some(words.number()).filter(|bound| *bound != 0.0));
    let numbers = [&mut problem.input_gain, &mut problem.tracking_weight, &mut problem.increment_weight];
    let numbers = numbers.into_iter().chain([&mut problem.input_max, &mut settings.torque_per_input_nm]);
    let numbers = numbers.chain([&mut settings.preview.lead_s]).flatten();
    let single = [&mut problem.prediction_step_s, &mut settings.motor_lag_s, &mut settings.preview.delay_s];
    for number in numbers.chain(single) {
        let word = words.number();
        *number = if word == 0.0 { *number } else { word };
    }
    settings.preview.ahead = match words.next() % 3 {
        0 => ReferenceAhead::Shaped,
        1 => ReferenceAhead::Held,
        _ => ReferenceAhead::Setpoint,
    };
    if words.next() % 2 == 1 {
        settings.schedule = Schedule::SINGLE;
    }
    settings
}

fn request(words: &mut Words<'_>, step: u32) -> PlanRequest {
    let mut request = PlanRequest {
        step,
        angle_rad: words.three(),
        rate_rad_s: words.three(),
        motor_nm: words.three(),
        torque_prev_nm: words.three(),
        disturbance_nm: words.three(),
        lift_per_motor_n: words.number(),
        ..PlanRequest::default()
    };
    for axis in &mut request.reference.reference {
        (axis.angle_rad, axis.rate_rad_s) = (words.number(), words.number());
    }
    (request.setpoint.roll_rad, request.setpoint.pitch_rad) = (words.number(), words.number());
    request.setpoint.yaw_rate_rad_s = words.number();
    request
}

fuzz_target!(|bytes: &[u8]| {
    let mut words = Words(bytes);
    let control_horizon = words.next() as usize % (HORIZON + 2);
    let settings = settings(&mut words);
    let Ok(mpc) = Mpc::<HORIZON>::prepare_shorter(control_horizon, &settings) else { return };
    let torque_max_nm = settings.torque_max_nm();
    let mut state = MpcState::new();
    let mut step = 0;
    while !words.0.is_empty() {
        step += 1;
        let request = request(&mut words, step);
        let plan = mpc.plan(&mut state, &request);
        assert_eq!(plan.step, step);
        for (torque_nm, most_nm) in plan.torque_nm.iter().zip(torque_max_nm) {
            // units of the axis and back: a rounding more than the bound
            assert!(torque_nm.abs() <= 1.00001 * most_nm, "{plan:?} for {request:?}");
        }
        let state = [request.angle_rad, request.rate_rad_s, request.motor_nm, request.torque_prev_nm];
        let are_numbers = state.iter().chain([&request.disturbance_nm]).flatten().all(|number| number.is_finite());
        assert!(are_numbers || plan.status == PlanStatus::NumericalError, "{plan:?} for {request:?}");
    }
});
