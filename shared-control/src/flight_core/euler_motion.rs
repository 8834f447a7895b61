//! Motion in Euler angles, in which the observer and the MPC's model count; torques about the body turned to their
//! axes.

use nalgebra::Vector3;

use crate::config::Config;
use crate::elementary::magnitude;
use crate::frames::{EulerAngles, euler_from_q, euler_rates, rate_body_from_euler_rates};
use crate::signals::AttitudeEstimate;
use crate::torque_observer::ObserverState;

/// Pitch beyond which Euler angles say too little for the MPC's model, rad; the cascade knows the whole sphere.
const PITCH_MAX_RAD: f32 = 1.3;
/// The same for roll: beyond, the pitch axis' motors turn it the other way round.
const ROLL_MAX_RAD: f32 = core::f32::consts::FRAC_PI_2;

/// Rates that nobody measured.
pub(super) const UNSEEN_RAD_S: [f32; 3] = [f32::NAN; 3];

/// Euler angles and their rates (roll, pitch, heading). A heading that can't move stands still.
pub(super) struct EulerMotion {
    pub(super) angle_rad: [f32; 3],
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
    pub(super) fn pitch_gain_share(&self, config: &Config) -> f32 {
        let [roll_rad, ..] = self.angle_rad;
        config.pitch_inertia.map_or(1.0, |inertia| inertia.gain_share(roll_rad))
    }

    /// A torque about the body's axes as the observer counts it.
    pub(super) fn about_axes_nm(&self, config: &Config, [roll_nm, pitch_nm, heading_nm]: [f32; 3]) -> [f32; 3] {
        [roll_nm, pitch_nm * self.pitch_gain_share(config), heading_nm]
    }

    /// Gravity's moment, as far as it is known, N m.
    pub(super) fn gravity_about_body_nm(&self, config: &Config) -> [f32; 3] {
        let [roll_rad, pitch_rad, _] = self.angle_rad;
        config.gravity_moment.map_or([0.0; 3], |moment| moment.about_body_nm(roll_rad, pitch_rad))
    }

    /// Rates about the body's axes a step later, by the torques that are under way. Where the vehicle is too steep for
    /// the observer that has begun anew, and the rates are the last ones.
    pub(super) fn predicted_rate_body_rad_s(&self, config: &Config, observer: &ObserverState) -> Vector3<f32> {
        let [roll_rad, pitch_rad, yaw_rad] = self.angle_rad;
        let known_nm = self.about_axes_nm(config, self.gravity_about_body_nm(config));
        let mut ahead = *observer;
        ahead.update(&config.observer, UNSEEN_RAD_S, [0.0; 3], known_nm);
        rate_body_from_euler_rates(EulerAngles { roll_rad, pitch_rad, yaw_rad }, ahead.rate_rad_s())
    }

    pub(super) fn is_too_steep(&self) -> bool {
        let [roll_rad, pitch_rad, _] = self.angle_rad;
        magnitude(pitch_rad) > PITCH_MAX_RAD || magnitude(roll_rad) > ROLL_MAX_RAD
    }
}
