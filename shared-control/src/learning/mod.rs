//! Learning the vehicle in flight: how strongly roll and pitch answer to torque, and how slow the motors are.
//!
//! ```text
//!   rate, delivered torque -> filters, a bank of lags -> sums, where the reference moves      every step
//!   sums -> best fit and all that the data allow -> model -> MPC -> rehearsal -> taken over   aside, in idle time
//! ```
//! Samples count only while the shaped reference accelerates and shortly after: then the motors' torque is what the
//! vehicle was told to do. In hover it answers to gusts and to noise, from which least squares would learn the
//! controller instead of the vehicle; so in hover nothing is learnt, and nothing forgotten. `docs/learning.md` has the
//! reasons and what was measured.

pub mod adoption;
pub mod confidence;
pub mod lag_bank;
pub mod rehearsal;

use crate::elementary::magnitude;
use crate::mpc::schedule::PitchInertia;
use crate::record::state_words::StateWords;
use crate::torque_observer::ObserverState;
use confidence::{AXES, Learnt};
use lag_bank::{AxisSums, LagBank, Motion};

/// Bandwidth of the filter that both sides pass, rad/s.
const BANDWIDTH_RAD_S: f32 = 20.0;
/// Memory of the sums, in time that counts, s.
const MEMORY_S: f32 = 2.0;
/// How long samples count after the reference has accelerated, s.
const AFTER_S: f32 = 0.25;
/// How long the filters take to forget how they began, s.
const SETTLING_S: f32 = 0.5;
/// Share of the reference's greatest acceleration that is a manoeuvre.
const MANOEUVRE_SHARE: f32 = 0.2;

/// Made once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearningConfig {
    bank: LagBank,
    /// Rotation in a step per torque of the model, 1/(kg m^2 / s), roll and pitch.
    turn_per_nm: [f32; AXES],
    /// Whole steps from command to motor, filters of the gyro included, and the part of a step beyond.
    delay_steps: usize,
    delay_part: f32,
    step_s: f32,
    manoeuvre_rad_s2: [f32; AXES],
    after_steps: u32,
    settling_steps: u32,
    kept: f32,
    /// How pitch answers to torque when rolled.
    pub pitch_inertia: PitchInertia,
}

/// What is kept from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LearningState {
    axes: [AxisSums; AXES],
    reference_rad_s: [f32; AXES],
    /// Steps that still count, an axis each.
    counting: [u32; AXES],
    /// Steps until the filters have forgotten how they began.
    settling: u32,
}

/// What the learner is told of the vehicle and its loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circumstances {
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
pub struct Shown<'a> {
    /// Delivered torques are remembered there.
    pub observer: &'a ObserverState,
    /// Rates, rad/s.
    pub rate_rad_s: [f32; 3],
    /// What a torque turns an axis by, over what it does when level, roll and pitch, as far as the torques that the
    /// observer remembers do not hold it already.
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
    pub fn new(circumstances: &Circumstances) -> Self {
        let Circumstances { inertia_kg_m2, delay_s, reference_max_rad_s2, step_s, pitch_inertia } = *circumstances;
        let steps = delay_s / step_s;
        let delay_steps = steps as usize;
        Self {
            bank: LagBank::new(step_s, BANDWIDTH_RAD_S),
            turn_per_nm: inertia_kg_m2.map(|inertia_kg_m2| step_s / inertia_kg_m2),
            delay_steps,
            delay_part: steps - delay_steps as f32,
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
    /// One step, flown by the torque that the observer remembers.
    pub fn update(&mut self, config: &LearningConfig, shown: &Shown<'_>) {
        if !shown.seen {
            self.settling = config.settling_steps;
        }
        for (axis, sums) in self.axes.iter_mut().enumerate() {
            let moved_rad_s = shown.reference_rad_s[axis] - self.reference_rad_s[axis];
            self.reference_rad_s[axis] = shown.reference_rad_s[axis];
            let counting = &mut self.counting[axis];
            let manoeuvres = magnitude(moved_rad_s) > config.manoeuvre_rad_s2[axis] * config.step_s;
            *counting = if manoeuvres { config.after_steps } else { counting.saturating_sub(1) };
            let counts = *counting > 0 && self.settling == 0;
            let [early_nm, late_nm] = shown.observer.acting_nm(axis, config.delay_steps);
            let acting_nm = config.delay_part * early_nm + (1.0 - config.delay_part) * late_nm;
            let motion = Motion {
                rate_rad_s: if shown.seen { shown.rate_rad_s[axis] } else { f32::NAN },
                known_rad_s: config.turn_per_nm[axis] * shown.known_nm[axis],
                turned_rad_s: config.turn_per_nm[axis] * shown.gain_share[axis] * acting_nm,
            };
            sums.update(&config.bank, &motion, counts.then_some(config.kept));
        }
        self.settling = self.settling.saturating_sub(1);
    }

    /// Nothing is flown: the filters begin anew, what was learnt stays.
    pub fn rest(&mut self, config: &LearningConfig) {
        (self.reference_rad_s, self.counting, self.settling) = ([0.0; AXES], [0; AXES], config.settling_steps);
    }

    /// What has been learnt; to be asked in idle time. None while nothing has.
    pub fn learnt(&self) -> Option<Learnt> {
        confidence::learnt(&self.axes)
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { axes, reference_rad_s, counting, settling } = self;
        for axis in axes {
            axis.record(words);
        }
        words.numbers(reference_rad_s);
        for counting in counting {
            words.word(*counting);
        }
        words.word(*settling);
    }
}

#[cfg(test)]
mod tests;
