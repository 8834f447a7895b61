//! Several linearisations of the pitch axis along |roll|, and which of them plans: switching MPC, thesis section 7.3.2
//! after Alexis, Nikolakopoulos and Tzes (*Switching model predictive attitude control for a quadrotor helicopter
//! subject to atmospheric disturbances*, Control Engineering Practice 19, 2011).
//!
//! In Euler angles only the pitch axis' model depends on where the vehicle is. With the torque tau_y about the body's
//! y:
//!
//! - in free flight `theta'' = tau_y cos phi / I_yy`, because pitch turns about the horizontal axis;
//! - on the gimbal `theta'' = tau_y cos phi / J(phi)`, `J = I_ring + I_yy cos^2 phi + I_zz sin^2 phi`, as the ring
//!   turns along.
//!
//! Roll has the same input gain everywhere. What else changes with attitude is no input gain: `-tau_z sin phi` vanishes
//! where yaw is locked, since no yaw torque is requested, and gravity's moment is for the disturbance estimate.
//!
//! Input and disturbance are torques, whatever the linearisation; so a switch changes neither, and the torque does not
//! jump.

use crate::elementary::{larger, magnitude, sin_cos, sqrt};

/// Most linearisations that there is room for.
pub const LINEARISATIONS_MAX: usize = 4;

/// How far beyond a limit roll must be for a switch, rad: ten times the noise of the attitude.
const HYSTERESIS_RAD: f32 = 0.02;

/// Where less than this share of the input gain is left (beyond 75 degrees), pitch is out of reach and no model helps.
const GAIN_SHARE_MIN: f32 = 0.2;

/// How the pitch axis answers to torque, over roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchInertia {
    /// Inertia of the pitch axis when level, kg m^2.
    pub level_kg_m2: f32,
    /// Inertia when rolled by 90 degrees, kg m^2; the same in free flight.
    pub rolled_kg_m2: f32,
}

impl PitchInertia {
    /// Acceleration per torque at a roll angle, as a share of the one when level; a fifth at least.
    pub fn gain_share(&self, roll_rad: f32) -> f32 {
        let (sin_roll, cos_roll) = sin_cos(roll_rad);
        let inertia = self.level_kg_m2 + (self.rolled_kg_m2 - self.level_kg_m2) * sin_roll * sin_roll;
        larger(cos_roll * self.level_kg_m2 / inertia, GAIN_SHARE_MIN)
    }
}

/// One linearisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Linearisation {
    /// Its input gain, as a share of the one when level.
    pub gain_share: f32,
    /// |roll| up to which it serves, rad.
    pub roll_max_rad: f32,
}

/// The linearisations in order of |roll|, the first at level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    linearisations: [Linearisation; LINEARISATIONS_MAX],
    count: usize,
}

impl Schedule {
    /// The level one alone.
    pub const SINGLE: Self = Self {
        linearisations: [Linearisation { gain_share: 1.0, roll_max_rad: f32::INFINITY }; LINEARISATIONS_MAX],
        count: 1,
    };

    /// `count` linearisations, 1 to [`LINEARISATIONS_MAX`], from level to `roll_end_rad` (below pi/2). Their angles go
    /// with the square root of their number, and so do the limits between them: the gain falls with the square of roll,
    /// so that it falls by about the same from each to the next.
    pub fn new(inertia: &PitchInertia, roll_end_rad: f32, count: usize) -> Self {
        let mut schedule = Self { count: count.clamp(1, LINEARISATIONS_MAX), ..Self::SINGLE };
        let steps = (schedule.count - 1) as f32;
        for (place, linearisation) in schedule.linearisations.iter_mut().take(schedule.count).enumerate().skip(1) {
            linearisation.gain_share = inertia.gain_share(roll_end_rad * sqrt(place as f32 / steps));
        }
        for (place, linearisation) in schedule.linearisations.iter_mut().take(schedule.count - 1).enumerate() {
            linearisation.roll_max_rad = roll_end_rad * sqrt((place as f32 + 0.5) / steps);
        }
        schedule
    }

