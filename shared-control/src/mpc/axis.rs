//! One axis: its problem in units of its own, prepared at start-up, and the solve at each control step.

use super::AxisSettings;
use super::bounded_output::BoundedOutput;
use super::model::PredictedAngles;
use super::riccati::{BoundedLq, DoubleIntegrator, Guess, Outcome};
use crate::qp::{QpError, Status, Workspace};

/// A prepared axis with room for M free inputs.
#[derive(Clone, Debug)]
pub(super) struct Axis<const M: usize> {
    lq: BoundedLq<DoubleIntegrator, 2, M>,
    units: Units,
    bounded_output: Option<BoundedOutput<M>>,
    /// Prediction steps over which the last input is held.
    last_steps: usize,
}

/// Warm starts of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisState<const M: usize> {
    guess: Guess<2, M>,
    /// Of the program with bounds on the angle.
    dense: Workspace<M>,
}

impl<const M: usize> AxisState<M> {
    pub(super) const fn new() -> Self {
        Self { guess: Guess::new(), dense: Workspace::new() }
    }
}

/// Where an axis is and where it shall go.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisRequest {
    pub(super) angle_rad: f32,
    pub(super) rate_rad_s: f32,
    pub(super) input_prev: f32,
    pub(super) reference_rad: f32,
}

/// Factors into the units in which the problem has as few numbers as possible: the prediction step, the weight of the
/// angle, the bound of the input, and how much faster that makes the axis in one step, are all 1.
#[derive(Clone, Copy, Debug)]
struct Units {
    /// Per rad.
    angle: f32,
    /// Per rad/s.
    rate: f32,
    /// Per input unit.
    input: f32,
    input_max: f32,
}

impl<const M: usize> Axis<M> {
    pub(super) fn prepare(
        horizon: usize,
        control_horizon: usize,
        prediction_step_s: f32,
        settings: &AxisSettings,
    ) -> Result<Self, QpError> {
        let full_turn_rad = settings.input_gain * prediction_step_s * prediction_step_s * settings.input_max;
        let units = Units {
            angle: 1.0 / full_turn_rad,
            rate: prediction_step_s / full_turn_rad,
            input: 1.0 / settings.input_max,
            input_max: settings.input_max,
        };
        let scale = settings.input_max / full_turn_rad;
        let increment_weight = settings.increment_weight / settings.tracking_weight * scale * scale;
        let last_steps = horizon.saturating_sub(control_horizon) + 1;
        let last = DoubleIntegrator::cost_of_held_input(last_steps);
        let angles = PredictedAngles::new(horizon, control_horizon, prediction_step_s, settings.input_gain);
        Ok(Self {
            lq: BoundedLq::prepare(DoubleIntegrator, increment_weight, control_horizon, last)?,
            units,
            bounded_output: BoundedOutput::prepare(&angles, settings)?,
            last_steps,
        })
    }

    /// Solves for `request`; the input is finite and inside its bounds whatever the status.
    pub(super) fn solve(&self, request: &AxisRequest, state: &mut AxisState<M>) -> Outcome {
        let AxisRequest { angle_rad, rate_rad_s, input_prev, reference_rad } = *request;
        let start = [self.units.angle * (angle_rad - reference_rad), self.units.rate * rate_rad_s];
        let previous = self.units.input * input_prev;
        let mut outcome = self.lq.solve(&start, previous, &mut state.guess);
        outcome.input *= self.units.input_max;
        if let (Some(bounded), Status::Solved) = (&self.bounded_output, outcome.status) {
            let lower = self.units.angle * (-bounded.output_max_rad - reference_rad);
            let upper = self.units.angle * (bounded.output_max_rad - reference_rad);
            let limits = if lower < upper { lower..=upper } else { upper..=lower };
            let keeps = |state: &[f32; 2]| limits.contains(&state[0]);
            if !self.lq.trajectory(&start, previous, &state.guess, self.last_steps, keeps) {
                let dense = bounded.solve(request, &mut state.dense);
                outcome = Outcome { iterations: outcome.iterations.saturating_add(dense.iterations), ..dense };
            }
        }
        if outcome.status != Status::Solved {
            outcome.input = self.present_input(input_prev);
        }
        outcome
    }

    /// What stays applied without a plan.
    fn present_input(&self, input_prev: f32) -> f32 {
        let input_max = self.units.input_max;
        // Not `clamp`: its panic message alone brings 25 kB of float formatting onto the board.
        if input_prev > input_max {
            input_max
        } else if input_prev < -input_max {
            -input_max
        } else if input_prev.is_nan() {
            0.0
        } else {
            input_prev
        }
    }

    /// Weights of (angle, rate, previous input, reference) in the first input when no bound is active.
    pub(super) fn unconstrained_gain(&self) -> [f32; 4] {
        let law = self.lq.first_free_law();
        let [angle, rate] = law.state;
        let (angle, rate) =
            (self.units.input_max * self.units.angle * angle, self.units.input_max * self.units.rate * rate);
        [angle, rate, law.previous, -angle]
    }
}
