//! Motors that lift a part of what they are told, for good: what a suspicion has found stays with its motor when the
//! suspicion ends.
//!
//! A motor that lacks a part is told to lift so much more. If that ended with the suspicion, and what is missing passed
//! for known, the rate loop's integral would have to take over all at once, which it can't: with 40 % lost the vehicle
//! tilted by 9 degrees when nobody suspected the motor any more.

use crate::elementary::{larger, limit, smaller};
use crate::lift_curve::LiftCurve;
use crate::record::state_words::StateWords;

/// What all witnesses agree on is learnt with, s.
const LEARNT_S: f32 = 0.3;
/// And forgotten with, s: slow enough for a rate loop's integral to follow.
const FORGOTTEN_S: f32 = 10.0;
/// A motor that lacks less is as good as whole.
const WEAK_FROM_SHARE: f32 = 0.02;
/// A motor that lacks less is not spoken of.
const TOLD_FROM_SHARE: f32 = 0.1;
/// Share of a lift that is made up for by a higher command at most.
pub const RAISED_SHARE_MAX: f32 = 0.5;

/// Share of its lift that each of the four was found to lack, 0 to [`RAISED_SHARE_MAX`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WeakMotors {
    lack_share: [f32; 4],
}

impl WeakMotors {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { lack_share } = self;
        words.numbers(lack_share);
    }

    /// Share that a motor was found to lack.
    pub fn lacks_share(&self, motor: usize) -> f32 {
        self.lack_share[motor & 3]
    }

    /// Whether it was found to lift less than it should.
    pub fn is_weak(&self, motor: usize) -> bool {
        self.lacks_share(motor) > WEAK_FROM_SHARE
    }

    /// The motor (0 to 3) that lacks most, if that is worth a word, and the share that it lacks.
    pub fn weakest(&self) -> Option<(usize, f32)> {
        let shares = self.lack_share.iter().copied().enumerate();
        shares.filter(|(_, share)| *share > TOLD_FROM_SHARE).reduce(|most, one| if one.1 > most.1 { one } else { most })
    }

    /// Lift that a motor lacks which lifts so much, N.
    pub fn lacks_n(&self, motor: usize, lift_n: f32) -> f32 {
        let share = self.lacks_share(motor);
        lift_n * share / (1.0 - share)
    }

    /// What four motors lift that should lift so much, N.
    pub fn lifted_n(&self, lifts_n: &[f32; 4]) -> [f32; 4] {
        core::array::from_fn(|motor| (1.0 - self.lack_share[motor]) * lifts_n[motor])
    }

    /// One step of forgetting, and of learning that a motor lacks such a share of what it is believed to lift.
    pub fn learn(&mut self, lacks: Option<(usize, f32)>, step_s: f32) {
        for (motor, lack_share) in self.lack_share.iter_mut().enumerate() {
            match lacks {
                Some((weak, share)) if weak == motor => {
                    let believed = 1.0 - *lack_share;
                    let learnt = *lack_share + step_s / LEARNT_S * believed * share;
                    *lack_share = limit(learnt, 0.0, RAISED_SHARE_MAX);
                }
                _ => *lack_share -= step_s / FORGOTTEN_S * *lack_share,
            }
        }
    }

    /// Commands with which weak motors lift what these would make whole ones lift.
    pub fn made_up_for(&self, curve: &LiftCurve, commands: &[f32; 4]) -> [f32; 4] {
        core::array::from_fn(|motor| {
            if self.lack_share[motor] <= 0.0 {
                return commands[motor];
            }
            let lift_n = curve.lift(commands[motor]);
            curve.command(smaller(lift_n / (1.0 - self.lack_share[motor]), larger(curve.lift_max_n, lift_n)))
        })
    }
}
