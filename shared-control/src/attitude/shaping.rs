//! Reference shaping: a set-point that jumps becomes an angle, a rate and an acceleration that the vehicle can follow.
//!
//! Per axis (AC_AttitudeControl's `input_shaping_angle`): the square-root controller requests a rate from the distance
//! still to go, the rate changes by no more than the acceleration limit allows, and the target angle integrates it.

use crate::attitude::square_root::square_root_controller;
use crate::elementary::{larger, limit, wrap_pi};
use crate::frames::EulerAngles;
use crate::record::state_words::StateWords;

/// Limits of the shaped reference of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapingConfig {
    /// How fast the target closes in on the set-point, 1/s (1 / APM's input time constant).
    pub gain_1_s: f32,
    /// Largest angular acceleration of the target, rad/s^2.
    pub acceleration_max_rad_s2: f32,
    /// Largest rate of the target, rad/s.
    pub rate_max_rad_s: f32,
}

impl ShapingConfig {
    /// No slower than another in anything.
    pub fn at_least_as_fast(&self, other: &Self) -> Self {
        Self {
            gain_1_s: larger(self.gain_1_s, other.gain_1_s),
            acceleration_max_rad_s2: larger(self.acceleration_max_rad_s2, other.acceleration_max_rad_s2),
            rate_max_rad_s: larger(self.rate_max_rad_s, other.rate_max_rad_s),
        }
    }
}

/// The shaped reference of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShapedReference {
    /// Target angle, rad.
    pub angle_rad: f32,
    /// Its rate, rad/s.
    pub rate_rad_s: f32,
}

/// What the target of an axis moves towards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// An angle, rad: roll and pitch.
    Angle(f32),
    /// A rate, rad/s: heading.
    Rate(f32),
    /// Nothing: it stays, its rate included.
    Rest,
}

/// Shaped references of roll, pitch and heading, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngleState {
    /// Roll, pitch, yaw.
    pub reference: [ShapedReference; 3],
}

impl AngleState {
    /// Reference as Euler angles.
    pub fn angles(&self) -> EulerAngles {
        let [roll, pitch, yaw] = self.reference.map(|axis| axis.angle_rad);
        EulerAngles { roll_rad: roll, pitch_rad: pitch, yaw_rad: yaw }
    }

    /// The reference that rests at these angles: where the vehicle is, control starts without a jump.
    pub fn at(angles: &EulerAngles) -> Self {
        let at = |angle_rad| ShapedReference { angle_rad, rate_rad_s: 0.0 };
        Self { reference: [angles.roll_rad, angles.pitch_rad, angles.yaw_rad].map(at) }
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { reference } = self;
        for ShapedReference { angle_rad, rate_rad_s } in reference {
            words.numbers(&[*angle_rad, *rate_rad_s]);
        }
    }
}

/// Moves the target of an axis by one step. Gives the acceleration of this move, rad/s^2.
pub fn follow(config: &ShapingConfig, state: &mut ShapedReference, goal: Goal, dt_s: f32) -> f32 {
    match goal {
        Goal::Angle(setpoint_rad) => follow_angle(config, state, setpoint_rad, dt_s),
        Goal::Rate(rate_rad_s) => follow_rate(config, state, rate_rad_s, dt_s),
        Goal::Rest => 0.0,
    }
}

/// Moves the target of an axis towards an angle. A set-point that is not finite leaves the angle where it is. Gives the
/// acceleration of this move, rad/s^2.
pub fn follow_angle(config: &ShapingConfig, state: &mut ShapedReference, setpoint_rad: f32, dt_s: f32) -> f32 {
    let error_rad = if setpoint_rad.is_finite() { wrap_pi(setpoint_rad - state.angle_rad) } else { 0.0 };
    let wanted = square_root_controller(error_rad, config.gain_1_s, config.acceleration_max_rad_s2, dt_s);
    advance(config, state, wanted, dt_s)
}

/// Moves the target of an axis at a rate (heading). A rate that is not finite counts as zero. Gives the acceleration of
/// this move, rad/s^2.
pub fn follow_rate(config: &ShapingConfig, state: &mut ShapedReference, rate_rad_s: f32, dt_s: f32) -> f32 {
    let wanted = if rate_rad_s.is_finite() { rate_rad_s } else { 0.0 };
    advance(config, state, wanted, dt_s)
}

fn advance(config: &ShapingConfig, state: &mut ShapedReference, wanted_rad_s: f32, dt_s: f32) -> f32 {
    let before_rad_s = state.rate_rad_s;
    let step = config.acceleration_max_rad_s2 * dt_s;
    let rate = limit(wanted_rad_s, before_rad_s - step, before_rad_s + step);
    state.rate_rad_s = limit(rate, -config.rate_max_rad_s, config.rate_max_rad_s);
    state.angle_rad = wrap_pi(state.angle_rad + state.rate_rad_s * dt_s);
    (state.rate_rad_s - before_rad_s) / dt_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CONFIG: ShapingConfig = ShapingConfig { gain_1_s: 6.0, acceleration_max_rad_s2: 20.0, rate_max_rad_s: 4.0 };

    proptest! {
        #[test]
        fn reaches_any_step_within_its_limits(from in -1f32..1.0, to in -1f32..1.0) {
            let mut state = ShapedReference { angle_rad: from, rate_rad_s: 0.0 };
            let mut speed = 0.0;
            for _ in 0..800 {
                let acceleration = follow_angle(&CONFIG, &mut state, to, 0.0025);
                prop_assert!(acceleration.abs() <= 20.0 * 1.001);
                prop_assert!(state.rate_rad_s.abs() <= 4.0);
                speed += acceleration * 0.0025;
                prop_assert!((speed - state.rate_rad_s).abs() < 1e-4, "the accelerations add up to the rate");
            }
            prop_assert!((state.angle_rad - to).abs() < 1e-3);
        }
    }

    #[test]
    fn takes_the_short_way_round_and_ignores_nan() {
        let mut state = ShapedReference { angle_rad: 3.0, rate_rad_s: 0.0 };
        follow_angle(&CONFIG, &mut state, -3.0, 0.0025);
        assert!(state.rate_rad_s > 0.0);
        for _ in 0..400 {
            follow_angle(&CONFIG, &mut state, f32::NAN, 0.0025);
            follow_rate(&CONFIG, &mut state, f32::INFINITY, 0.0025);
        }
        assert!(state.rate_rad_s == 0.0 && state.angle_rad.is_finite());
    }
}
