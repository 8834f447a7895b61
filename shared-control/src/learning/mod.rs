//! Learning the vehicle in flight: how strongly roll and pitch answer to torque, and how slow the motors are.
//!
//! ```text
//!   rate, commands -> a bank of lags, filters -> sums, where the reference moves              every step
//!   sums -> best fit and all that the data allow -> model -> MPC -> rehearsal -> taken over   aside, in idle time
//! ```
//! Samples count only while the shaped reference accelerates and shortly after: then the motors' torque is what the
//! vehicle was told to do. In hover it answers to gusts and to noise alone, and what the filter leaves of their
//! relation would be all that is learnt; so in hover nothing is learnt, and nothing forgotten. `docs/learning.md` has
//! the reasons and what was measured.

pub mod adoption;
pub mod confidence;
pub mod lag_bank;
pub mod lesson;
pub mod motors;
pub mod proposal;
pub mod rehearsal;
mod words;

use crate::elementary::magnitude;
use crate::lift_curve::LiftCurve;
use crate::mpc::schedule::PitchInertia;
use crate::record::state_words::StateWords;
use confidence::AXES;
use lag_bank::{AxisSums, Motion};
use lesson::Lesson;
use motors::{MotorBank, MotorBankState};

/// Bandwidth of the filter that both sides pass, rad/s: well above what the loops answer to (5 to 10 rad/s), or gusts
/// have the gain too small (by 12 % in the median and 41 % in one of twenty at 7 rad/s, by 2 and 15 % at 30); not
/// higher, or the gyro's noise and what motors are beside a lag count for more.
const BANDWIDTH_RAD_S: f32 = 30.0;
/// Memory of the sums, in time that counts, s.
const MEMORY_S: f32 = 4.0;
/// How long samples count after the reference has accelerated, s.
const AFTER_S: f32 = 0.25;
/// How long the filters take to forget how they began, s.
const SETTLING_S: f32 = 0.5;
/// Share of the reference's greatest acceleration that is a manoeuvre.
const MANOEUVRE_SHARE: f32 = 0.2;

/// Made once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearningConfig {
    motors: MotorBank,
    pole: f32,
    /// Rotation in a step per torque of the model, 1/(kg m^2 / s), roll and pitch.
    turn_per_nm: [f32; AXES],
    step_s: f32,
    manoeuvre_rad_s2: [f32; AXES],
    after_steps: u32,
    settling_steps: u32,
    kept: f32,
    /// How pitch answers to torque when rolled: a rig's does less.
    pub pitch_inertia: PitchInertia,
}

/// What is kept from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LearningState {
    motors: MotorBankState,
    axes: [AxisSums; AXES],
    reference_rad_s: [f32; AXES],
    /// Steps that still count, an axis each.
    counting: [u32; AXES],
    /// Steps until the filters have forgotten how they began.
    settling: u32,
    /// Of all that came in, in order: what two targets compare in place of hundreds of words.
    digest: u32,
}

/// What the learner is told of the vehicle and its loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circumstances<'a> {
    /// The motors' lift over command.
    pub lift_curve: &'a LiftCurve,
    /// From a motor to the axis of roll and of pitch, m.
    pub lever_m: f32,
    /// The model's inertia, roll and pitch, kg m^2.
    pub inertia_kg_m2: [f32; AXES],
    /// From command to motor and through the gyro's filters, s.
    pub delay_s: f32,
    /// Greatest acceleration of the shaped reference, rad/s^2.
    pub reference_max_rad_s2: [f32; AXES],
    /// Control step, s.
    pub step_s: f32,
    /// How pitch answers to torque when rolled.
    pub pitch_inertia: PitchInertia,
}

/// What a step shows: roll, pitch and heading.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Commands that are in force from now on, 0..1.
    pub commands: [f32; 4],
    /// Rates, rad/s.
    pub rate_rad_s: [f32; 3],
    /// What a torque turns an axis by, over what it does when level, roll and pitch.
    pub gain_share: [f32; AXES],
    /// Torque that is known from elsewhere (gravity's), N m.
    pub known_nm: [f32; 3],
    /// Rates of the shaped reference, rad/s.
    pub reference_rad_s: [f32; 3],
    /// The rates were measured.
    pub seen: bool,
}

impl LearningConfig {
    /// For a vehicle and its loop.
    pub fn new(circumstances: &Circumstances<'_>) -> Self {
        let Circumstances { lift_curve, lever_m, inertia_kg_m2, delay_s, reference_max_rad_s2, step_s, pitch_inertia } =
            *circumstances;
        Self {
            motors: MotorBank::new(lift_curve, lever_m, delay_s, step_s),
            pole: lag_bank::pole(BANDWIDTH_RAD_S, step_s),
            turn_per_nm: inertia_kg_m2.map(|inertia_kg_m2| step_s / inertia_kg_m2),
            step_s,
            manoeuvre_rad_s2: reference_max_rad_s2.map(|most| MANOEUVRE_SHARE * most),
            after_steps: (AFTER_S / step_s) as u32,
            settling_steps: (SETTLING_S / step_s) as u32,
            kept: 1.0 - step_s / MEMORY_S,
            pitch_inertia,
        }
    }
}

impl LearningState {
    /// One step, with the commands that the motors get from now on.
    pub fn update(&mut self, config: &LearningConfig, shown: &Shown) {
        if !shown.seen {
            self.settling = config.settling_steps;
        }
        let torque_nm = self.motors.update(&config.motors, shown.commands);
        for (axis, sums) in self.axes.iter_mut().enumerate() {
            let moved_rad_s = shown.reference_rad_s[axis] - self.reference_rad_s[axis];
            self.reference_rad_s[axis] = shown.reference_rad_s[axis];
            let counting = &mut self.counting[axis];
            let manoeuvres = magnitude(moved_rad_s) > config.manoeuvre_rad_s2[axis] * config.step_s;
            *counting = if manoeuvres { config.after_steps } else { counting.saturating_sub(1) };
            let counts = *counting > 0 && self.settling == 0;
            let turn_per_nm = config.turn_per_nm[axis] * shown.gain_share[axis];
            let motion = Motion {
                rate_rad_s: if shown.seen { shown.rate_rad_s[axis] } else { f32::NAN },
                known_rad_s: turn_per_nm * shown.known_nm[axis],
                turned_rad_s: torque_nm.map(|torque_nm| turn_per_nm * torque_nm[axis]),
            };
            let (y, x) = sums.update(config.pole, &motion, counts.then_some(config.kept));
            let came_in = x.iter().chain([&y]).map(|value| value.to_bits()).chain([u32::from(counts)]);
            self.digest = came_in.fold(self.digest, digest);
        }
        self.settling = self.settling.saturating_sub(1);
    }

    /// Nothing is flown: the filters begin anew, what was learnt stays.
    pub fn rest(&mut self, config: &LearningConfig) {
        self.digest = digest(self.digest, self.settling);
        (self.reference_rad_s, self.counting, self.settling) = ([0.0; AXES], [0; AXES], config.settling_steps);
    }

    /// All that idle time needs of it, as it stands after a step.
    pub fn lesson(&self, step: u32) -> Lesson {
        Lesson { step, axes: self.axes }
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        words.word(self.digest);
    }
}

/// One more word in a digest (Knuth's multiplicative hash, The Art of Computer Programming 3, section 6.4).
fn digest(so_far: u32, word: u32) -> u32 {
    (so_far.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b1)
}

#[cfg(test)]
mod tests;
