//! From a vehicle model and a choice of controller to a configured control side.
//!
//! The controllers get parameters only: the lift curve is the model's equilibrium curve turned around into a table, the
//! inertia is the model's. No plant code runs in the core. Of a model's effects the controllers know what they have a
//! parameter for: lag, delay, inertia, lift of the motors, gravity's moment on the rig; so a model that a diagnosis has
//! extended makes a better controller.

use shared_control::config::{self, Config, Controller, Tuning};
use shared_control::gravity_moment::{GravityMoment, OffCentre};
use shared_control::lift_curve::{LIFT_INTERVALS, LiftCurve};
use shared_control::mpc::MpcSettings;
use shared_control::vehicle::{Actuation, VehicleParameters};

use crate::axis::Axis;
use crate::effects::{CgOffset, Effect};
use crate::model::{Mounting, Rig, VehicleModel};
use crate::plant::Plant;
use crate::vehicle::Changes;

/// What the controllers know of a vehicle model, its effects included.
pub fn vehicle_parameters(model: &VehicleModel) -> VehicleParameters {
    let Changes { chain, body, .. } = model.changes();
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    let ring_kg_m2 = match model.mounting {
        Mounting::Gimbal { ring_inertia_kg_m2 } => ring_inertia_kg_m2,
        Mounting::Free { .. } => 0.0,
    };
    // pitch turns the ring along
    let inertia_kg_m2 = [ixx, iyy + ring_kg_m2, izz];
    let mut curve = lift_curve(model);
    let lift_scale = (chain.lift.scale.iter().sum::<f64>() / 4.0) as f32;
    curve.lift_min_n *= lift_scale;
    curve.lift_max_n *= lift_scale;
    VehicleParameters {
        gravity_m_s2: model.gravity_m_s2 as f32,
        arm_m: model.arm_m as f32,
        inertia_kg_m2: core::array::from_fn(|axis| (body.inertia_scale[axis] * inertia_kg_m2[axis]) as f32),
        ring_inertia_kg_m2: (body.inertia_scale[1] * ring_kg_m2) as f32,
        torque_per_lift_m: model.propulsion.reaction_torque_per_lift_m() as f32,
        lift_curve: curve,
        actuation: Actuation {
            delay_s: chain.path.delay_s as f32,
            lag_s: (motor_lag_s(model) + chain.path.lag_s) as f32,
        },
        gravity_moment: gravity_moment(model),
        yaw_locked: model.rig() == Rig::Gimbal,
    }
}

/// What the model's masses off the axes do on the gimbal. In free flight gravity has no moment.
fn gravity_moment(model: &VehicleModel) -> GravityMoment {
    let mut moment = GravityMoment::NONE;
    if model.rig() == Rig::Free {
        return moment;
    }
    for effect in &model.effects {
        let Effect::CgOffset(CgOffset { axis, cos_moment_nm, sin_moment_nm }) = effect else { continue };
        let of: &mut OffCentre = if *axis == Axis::Roll { &mut moment.body } else { &mut moment.ring };
        of.cos_nm += *cos_moment_nm as f32;
        of.sin_nm += *sin_moment_nm as f32;
    }
    moment
}

/// The model's equilibrium lift over command, turned around.
pub fn lift_curve(model: &VehicleModel) -> LiftCurve {
    let lift_n = |command: f64| model.propulsion.equilibrium(command).lift_n;
    let (low_n, high_n) = (lift_n(0.0), lift_n(1.0));
    let command_at = |k: usize| match k {
        0 => 0.0,
        LIFT_INTERVALS => 1.0,
        _ => command_for_lift(model, low_n + (high_n - low_n) * k as f64 / LIFT_INTERVALS as f64) as f32,
    };
    LiftCurve { lift_min_n: low_n as f32, lift_max_n: high_n as f32, command_at: core::array::from_fn(command_at) }
}

/// The command at which a motor of the model settles at a lift, by bisection; the nearer end for a lift out of range.
pub fn command_for_lift(model: &VehicleModel, lift_n: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // 40 halvings: far below the spacing of f32
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if model.propulsion.equilibrium(middle).lift_n < lift_n { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Time constant of a motor's lift at the model's base command, s, without effects: the area above the response to a
/// small step of the command, as an engineer would read it off a test stand.
fn motor_lag_s(model: &VehicleModel) -> f64 {
    const STEP: f64 = 0.01;
    const SAMPLE_S: f64 = 2e-4;
    const SAMPLES: usize = 2500;
    let mut plant = Plant::new(&VehicleModel { effects: Vec::new(), arms: None, ..model.clone() });
    let start_n = plant.lifts_n()[0];
    let end_n = model.propulsion.equilibrium(model.base_command + STEP).lift_n;
    plant.set_commands([model.base_command + STEP; 4]);
    let mut area_s = 0.0;
    for _ in 0..SAMPLES {
        // the middle of each sample
        plant.advance(0.5 * SAMPLE_S);
        area_s += (end_n - plant.lifts_n()[0]) / (end_n - start_n) * SAMPLE_S;
        plant.advance(0.5 * SAMPLE_S);
    }
    area_s
}

/// A core configured for a model.
///
/// # Errors
/// A value that can't be flown with, by name.
pub fn core_config(
    model: &VehicleModel,
    tuning: &Tuning,
    control_rate_hz: u32,
    imu_rate_hz: u32,
    controller: Controller,
) -> Result<Config, config::ConfigError> {
    let vehicle = vehicle_parameters(model);
    let mut config = Config::new(&vehicle, tuning, control_rate_hz as f32, imu_rate_hz as f32, controller)?;
    config.sensing.estimator.levelling.rotor_drag_1_s = model.known_rotor_drag_1_s as f32;
    Ok(config)
}

/// The MPC's problem for a model.
pub fn mpc_settings(model: &VehicleModel, tuning: &Tuning, control_rate_hz: u32) -> MpcSettings {
    config::mpc_settings(&vehicle_parameters(model), tuning, control_rate_hz as f32)
}
