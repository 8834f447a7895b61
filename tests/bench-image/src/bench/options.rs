//! Every option of the MPC that an owner can choose, with requests made to be dear: each unrelated to the one before,
//! and those with the most passes changed a little, over and over.
//!
//! The board's own type and set-up: room for the longest control horizon, prepared for the one that is chosen.

use core::fmt::Write;
use core::hint::black_box;

use shared_control::config::Controller;
use shared_control::mpc::{HORIZON, Mpc, MpcSettings, MpcState};
use shared_control::params::vehicle::{FlownVehicle, VehicleNumbers};
use shared_control::params::{Params, Rig};
use shared_control::setup::Setup;
use shared_control::signals::{Plan, PlanRequest, Setpoint};

use super::{refuse, report, roi_begin, roi_end};
use crate::start::Console;

/// Requests of each option.
const REQUESTS: usize = 240;
/// Of these, one in so many is a new one; the others are the dearest so far, changed.
const NEW_ONE_IN: usize = 3;

/// Free inputs with which axes have limits of their own, and with which they share the motors'.
const SINGLE: [u8; 4] = [1, 5, 10, 30];
const COUPLED: [u8; 5] = [1, 3, 5, 7, 10];

type Random = u32;

fn next(random: &mut Random) -> f32 {
    // Marsaglia, Xorshift RNGs (Journal of Statistical Software 8, 2003)
    *random ^= *random << 13;
    *random ^= *random >> 17;
    *random ^= *random << 5;
    // the upper 24 bits fit a float
    (*random >> 8) as f32 / (1 << 23) as f32 - 1.0
}

/// What there is to choose.
fn choices() -> impl Iterator<Item = (&'static str, Params)> {
    let slow = VehicleNumbers { lag_e4_s: 2000, delay_e4_s: 300, flown: FlownVehicle::Own, ..VehicleNumbers::DEFAULT };
    let of = |rig, vehicle, loop_rate_hz, motor_limits| Params {
        controller: Controller::Mpc,
        rig,
        vehicle,
        loop_rate_hz,
        motor_limits,
        hover_throttle_permille: 540,
        linearisations: 4,
        ..Params::DEFAULT
    };
    let f450 = VehicleNumbers::F450;
    let options = [
        ("gimbal", of(Rig::Gimbal, f450, 400, false), &SINGLE[..]),
        ("free", of(Rig::Free, f450, 400, false), &SINGLE),
        ("slow", of(Rig::Free, slow, 400, false), &SINGLE),
        ("free-100-hz", of(Rig::Free, f450, 100, false), &SINGLE[3..]),
        ("gimbal-motors", of(Rig::Gimbal, f450, 400, true), &COUPLED),
        ("free-motors", of(Rig::Free, f450, 400, true), &COUPLED),
        ("slow-motors", of(Rig::Free, slow, 400, true), &COUPLED[2..3]),
        ("free-motors-100-hz", of(Rig::Free, f450, 100, true), &COUPLED[3..]),
    ];
    options.into_iter().flat_map(|(name, params, horizons)| {
        horizons.iter().map(move |&control_horizon| (name, Params { control_horizon, ..params }))
    })
}

#[inline(never)]
fn solve(mpc: &Mpc<HORIZON>, state: &mut MpcState<HORIZON>, request: &PlanRequest) -> Plan {
    mpc.plan(state, request)
}

/// A request anywhere within what flies; `share` of 1 is a new one, less changes the given one by so much.
fn changed(from: &PlanRequest, settings: &MpcSettings, share: f32, random: &mut Random) -> PlanRequest {
    let mut mix = |value: f32, most: f32| {
        let to = (1.0 - share) * value + share * most * next(random);
        to.clamp(-most, most)
    };
    let torque_max_nm = settings.torque_max_nm();
    let mut request = *from;
    request.step += 1;
    for axis in 0..3 {
        let reference = &mut request.reference.reference[axis];
        reference.angle_rad = mix(reference.angle_rad, 1.2);
        reference.rate_rad_s = mix(reference.rate_rad_s, 5.0);
        let away_rad = mix(from.angle_rad[axis] - from.reference.reference[axis].angle_rad, 1.0);
        request.angle_rad[axis] = reference.angle_rad + away_rad;
        request.rate_rad_s[axis] = mix(from.rate_rad_s[axis], 8.0);
        request.motor_nm[axis] = mix(from.motor_nm[axis], torque_max_nm[axis]);
        request.torque_prev_nm[axis] = mix(from.torque_prev_nm[axis], torque_max_nm[axis]);
        request.disturbance_nm[axis] = mix(from.disturbance_nm[axis], 0.8 * torque_max_nm[axis]);
    }
    let Setpoint { roll_rad, pitch_rad, yaw_rate_rad_s, .. } = from.setpoint;
    request.setpoint.roll_rad = mix(roll_rad, 1.2);
    request.setpoint.pitch_rad = mix(pitch_rad, 1.2);
    request.setpoint.yaw_rate_rad_s = mix(yaw_rate_rad_s, 2.0);
    if let Some(motors) = &settings.motors {
        let half_n = 0.5 * motors.lift_curve.lift_max_n;
        request.lift_per_motor_n = half_n + mix(from.lift_per_motor_n - half_n, half_n);
    }
    request
}

pub(super) fn run(console: &mut Console) -> core::fmt::Result {
    for (name, params) in choices() {
        let settings = match Setup::new(&params) {
            Ok(setup) => setup.mpc,
            Err(error) => return refuse(console, error),
        };
        let mut mpc = Mpc::unprepared();
        if let Err(error) = mpc.prepare_in_place(params.control_horizon.into(), &settings) {
            return refuse(console, error);
        }
        count(console, (name, params.control_horizon), &mpc, &settings)?;
    }
    Ok(())
}

fn count(
    console: &mut Console,
    (name, control_horizon): (&str, u8),
    mpc: &Mpc<HORIZON>,
    settings: &MpcSettings,
) -> core::fmt::Result {
    writeln!(console, "option {name} {control_horizon}")?;
    let mut state = MpcState::new();
    let (mut random, mut dearest, mut most) = (1, PlanRequest::default(), 0);
    for index in 0..REQUESTS {
        let share = if index % NEW_ONE_IN == 0 { 1.0 } else { 0.1 };
        let request = changed(&dearest, settings, share, &mut random);
        roi_begin();
        let plan = solve(mpc, &mut state, black_box(&request));
        roi_end();
        if plan.iterations >= most {
            (dearest, most) = (request, plan.iterations);
        }
        report(console, name, index, plan.status, plan.iterations, plan.torque_nm)?;
    }
    Ok(())
}
