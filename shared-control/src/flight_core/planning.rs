//! The request to the planner, and the observer that gives the state in it.

use super::euler_motion::{EulerMotion, UNSEEN_RAD_S};
use super::output::StepOutput;
use super::state::State;
use crate::config::Config;
use crate::elementary::wrap_pi;
use crate::learning::{LearningState, Shown};
use crate::signals::PlanRequest;
use crate::torque_observer::ObserverState;

/// One step of the observer; by its model alone where the motion was not `seen`. Where the vehicle is too steep or
/// upside down it begins anew.
pub(super) fn observe(
    config: &Config,
    observer: &mut ObserverState,
    motion: &EulerMotion,
    output: &StepOutput,
    seen: bool,
) {
    if motion.is_too_steep() {
        *observer = ObserverState::at(motion.rate_rad_s);
    } else {
        let about_axes = |torque_nm| motion.about_axes_nm(config, torque_nm);
        let known_nm = about_axes(motion.gravity_about_body_nm(config));
        let measured_rad_s = if seen { motion.rate_rad_s } else { UNSEEN_RAD_S };
        observer.update(&config.observer, measured_rad_s, about_axes(delivered_nm(output)), known_nm);
    }
}

/// One step of learning, by the commands that the motors get.
pub(super) fn learn(config: &Config, state: &mut State, motion: &EulerMotion, output: &StepOutput, seen: bool) {
    let Some(learning) = &config.learning else { return };
    let [roll_rad, ..] = motion.angle_rad;
    // a rig turns about its own axes, a free vehicle about those of its body
    let rate_rad_s = match config.angle.yaw_locked {
        true => motion.rate_rad_s,
        false => output.estimate.rate_body_rad_s.into(),
    };
    let shown = Shown {
        commands: output.mix.commands.0,
        rate_rad_s,
        gain_share: [1.0, learning.pitch_inertia.gain_share(roll_rad)],
        known_nm: motion.gravity_about_body_nm(config),
        reference_rad_s: state.angle.reference.map(|axis| axis.rate_rad_s),
        seen: seen && !motion.is_too_steep(),
    };
    state.learning.update(learning, &shown);
}

/// Nothing is flown from which to learn.
pub(super) fn pause_learning(config: &Config, state: &mut LearningState) {
    if let Some(learning) = &config.learning {
        state.rest(learning);
    }
}

fn delivered_nm(output: &StepOutput) -> [f32; 3] {
    core::array::from_fn(|axis| output.wrench.torque_body_nm[axis] - output.mix.unmet_torque_nm[axis])
}

/// What the planner needs to know, at the time when the plan will act. None in acro, and where the vehicle is too
/// steep or upside down.
pub(super) fn request(
    config: &Config,
    state: &State,
    motion: &EulerMotion,
    output: &StepOutput,
) -> Option<PlanRequest> {
    if motion.is_too_steep() || state.setpoint.flown.acro_rad_s.is_some() {
        return None;
    }
    let [roll_rad, pitch_rad, heading_rad] = motion.angle_rad;
    let mut reference = state.angle;
    let [_, _, heading] = &mut reference.reference;
    heading.angle_rad = if config.angle.yaw_locked { 0.0 } else { wrap_pi(heading.angle_rad - heading_rad) };
    let gravity_nm = motion.gravity_about_body_nm(config);
    let known_nm = motion.about_axes_nm(config, gravity_nm);
    let then = state.observer.at_next_plan(&config.observer, [roll_rad, pitch_rad, 0.0], motion.rate_rad_s, known_nm);
    let per_share = [1.0, 1.0 / motion.pitch_gain_share(config), 1.0];
    let about_body = |torque_nm: [f32; 3]| core::array::from_fn(|axis| torque_nm[axis] * per_share[axis]);
    let estimated_nm = about_body(state.observer.disturbance_nm());
    Some(PlanRequest {
        step: state.step,
        angle_rad: then.map(|axis| axis.angle_rad),
        rate_rad_s: then.map(|axis| axis.rate_rad_s),
        motor_nm: about_body(then.map(|axis| axis.motor_nm)),
        torque_prev_nm: delivered_nm(output),
        disturbance_nm: core::array::from_fn(|axis| estimated_nm[axis] + gravity_nm[axis]),
        lift_per_motor_n: output.wrench.lift_per_motor_n,
        reference,
        setpoint: state.setpoint.flown,
    })
}
