//! What the stub runs: every part of the control core, on inputs that the compiler cannot foresee.

use core::hint::black_box;
use core::panic::PanicInfo;

use shared_control::config::{Config, Controller, Tuning, mpc_settings};
use shared_control::flight_core::{FlightCore, State};
use shared_control::lift_curve::LiftCurve;
use shared_control::mpc::{Mpc, MpcState};
use shared_control::signals::StepInput;
use shared_control::vehicle::VehicleParameters;

const STEP_RATE_HZ: f32 = 400.0;
const STEP_US: u64 = 2500;
const IMU_RATE_HZ: f32 = 1000.0;
const MOTOR_LAG_S: f32 = 0.05;
/// Control horizon; any from 1 to 30 links.
const HORIZON: usize = 5;

#[cortex_m_rt::entry]
fn run() -> ! {
    let vehicle = black_box(f450());
    let tuning = Tuning::for_motor_lag(black_box(MOTOR_LAG_S));
    let config = Config::new(&vehicle, &tuning, STEP_RATE_HZ, IMU_RATE_HZ, Controller::Mpc);
    let mpc = Mpc::<HORIZON>::prepare(&mpc_settings(&vehicle, &tuning));
    let (Ok(config), Ok(mpc)) = (config, mpc) else { halt() };

    let (mut state, mut plan_state) = (State::default(), MpcState::new());
    let mut input = StepInput::default();
    loop {
        input = black_box(input);
        let (output, plan) = FlightCore::step(&config, &mpc, &mut state, &mut plan_state, &input);
        black_box(&output);
        input.time_us += STEP_US;
        input.plan = plan;
    }
}

/// About the vehicle of models/f450-free.toml, with a straight line for its lift curve: nothing here flies.
fn f450() -> VehicleParameters {
    VehicleParameters {
        gravity_m_s2: 9.81,
        arm_m: 0.226,
        inertia_kg_m2: [0.0115, 0.0115, 0.020],
        torque_per_lift_m: 0.016,
        lift_curve: LiftCurve::straight(6.0),
        yaw_locked: false,
    }
}

#[panic_handler]
fn on_panic(_: &PanicInfo) -> ! {
    halt()
}

fn halt() -> ! {
    cortex_m::interrupt::disable();
    loop {
        cortex_m::asm::nop();
    }
}
