//! How fast a vehicle spins that has lost a motor, by what its motors do: what a gyro can't say beyond its limit.
//!
//! The sides' reaction torque turns it, the air brakes it by nobody knows how much, so that is found on the way up:
//!
//! ```text
//!   r' = a - b r + 2 (2 pi f) e        b' = -(2 pi f)^2 e / r        e = r measured - r
//! ```
//! with a the motors' angular acceleration about yaw. Where the gyro is at its limit it is given this rate for its own
//! ([`crate::sensing::imu::condition`]); then e is none, and r goes on by what was found.

use crate::elementary::{limit, magnitude};
use crate::record::state_words::StateWords;

/// 2 pi f: slower than gusts about yaw and than rotors that speed up, quicker than the spin, which takes seconds, 1/s.
const OBSERVER_1_S: f32 = 2.0;
/// From this rate on the brake is looked for, rad/s.
const BRAKES_FROM_RAD_S: f32 = 8.0;
/// Range of the brake, 1/s: of the F450 by Mueller and D'Andrea's drag 0.5.
const BRAKE_1_S: [f32; 2] = [0.02, 4.0];

/// What is remembered of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpinRate {
    rad_s: f32,
    brake_1_s: f32,
}

impl SpinRate {
    /// From a rate about yaw, rad/s.
    pub fn at(rad_s: f32) -> Self {
        Self { rad_s, brake_1_s: 0.0 }
    }

    pub(super) fn record(&self, words: &mut StateWords) {
        let Self { rad_s, brake_1_s } = self;
        words.numbers(&[*rad_s, *brake_1_s]);
    }

    /// About yaw, rad/s.
    pub fn rad_s(&self) -> f32 {
        self.rad_s
    }

    /// A step of so many seconds, in which the motors made this acceleration about yaw, rad/s^2.
    pub fn update(&mut self, step_s: f32, measured_rad_s: f32, motors_rad_s2: f32) {
        let error_rad_s = measured_rad_s - self.rad_s;
        let turned_rad_s2 = motors_rad_s2 - self.brake_1_s * self.rad_s + 2.0 * OBSERVER_1_S * error_rad_s;
        if magnitude(self.rad_s) > BRAKES_FROM_RAD_S {
            let [least, most] = BRAKE_1_S;
            let found_1_s = self.brake_1_s - step_s * OBSERVER_1_S * OBSERVER_1_S * error_rad_s / self.rad_s;
            self.brake_1_s = limit(found_1_s, least, most);
        }
        let rad_s = self.rad_s + step_s * turned_rad_s2;
        self.rad_s = if rad_s.is_finite() { rad_s } else { measured_rad_s };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f32 = 0.0025;
    const LIMIT_RAD_S: f32 = 34.9;

    /// A spin that reaches 42 rad/s, of which the gyro shows 34.9 at most, either way round and with motors that lift a
    /// third less for a while: known beyond it to 0.3 rad/s, though nobody has told its brake. Where the motors make a
    /// fifth more than is believed, the brake that is found on the way leads to 43.8 rad/s in the end, and what a third
    /// of the lift turns it less is believed less, too.
    #[test]
    fn a_spin_beyond_the_limit_is_followed() {
        for (way, motors_share, allowed_rad_s) in [(1.0f32, 1.0f32, 0.3), (-1.0, 1.0, 0.3), (1.0, 1.2, 3.0)] {
            let (mut rad_s, mut spin) = (0.0f32, SpinRate::at(0.0));
            for step in 0..16_000 {
                let lifts = if (8000..9000).contains(&step) { 0.67 } else { 1.0 };
                let motors_rad_s2 = way * 8.0 * lifts;
                rad_s += STEP_S * (motors_rad_s2 * motors_share - 8.0 * motors_share / 42.0 * rad_s);
                let shown_rad_s = limit(rad_s, -LIMIT_RAD_S, LIMIT_RAD_S);
                let is_limited = magnitude(rad_s) > LIMIT_RAD_S;
                let by_model_rad_s = if magnitude(spin.rad_s) > LIMIT_RAD_S { spin.rad_s } else { shown_rad_s };
                spin.update(STEP_S, if is_limited { by_model_rad_s } else { shown_rad_s }, motors_rad_s2);
                if is_limited {
                    assert!(
                        (spin.rad_s - rad_s).abs() < allowed_rad_s,
                        "{step}, {motors_share}: {} {rad_s}",
                        spin.rad_s
                    );
                }
            }
            assert!(magnitude(rad_s) > 41.0);
        }
    }

    #[test]
    fn what_is_no_number_is_not_kept() {
        let mut spin = SpinRate::at(f32::NAN);
        spin.update(STEP_S, 5.0, 1.0);
        assert_eq!(spin.rad_s(), 5.0);
    }
}
