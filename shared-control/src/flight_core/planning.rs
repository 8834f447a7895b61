//! The request to the planner, and the observer that gives the state in it.

use nalgebra::Vector3;

use super::output::StepOutput;
use super::state::State;
use crate::config::Config;
use crate::elementary::{magnitude, wrap_pi};
use crate::frames::{EulerAngles, euler_from_q, euler_rates, rate_body_from_euler_rates};
use crate::signals::{AttitudeEstimate, PlanRequest};
use crate::torque_observer::ObserverState;

/// Pitch beyond which Euler angles say too little for the MPC's model, rad; the cascade knows the whole sphere.
const PITCH_MAX_RAD: f32 = 1.3;
/// The same for roll: beyond, the pitch axis' motors turn it the other way round.
const ROLL_MAX_RAD: f32 = core::f32::consts::FRAC_PI_2;

/// Rates that nobody measured.
const UNSEEN: [f32; 3] = [f32::NAN; 3];

/// Euler angles and their rates (roll, pitch, heading). A heading that can't move stands still.
pub(super) struct EulerMotion {
    angle_rad: [f32; 3],
    pub(super) rate_rad_s: [f32; 3],
}

impl EulerMotion {
    pub(super) fn of(config: &Config, estimate: &AttitudeEstimate) -> Self {
        let angles = euler_from_q(&estimate.q_world_from_body);
        let [roll, pitch, heading] = euler_rates(angles, &estimate.rate_body_rad_s);
        let heading = if config.angle.yaw_locked { 0.0 } else { heading };
        Self { angle_rad: [angles.roll_rad, angles.pitch_rad, angles.yaw_rad], rate_rad_s: [roll, pitch, heading] }
    }

    /// What a torque about the body's y axis is about the pitch axis: share of the acceleration that it gives when
    /// level. The observer counts torques about the axes; plans are torques about the body, to which its findings are
    /// turned back.
    fn pitch_gain_share(&self, config: &Config) -> f32 {
        let [roll_rad, ..] = self.angle_rad;
        config.pitch_inertia.map_or(1.0, |inertia| inertia.gain_share(roll_rad))
    }

    /// A torque about the body's axes as the observer counts it.
    fn about_axes_nm(&self, config: &Config, [roll_nm, pitch_nm, heading_nm]: [f32; 3]) -> [f32; 3] {
        [roll_nm, pitch_nm * self.pitch_gain_share(config), heading_nm]
    }

    /// Gravity's moment, as far as it is known, N m.
    fn gravity_about_body_nm(&self, config: &Config) -> [f32; 3] {
        let [roll_rad, pitch_rad, _] = self.angle_rad;
        config.gravity_moment.map_or([0.0; 3], |moment| moment.about_body_nm(roll_rad, pitch_rad))
    }

    /// Rates about the body's axes a step later, by the torques that are under way. Where the vehicle is too steep for
    /// the observer that has begun anew, and the rates are the last ones.
    pub(super) fn predicted_rate_body_rad_s(&self, config: &Config, observer: &ObserverState) -> Vector3<f32> {
        let [roll_rad, pitch_rad, yaw_rad] = self.angle_rad;
        let known_nm = self.about_axes_nm(config, self.gravity_about_body_nm(config));
        let mut ahead = *observer;
        ahead.update(&config.observer, UNSEEN, [0.0; 3], known_nm);
        rate_body_from_euler_rates(EulerAngles { roll_rad, pitch_rad, yaw_rad }, ahead.rate_rad_s())
    }

    fn is_too_steep(&self) -> bool {
        let [roll_rad, pitch_rad, _] = self.angle_rad;
        magnitude(pitch_rad) > PITCH_MAX_RAD || magnitude(roll_rad) > ROLL_MAX_RAD
    }
}

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
        let measured_rad_s = if seen { motion.rate_rad_s } else { UNSEEN };
        observer.update(&config.observer, measured_rad_s, about_axes(delivered_nm(output)), known_nm);
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
