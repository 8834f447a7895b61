//! What turns the vehicle beside its motors.

use nalgebra::Vector3;

use crate::record::state_words::StateWords;

/// Angular accelerations that no motor explains, behind a low-pass: the rate as it was predicted, pulled towards the
/// measured one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Unexplained {
    pub(super) predicted_rad_s: [f32; 3],
    pub(super) rad_s2: [f32; 3],
    /// How fast they grow, behind the same low-pass, rad/s^3.
    pub(super) rise_rad_s3: [f32; 3],
    /// Lifts behind the same low-pass, N.
    pub(super) lifts_n: [f32; 4],
}

impl Unexplained {
    pub(super) fn record(&self, words: &mut StateWords) {
        let Self { predicted_rad_s, rad_s2, rise_rad_s3, lifts_n } = self;
        words.numbers(predicted_rad_s);
        words.numbers(rad_s2);
        words.numbers(rise_rad_s3);
        words.numbers(lifts_n);
    }

    /// One step; the rates and what the motors make of them, rad/s^2, and the motors' lifts.
    pub(super) fn update(
        &mut self,
        low_pass_s: f32,
        step_s: f32,
        (rate, by_motors): (&Vector3<f32>, &[f32; 3]),
        lifts: &[f32; 4],
    ) {
        let share = step_s / low_pass_s;
        for axis in 0..3 {
            self.predicted_rad_s[axis] += step_s * (by_motors[axis] + self.rad_s2[axis]);
            let rad_s2 = (rate[axis] - self.predicted_rad_s[axis]) / low_pass_s;
            let rise_rad_s3 = (rad_s2 - self.rad_s2[axis]) / step_s;
            self.rise_rad_s3[axis] += share * (rise_rad_s3 - self.rise_rad_s3[axis]);
            self.rad_s2[axis] = rad_s2;
        }
        for (held, now) in self.lifts_n.iter_mut().zip(lifts) {
            *held += share * (now - *held);
        }
    }
}
