//! A torque about roll and pitch that stands still in the world, as wind's does, while the body spins: found by an
//! observer, so that the motors can make its opposite.
//!
//! In the body's axes such a torque turns backwards at the spin's rate r. As one complex number each (rate w, angular
//! acceleration u of the motors and d of the torque, p as in [`super::spin_gains`]), with e = w measured - w:
//!
//! ```text
//!   w' = i p w + u + d + (2 / T + i (r + p)) e        d' = -i r d + e / T^2
//! ```
//! Turned along with the world, both errors then die away as (s + 1 / T)^2 at every rate of the spin.

use super::complex::Complex;
use crate::elementary::{sin_cos, sqrt};
use crate::record::state_words::StateWords;

/// Time constant of the observer (two poles), s: much shorter than wind's gusts (docs/motor-loss.md).
const OBSERVER_S: f32 = 0.2;

/// What is remembered of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpinDisturbance {
    rate_rad_s: Complex,
    rad_s2: Complex,
}

impl SpinDisturbance {
    /// From a rate, rad/s, and an angular acceleration that nobody explained until then, rad/s^2.
    pub fn at(rate_rad_s: Complex, rad_s2: Complex) -> Self {
        Self { rate_rad_s, rad_s2 }
    }

    pub(super) fn record(&self, words: &mut StateWords) {
        let Self { rate_rad_s, rad_s2 } = self;
        words.numbers(&[rate_rad_s.re, rate_rad_s.im, rad_s2.re, rad_s2.im]);
    }

    /// A step of so many seconds at a spin and a precession, rad/s, in which the motors made this acceleration,
    /// rad/s^2. Returns the torque over the inertia, rad/s^2, bounded.
    pub fn update(
        &mut self,
        step_s: f32,
        [spin_rad_s, precession_rad_s, at_most_rad_s2]: [f32; 3],
        measured_rad_s: Complex,
        motors_rad_s2: Complex,
    ) -> Complex {
        let error = measured_rad_s.plus(self.rate_rad_s.scaled(-1.0));
        let (sine, cosine) = sin_cos(-spin_rad_s * step_s);
        let found =
            self.rad_s2.times(Complex { re: cosine, im: sine }).plus(error.scaled(step_s / OBSERVER_S / OBSERVER_S));
        let size = sqrt(found.re * found.re + found.im * found.im);
        self.rad_s2 = if size > at_most_rad_s2 { found.scaled(at_most_rad_s2 / size) } else { found };
        let gyroscopic = self.rate_rad_s.times(Complex { re: 0.0, im: precession_rad_s });
        let turned = gyroscopic.plus(motors_rad_s2).plus(self.rad_s2).scaled(step_s);
        let gain = Complex { re: 2.0 / OBSERVER_S, im: spin_rad_s + precession_rad_s };
        self.rate_rad_s = self.rate_rad_s.plus(turned).plus(error.times(gain).scaled(step_s));
        self.rad_s2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A torque that is constant in the world on a body that spins at 16 rad/s, integrated in small steps with motors
    /// that do something of their own: it is found within 3 % and 2 degrees after seven of its time constants.
    #[test]
    fn a_torque_of_the_world_is_found_while_the_body_spins() {
        let (spin_rad_s, inertia_ratio, step_s) = (16.0f32, 0.8f32, 0.0025f32);
        let (mut rate, mut time_s) = (Complex::ZERO, 0.0f32);
        let mut observer = SpinDisturbance::default();
        let (mut found, mut there) = (Complex::ZERO, Complex::ZERO);
        for _ in 0..1680 {
            let motors = Complex { re: 3.0 * (5.0 * time_s).sin(), im: -2.0 };
            for _ in 0..50 {
                let (sine, cosine) = (-spin_rad_s * time_s).sin_cos();
                there = Complex { re: 12.0 * cosine, im: 12.0 * sine };
                let gyroscopic = rate.times(Complex { re: 0.0, im: inertia_ratio * spin_rad_s });
                rate = rate.plus(gyroscopic.plus(motors).plus(there).scaled(step_s / 50.0));
                time_s += step_s / 50.0;
            }
            found = observer.update(step_s, [spin_rad_s, inertia_ratio * spin_rad_s, 100.0], rate, motors);
        }
        let apart = found.plus(there.scaled(-1.0));
        assert!((apart.re * apart.re + apart.im * apart.im).sqrt() < 0.03 * 12.0 + 12.0 * 0.035, "{found:?} {there:?}");
    }

    #[test]
    fn it_is_bounded() {
        let mut observer = SpinDisturbance::default();
        let mut found = Complex::ZERO;
        for _ in 0..1000 {
            found = observer.update(0.0025, [16.0, 13.0, 7.0], Complex { re: 30.0, im: 0.0 }, Complex::ZERO);
        }
        assert!((found.re * found.re + found.im * found.im).sqrt() < 7.001, "{found:?}");
    }
}
