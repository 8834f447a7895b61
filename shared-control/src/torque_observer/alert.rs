//! When the observer of one axis forgets what it knew: a short memory after what the model can't explain.
//!
//! In calm the observer has the gains of its bandwidth. An error of the rate that neither the gyro's noise nor a model
//! that is a little wrong explains is an alert: something has set in. From then on the observer is the line of least
//! squares through the samples since, whose gains for a memory of n steps are (growing-memory filter: Morrison,
//! *Introduction to sequential smoothing and prediction*, 1969)
//!
//! ```text
//!   l1 = 2 (2 n - 1) / (n (n + 1))        l2 = 6 / (n (n + 1))        n = 3, 4, 5, ...
//! ```
//! so that a torque that has set in is found within three samples, and the gains fall back by themselves, as 1 / n and
//! 1 / n^2, until they meet those of calm. The next alert of the axis is [`PAUSE_S`] later at the earliest: that bounds
//! what all alerts together do to the loop's margins (`docs/tuning.md`).
//!
//! **What is significant.** Over `WINDOW` steps the errors' sum s must be beyond
//!
//! ```text
//!   |s| > SIGNIFICANT sqrt(WINDOW) sigma + MODEL_SHARE WINDOW x        x <- (1 - l1) x + h/J |m - mean of m|
//! ```
//! sigma^2 is the running mean of the squared errors, each counted as at most four times that mean, so that what it is
//! to find does not hide behind itself. x stands for what the observer of calm would miss if the motors' torque m came
//! from outside and it had found its mean over its own memory; the share covers an inertia or a lift that is a fifth
//! wrong, however the motors are driven.

use super::DisturbanceAlert;
use crate::elementary::{larger, magnitude};
use crate::record::state_words::StateWords;

/// Least time from an alert of an axis to its next, s.
pub const PAUSE_S: f32 = 1.0;

/// Longest step of a loop that is ever alert, s. At 100 Hz an alert's gains leave a loop that is stable in calm with
/// half again the modelled gain no margin at all.
pub const STEP_MAX_S: f32 = 0.005;

/// Errors that are added up.
const WINDOW: f32 = 3.0;
/// Of the errors' sum, in standard deviations: once in 10^9 steps of white noise.
const SIGNIFICANT: f32 = 6.0;
/// How much of x is no disturbance.
const MODEL_SHARE: f32 = 0.4;
/// Memory with which an alert begins, steps: with two, the gyro's noise of one step is a torque.
const FIRST_MEMORY: u32 = 3;
/// Share of a new squared error in the running mean: a second of the shipped loop.
const VARIANCE_SHARE: f32 = 1.0 / 400.0;
/// Standard deviation of the errors at least, rad/s: two counts of the gyro.
const DEVIATION_MIN_RAD_S: f32 = 0.002;
const VARIANCE_MIN: f32 = DEVIATION_MIN_RAD_S * DEVIATION_MIN_RAD_S;
/// The mean square where nothing is known yet, (rad/s)^2: of 0.01 rad/s, above that of any healthy gyro.
const VARIANCE_FIRST: f32 = 1e-4;

/// Gains for an error of the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gains {
    /// Rate per error.
    pub(super) rate: f32,
    /// Acceleration per error, 1/s.
    pub(super) acceleration_1_s: f32,
}

/// The rule, the same for all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AlertRule {
    rule: DisturbanceAlert,
    calm: Gains,
    pause_steps: u32,
    step_s: f32,
}

/// What one axis remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AlertState {
    /// The last two errors of the rate, rad/s.
    errors_rad_s: [f32; 2],
    /// Their running mean square.
    variance: f32,
    /// What the motors' torque gave the rate in a step, mean over the observer's memory, rad/s.
    motor_mean_rad_s: f32,
    /// Error that the rest of it would make if the model knew nothing of it, rad/s.
    unmodelled_rad_s: f32,
    /// Steps since the last alert, up to the end of the pause.
    steps_since: u32,
}

impl Default for AlertState {
    fn default() -> Self {
        Self {
            errors_rad_s: [0.0; 2],
            variance: VARIANCE_FIRST,
            motor_mean_rad_s: 0.0,
            unmodelled_rad_s: 0.0,
            steps_since: u32::MAX,
        }
    }
}

