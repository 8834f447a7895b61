//! What rotors that are not balanced do to an IMU: lines at each rotor's own speed and its harmonics.
//!
//! An imbalance u (kg m) turns with its rotor: a force `u w²` in the rotor's plane, which shakes the frame by `u w²/m`.
//! At the end of its arm the same force is a torque `l u w²`, which turns the frame to and fro: the integral of `l u
//! w²/I cos(w t)` is a rate of `l u w/I`. So acceleration grows with the square of the speed and rate with the speed,
//! and a harmonic n of a torque is n times weaker in the rate. Two blades push along the vertical at twice the speed.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Amplitude of the harmonics in the rotor's plane, of the first: rotors are no pure imbalance.
const HARMONICS: [f64; 3] = [1.0, 0.3, 0.1];
/// Bearing of the arms of motors 1 to 4 from forward to right, rad.
const ARMS_RAD: [f64; 4] = [FRAC_PI_4, -3.0 * FRAC_PI_4, -FRAC_PI_4, 3.0 * FRAC_PI_4];

/// How strongly the rotors shake the IMU, each of them alike.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Vibration {
    /// Acceleration of a rotor's first line over its speed squared, m.
    pub(crate) acceleration_per_speed2_m: f64,
    /// Rate of a rotor's first line over its speed.
    pub(crate) rate_per_speed: f64,
}

/// The rotors at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turning {
    /// Speed of rotors 1 to 4, rad/s.
    pub(crate) speed_rad_s: [f64; 4],
    /// Angle of each, rad.
    pub(crate) phase_rad: [f64; 4],
}

impl Vibration {
    /// Rate (rad/s) and acceleration (m/s²), body axes, of an IMU whose gyro and accelerometer pass such a share of a
    /// line of so many rad/s.
    pub(crate) fn felt(
        &self,
        rotors: &Turning,
        gyro_passes: impl Fn(f64) -> f64,
        accel_passes: impl Fn(f64) -> f64,
    ) -> ([f64; 3], [f64; 3]) {
        let (mut rate_rad_s, mut acceleration_m_s2) = ([0.0; 3], [0.0; 3]);
        for ((speed_rad_s, phase_rad), arm_rad) in rotors.speed_rad_s.into_iter().zip(rotors.phase_rad).zip(ARMS_RAD) {
            let strength_m_s2 = self.acceleration_per_speed2_m * speed_rad_s * speed_rad_s;
            let strength_rad_s = self.rate_per_speed * speed_rad_s;
            for (order, share) in [1.0, 2.0, 3.0].into_iter().zip(HARMONICS) {
                let line_rad_s = order * speed_rad_s;
                let (sin, cos) = libm::sincos(order * phase_rad);
                let push = strength_m_s2 * share * accel_passes(line_rad_s);
                acceleration_m_s2[0] += push * cos;
                acceleration_m_s2[1] += push * sin;
                let turn = strength_rad_s * share / order * gyro_passes(line_rad_s);
                rate_rad_s[0] += turn * cos;
                rate_rad_s[1] += turn * sin;
                // of the force what lies across the arm
                rate_rad_s[2] += turn * libm::sin(order * phase_rad - arm_rad);
            }
            let blades_rad_s = 2.0 * speed_rad_s;
            acceleration_m_s2[2] += strength_m_s2 * accel_passes(blades_rad_s) * libm::cos(2.0 * phase_rad);
        }
        (rate_rad_s, acceleration_m_s2)
    }
}

/// Where the rotors stand when the clock begins: apart from one another, as they do when somebody looks.
pub(crate) const FIRST_PHASES_RAD: [f64; 4] = [0.0, 1.3, 2.9, 4.4];

/// The phases after a stretch of time over which speeds changed steadily, rad.
pub(crate) fn turned_on(
    phase_rad: [f64; 4],
    before_rad_s: [f64; 4],
    after_rad_s: [f64; 4],
    duration_s: f64,
) -> [f64; 4] {
    core::array::from_fn(|rotor| {
        let mean_rad_s = 0.5 * (before_rad_s[rotor] + after_rad_s[rotor]);
        (phase_rad[rotor] + mean_rad_s * duration_s) % (4.0 * FRAC_PI_2)
    })
}
