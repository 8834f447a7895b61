//! One axis: its problem in units of its own, prepared at start-up, and the solve at each control step.

use super::AxisSettings;
use super::riccati::{BoundedLq, DoubleIntegrator, Guess, Outcome, Quadratic};
use crate::qp::QpError;

/// A prepared axis with room for M free inputs.
#[derive(Clone, Debug)]
pub(super) struct Axis<const M: usize> {
    lq: BoundedLq<DoubleIntegrator, 2, M>,
    angle_scale: f32,
    rate_scale: f32,
    input_scale: f32,
    input_max: f32,
}

/// Warm start.
pub(super) type AxisGuess<const M: usize> = Guess<2, M>;

/// Where an axis is and where it shall go.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisRequest {
    pub(super) angle_rad: f32,
    pub(super) rate_rad_s: f32,
    pub(super) input_prev: f32,
    pub(super) reference_rad: f32,
}

impl<const M: usize> Axis<M> {
    pub(super) fn prepare(
        horizon: usize,
        control_horizon: usize,
        prediction_step_s: f32,
        settings: &AxisSettings,
    ) -> Result<Self, QpError> {
        let effect = settings.input_gain * prediction_step_s * prediction_step_s * settings.input_max;
        let weight = settings.increment_weight / settings.tracking_weight
            * (settings.input_max / effect) * (settings.input_max / effect);
        let mut last = Quadratic::ZERO;
        for step in 1..=(horizon + 1 - control_horizon) {
            let step = step as f32;
            let half = 0.5 * step * step;
            last.state[0][0] += 1.0;
            last.state[0][1] += step;
            last.state[1][1] += step * step;
            last.cross[0] += half;
            last.cross[1] += step * half;
            last.input += half * half;
        }
        Ok(Self {
            lq: BoundedLq::prepare(DoubleIntegrator, weight, control_horizon, last),
            angle_scale: 1.0 / effect,
            rate_scale: prediction_step_s / effect,
            input_scale: 1.0 / settings.input_max,
            input_max: settings.input_max,
        })
    }

    pub(super) fn solve(&self, request: &AxisRequest, guess: &mut AxisGuess<M>) -> Outcome {
        let AxisRequest { angle_rad, rate_rad_s, input_prev, reference_rad } = *request;
        let state = [(angle_rad - reference_rad) * self.angle_scale, rate_rad_s * self.rate_scale];
        let mut outcome = self.lq.solve(&state, input_prev * self.input_scale, guess);
        outcome.input *= self.input_max;
        outcome
    }
}
