//! The moment of gravity on masses that sit off the rig's axes: known, so that the controllers need not find it.
//!
//! On the gimbal, with C the moment of an offset when level and S when turned by a right angle (the thesis suspects the
//! first of the ring, section 5.3.1):
//!
//! ```text
//!   ring:  Q_pitch = -(C cos pitch + S sin pitch)
//!   body:  Q_roll  = cos pitch (C cos roll - S sin roll)     Q_pitch = -sin pitch (C sin roll + S cos roll)
//! ```
//! A torque about the body's y axis turns pitch by its share cos roll only, so that a moment about the pitch axis
//! counts 1 / cos roll as much in the body.

use crate::elementary::{larger, sin_cos};

/// Where less than this of a torque about the body's y axis is left for pitch, no more is requested to hold the ring.
const COS_ROLL_MIN: f32 = 0.2;

/// One mass off an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OffCentre {
    /// Moment when level, N m.
    pub cos_nm: f32,
    /// Moment when turned by 90 degrees, N m; positive hangs stably.
    pub sin_nm: f32,
}

/// All that is known of gravity's moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GravityMoment {
    /// Of the body, which turns with roll and pitch.
    pub body: OffCentre,
    /// Of the ring, which turns with pitch alone.
    pub ring: OffCentre,
}

impl GravityMoment {
    /// Everything is balanced.
    pub const NONE: Self =
        Self { body: OffCentre { cos_nm: 0.0, sin_nm: 0.0 }, ring: OffCentre { cos_nm: 0.0, sin_nm: 0.0 } };

    /// The torque about the body's axes (x, y, z) that would do the same, N m.
    pub fn about_body_nm(&self, roll_rad: f32, pitch_rad: f32) -> [f32; 3] {
        let (sin_roll, cos_roll) = sin_cos(roll_rad);
        let (sin_pitch, cos_pitch) = sin_cos(pitch_rad);
        let Self { body, ring } = self;
        let roll_nm = cos_pitch * (body.cos_nm * cos_roll - body.sin_nm * sin_roll);
        let of_body_nm = -sin_pitch * (body.cos_nm * sin_roll + body.sin_nm * cos_roll);
        let of_ring_nm = -(ring.cos_nm * cos_pitch + ring.sin_nm * sin_pitch);
        [roll_nm, (of_body_nm + of_ring_nm) / larger(cos_roll, COS_ROLL_MIN), 0.0]
    }

    /// Is every part of it a finite number?
    pub fn is_finite(&self) -> bool {
        let Self { body, ring } = self;
        [body.cos_nm, body.sin_nm, ring.cos_nm, ring.sin_nm].iter().all(|moment_nm| moment_nm.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Gravity has a potential, -cos pitch (C sin roll + S cos roll) for the body and C sin pitch - S cos pitch for
        /// the ring, and the moments are its slopes.
        #[test]
        fn moments_are_the_slopes_of_a_potential(
            roll in -1.3f32..1.3, pitch in -1.3f32..1.3, c in -0.5f32..0.5, s in -0.5f32..0.5,
            ring_c in -0.5f32..0.5, ring_s in -0.5f32..0.5,
        ) {
            let moment = GravityMoment {
                body: OffCentre { cos_nm: c, sin_nm: s }, ring: OffCentre { cos_nm: ring_c, sin_nm: ring_s },
            };
            let (c, s, ring_c, ring_s) = (f64::from(c), f64::from(s), f64::from(ring_c), f64::from(ring_s));
            let potential_j = |roll: f64, pitch: f64| {
                ring_c * pitch.sin() - ring_s * pitch.cos() - pitch.cos() * (c * roll.sin() + s * roll.cos())
            };
            let (roll64, pitch64, step) = (f64::from(roll), f64::from(pitch), 1e-5);
            let q_roll = -(potential_j(roll64 + step, pitch64) - potential_j(roll64 - step, pitch64)) / (2.0 * step);
            let q_pitch = -(potential_j(roll64, pitch64 + step) - potential_j(roll64, pitch64 - step)) / (2.0 * step);
            let [of_roll, of_pitch, of_yaw] = moment.about_body_nm(roll, pitch);
            prop_assert!((f64::from(of_roll) - q_roll).abs() < 1e-5);
            prop_assert!((f64::from(of_pitch) * roll64.cos() - q_pitch).abs() < 1e-5);
            prop_assert_eq!(of_yaw, 0.0);
        }
    }

    #[test]
    fn a_body_on_its_side_asks_for_no_boundless_torque() {
        let moment = GravityMoment { ring: OffCentre { cos_nm: 0.1, sin_nm: 0.0 }, ..GravityMoment::NONE };
        let [_, of_pitch, _] = moment.about_body_nm(core::f32::consts::FRAC_PI_2, 0.0);
        assert!((of_pitch + 0.5).abs() < 1e-5, "{of_pitch}");
    }
}