impl Gains {
    /// Both poles at `pole`.
    pub(super) fn of_double_pole(pole: f32, step_s: f32) -> Self {
        Self { rate: 1.0 - pole * pole, acceleration_1_s: (1.0 - pole) * (1.0 - pole) / step_s }
    }

    /// Of the line of least squares through the last `steps` samples.
    fn of_memory(steps: u32, step_s: f32) -> Self {
        let n = steps as f32;
        let pairs = n * (n + 1.0);
        Self { rate: 2.0 * (2.0 * n - 1.0) / pairs, acceleration_1_s: 6.0 / (pairs * step_s) }
    }
}

impl AlertRule {
    pub(super) fn new(rule: DisturbanceAlert, calm: Gains, step_s: f32) -> Self {
        // an observer without an estimate has nothing to find, and a slow loop can't afford to be quick
        let may_be = calm.acceleration_1_s > 0.0 && step_s <= STEP_MAX_S;
        let rule = if may_be { rule } else { DisturbanceAlert::Never };
        Self { rule, calm, pause_steps: (PAUSE_S / step_s + 0.5) as u32, step_s }
    }

    /// Gains for a finite error of the rate; `motor_rad_s` is what the motors' torque gave the rate in this step.
    pub(super) fn gains(&self, state: &mut AlertState, error_rad_s: f32, motor_rad_s: f32) -> Gains {
        if self.rule == DisturbanceAlert::Never {
            return self.calm;
        }
        state.steps_since = state.steps_since.saturating_add(1);
        let may_begin = state.steps_since >= self.pause_steps;
        let is_significant = state.feel(self.calm.rate, error_rad_s, motor_rad_s);
        if may_begin && (is_significant || self.rule == DisturbanceAlert::Always) {
            state.steps_since = 0;
        }
        self.gains_after(state.steps_since)
    }

    fn gains_after(&self, steps: u32) -> Gains {
        if steps >= self.pause_steps {
            return self.calm;
        }
        let of_memory = Gains::of_memory(steps + FIRST_MEMORY, self.step_s);
        if of_memory.acceleration_1_s > self.calm.acceleration_1_s { of_memory } else { self.calm }
    }

    /// The gains are above those of calm.
    pub(super) fn is_alert(&self, state: &AlertState) -> bool {
        self.rule != DisturbanceAlert::Never && self.gains_after(state.steps_since) != self.calm
    }
}

impl AlertState {
    pub(super) fn record(&self, words: &mut StateWords) {
        let Self { errors_rad_s, variance, motor_mean_rad_s, unmodelled_rad_s, steps_since } = self;
        words.numbers(errors_rad_s);
        words.numbers(&[*variance, *motor_mean_rad_s, *unmodelled_rad_s]);
        words.word(*steps_since);
    }

    /// Takes an error up. Is it beyond what noise and model explain?
    fn feel(&mut self, rate_gain: f32, error_rad_s: f32, motor_rad_s: f32) -> bool {
        let [last, before] = self.errors_rad_s;
        let sum = error_rad_s + last + before;
        self.errors_rad_s = [error_rad_s, last];
        let moved_rad_s = motor_rad_s - self.motor_mean_rad_s;
        // both poles are at 1 - rate_gain / 2 or so
        self.motor_mean_rad_s += 0.5 * rate_gain * moved_rad_s;
        self.unmodelled_rad_s = (1.0 - rate_gain) * self.unmodelled_rad_s + magnitude(moved_rad_s);
        let beyond = magnitude(sum) - MODEL_SHARE * WINDOW * self.unmodelled_rad_s;
        let is_significant = beyond > 0.0 && beyond * beyond > SIGNIFICANT * SIGNIFICANT * WINDOW * self.variance;
        let squared = error_rad_s * error_rad_s;
        let counted = if squared < 4.0 * self.variance { squared } else { 4.0 * self.variance };
        self.variance = larger(self.variance + VARIANCE_SHARE * (counted - self.variance), VARIANCE_MIN);
        is_significant
    }
}

#[cfg(test)]
mod tests;