    /// The linearisations.
    pub fn linearisations(&self) -> &[Linearisation] {
        self.linearisations.get(..self.count).unwrap_or_default()
    }

    /// The number, from 0, of the one for a roll angle, `present` being the one in use; stays with it for what is no
    /// number.
    pub fn choose(&self, present: usize, roll_rad: f32) -> usize {
        let roll_rad = magnitude(roll_rad);
        let is_beyond = |(place, linearisation): (usize, &Linearisation)| {
            let side = if place < present { -HYSTERESIS_RAD } else { HYSTERESIS_RAD };
            roll_rad > linearisation.roll_max_rad + side
        };
        if roll_rad.is_nan() {
            return present.min(self.count - 1);
        }
        self.linearisations().iter().enumerate().take_while(|each| is_beyond(*each)).count()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    /// The gimbal of the thesis: the ring turns along.
    const GIMBAL: PitchInertia = PitchInertia { level_kg_m2: 0.0365651, rolled_kg_m2: 0.0250533 + 0.02 };

    #[test]
    fn the_gain_is_the_plants() {
        assert_eq!(GIMBAL.gain_share(0.0), 1.0);
        // theta'' = tau_y cos phi / J(phi) at 60 degrees, J = 0.0250533 + 0.0115118/4 + 0.02 * 3/4, over 1 / 0.0365651
        let by_hand = 0.5 / (0.0250533 + 0.0115118 * 0.25 + 0.02 * 0.75) * 0.0365651;
        assert!((GIMBAL.gain_share(-core::f32::consts::FRAC_PI_3) - by_hand).abs() < 1e-6);
    }

    #[test]
    fn every_angle_has_a_linearisation_near_it() {
        for count in 2..=LINEARISATIONS_MAX {
            let schedule = Schedule::new(&GIMBAL, 1.2, count);
            assert_eq!(schedule.linearisations().len(), count);
            let span = 1.0 - GIMBAL.gain_share(1.2);
            for step in 0..=120 {
                let roll_rad = 0.01 * step as f32;
                let chosen = schedule.linearisations()[schedule.choose(0, roll_rad)];
                let error = (chosen.gain_share - GIMBAL.gain_share(roll_rad)).abs();
                // half of an equal part, half as much again for the hysteresis and for parts that aren't quite equal
                assert!(error <= 0.8 * span / (count - 1) as f32, "{count} at {roll_rad}: {error}");
            }
        }
    }

    #[test]
    fn one_linearisation_is_the_level_one_everywhere() {
        assert_eq!(Schedule::new(&GIMBAL, 1.2, 1), Schedule::SINGLE);
        assert_eq!(Schedule::SINGLE.choose(0, 1.5), 0);
    }

    proptest! {
        /// Noise smaller than the hysteresis switches once at most; either side of level is the same.
        #[test]
        fn noise_does_not_make_it_chatter(
            roll in -1.2f32..1.2,
            noise in prop::collection::vec(-0.0195f32..0.0195, 40)
        ) {
            let schedule = Schedule::new(&GIMBAL, 1.2, 4);
            let mut present = schedule.choose(0, roll);
            let (mut switches, start) = (0, present);
            prop_assert_eq!(start, schedule.choose(0, -roll));
            for noise in noise {
                let next = schedule.choose(present, roll + noise);
                switches += usize::from(next != present);
                present = next;
            }
            prop_assert!(switches <= 1, "{} switches from {}", switches, start);
        }

        /// Any number is survived, and the choice exists.
        #[test]
        fn any_roll_has_an_answer(present in 0usize..9, roll in prop::num::f32::ANY) {
            let schedule = Schedule::new(&GIMBAL, 1.2, 3);
            let chosen = schedule.choose(present, roll);
            prop_assert!(chosen < 3);
            if roll.is_nan() {
                prop_assert_eq!(chosen, present.min(2));
            }
        }
    }
}
