//! Axes in which every lost motor looks the same: the sides' torque is real, the far motor's is positive imaginary, and
//! the vehicle spins forwards.

use super::allocation::{opposite, side_of};
use super::complex::Complex;
use crate::airframe::TORQUE_SIGNS;

/// Body axes turned by a multiple of a right angle and half of one, and mirrored where the sides spin it backwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpinFrame {
    turn: Complex,
    mirrored: bool,
}

impl SpinFrame {
    /// Without this motor (0 to 3).
    pub fn without(lost: usize) -> Self {
        let far = torque_of(opposite(lost));
        let side = side_of(lost);
        let mirrored = TORQUE_SIGNS[2][side] < 0.0;
        let plain = Self { turn: torque_of(side).conjugate().scaled(core::f32::consts::FRAC_1_SQRT_2), mirrored };
        // of the two sides the one from which a quarter turn forwards leads to the far motor
        if plain.seen(far).im > 0.0 { plain } else { Self { turn: plain.turn.scaled(-1.0), mirrored } }
    }

    /// Roll and pitch in these axes.
    pub fn seen(&self, roll_pitch: Complex) -> Complex {
        let turned = roll_pitch.times(self.turn);
        if self.mirrored { turned.conjugate() } else { turned }
    }

    /// And back.
    pub fn roll_pitch(&self, seen: Complex) -> Complex {
        let turned = if self.mirrored { seen.conjugate() } else { seen };
        turned.times(self.turn.conjugate())
    }

    /// Yaw rate in these axes, rad/s.
    pub fn spin_rad_s(&self, yaw_rad_s: f32) -> f32 {
        if self.mirrored { -yaw_rad_s } else { yaw_rad_s }
    }
}

/// Roll and pitch torque of a lift, over lever and lift.
fn torque_of(motor: usize) -> Complex {
    Complex { re: TORQUE_SIGNS[0][motor & 3], im: TORQUE_SIGNS[1][motor & 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lost_motor_looks_the_same() {
        for lost in 0..4 {
            let frame = SpinFrame::without(lost);
            let far = frame.seen(torque_of(opposite(lost)));
            assert!(far.re.abs() < 1e-6 && (far.im - 2f32.sqrt()).abs() < 1e-6, "{far:?}");
            for side in (0..4).filter(|motor| *motor != lost && *motor != opposite(lost)) {
                assert!(frame.seen(torque_of(side)).im.abs() < 1e-6);
                assert_eq!(frame.spin_rad_s(TORQUE_SIGNS[2][side]), 1.0);
            }
            let there = Complex { re: 0.3, im: -2.0 };
            let back = frame.roll_pitch(frame.seen(there));
            assert!((back.re - there.re).abs() < 1e-6 && (back.im - there.im).abs() < 1e-6);
        }
    }

    /// What is constant in the world turns backwards in the body, and so it does here.
    #[test]
    fn turning_keeps_its_sense() {
        for lost in 0..4 {
            let frame = SpinFrame::without(lost);
            let yaw_rad_s = 0.5;
            let turned = |angle_rad: f32| frame.seen(Complex { re: angle_rad.cos(), im: -angle_rad.sin() });
            let (before, after) = (turned(0.0), turned(yaw_rad_s));
            let ratio = after.times(before.conjugate());
            let spin_rad_s = frame.spin_rad_s(yaw_rad_s);
            assert!((ratio.re - spin_rad_s.cos()).abs() < 1e-6 && (ratio.im + spin_rad_s.sin()).abs() < 1e-6);
        }
    }
}
