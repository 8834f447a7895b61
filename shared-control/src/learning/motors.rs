//! What the motors would turn the body by, for a bank of lags at once.
//!
//! A motor's speed follows its command, and its lift goes with the speed's square; so the lag is one of the command,
//! not of the lift. Small changes do not tell the two apart. Large ones do: a motor that is told to double its lift has
//! made more than half of the difference when its speed has made half of its own, and a model that lags the lift takes
//! that for a stronger motor.
//!
//! A motor's current is late by itself, before any speed changes: beside a lag of tens of milliseconds that is a delay.
//! Where it counts as a part of the lag, gain and lag are both read too high, by 10 % each where the filter lets quick
//! motion through.

use super::confidence::AXES;
use super::lag_bank::{LAGS, LAGS_S};
use crate::airframe::TORQUE_SIGNS;
use crate::lagged_axis::LagStep;
use crate::lift_curve::LiftCurve;

/// Commands that are kept: with a delay of n steps and a bit, those of n + 2 steps ago are the oldest.
const COMMANDS_KEPT: usize = 18;
/// Of each lag what is the current's, s: 1.6968e-4 H over 0.127 ohm, the F450's motor (thesis, table C.2).
const CURRENT_S: f32 = 0.0013;
/// Most whole steps of delay.
pub const DELAY_STEPS_MAX: usize = COMMANDS_KEPT - 3;

/// A bank of motors, made once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorBank {
    steps: [LagStep; LAGS],
    /// Lift of a command u: `linear_n` u + `square_n` u^2, and a constant that turns nothing.
    linear_n: f32,
    square_n: f32,
    lever_m: f32,
    /// Whole steps of delay, and the part of a step beyond.
    delay_steps: usize,
    delay_part: f32,
}

/// What is remembered of the commands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorBankState {
    /// The latest first.
    commands: [[f32; 4]; COMMANDS_KEPT],
    /// Where each lag has brought each motor.
    lagged: [[f32; 4]; LAGS],
}

impl MotorBank {
    /// Motors with a curve, seen behind a delay; one beyond [`DELAY_STEPS_MAX`] steps counts as that.
    pub fn new(lift_curve: &LiftCurve, lever_m: f32, delay_s: f32, step_s: f32) -> Self {
        let steps = crate::elementary::limit((delay_s + CURRENT_S) / step_s, 0.0, DELAY_STEPS_MAX as f32);
        let delay_steps = steps as usize;
        // the parabola through the curve at an eighth, a half and seven eighths of its lift
        let [low, middle, high] = [4, 16, 28].map(|k: usize| lift_curve.command_at[k]);
        let step_n = 0.375 * (lift_curve.lift_max_n - lift_curve.lift_min_n);
        let [lower, upper] = [step_n / (middle - low), step_n / (high - middle)];
        let square_n = (upper - lower) / (high - low);
        Self {
            steps: LAGS_S.map(|lag_s| LagStep::new(step_s, lag_s - CURRENT_S)),
            linear_n: lower - square_n * (low + middle),
            square_n,
            lever_m,
            delay_steps,
            delay_part: steps - delay_steps as f32,
        }
    }
}

impl MotorBankState {
    /// Commands that are in force from now on. Gives the mean torque about roll and pitch over the last step that each
    /// lag would have made of those before, N m.
    pub fn update(&mut self, bank: &MotorBank, mut commands: [f32; 4]) -> [[f32; AXES]; LAGS] {
        for kept in &mut self.commands {
            core::mem::swap(kept, &mut commands);
        }
        let of = |steps: usize| self.commands.get(steps).copied().unwrap_or_default();
        let (early, late) = (of(bank.delay_steps + 2), of(bank.delay_steps + 1));
        let acting: [f32; 4] =
            core::array::from_fn(|motor| bank.delay_part * early[motor] + (1.0 - bank.delay_part) * late[motor]);
        let mut torque_nm = [[0.0; AXES]; LAGS];
        for ((torque_nm, lagged), step) in torque_nm.iter_mut().zip(&mut self.lagged).zip(&bank.steps) {
            for motor in 0..4 {
                let lacking = lagged[motor] - acting[motor];
                let mean = acting[motor] + step.rate_share * lacking;
                lagged[motor] = acting[motor] + step.kept * lacking;
                let lift_n = mean * (bank.linear_n + bank.square_n * mean);
                for axis in 0..AXES {
                    torque_nm[axis] += bank.lever_m * TORQUE_SIGNS[axis][motor] * lift_n;
                }
            }
        }
        torque_nm
    }
}
