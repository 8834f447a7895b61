//! One axis: its problem in units of its own, prepared at start-up, and the solve at each control step.

use super::AxisSettings;
use super::bounded_output::BoundedOutput;
use super::model::PredictedAngles;
use super::riccati::{BoundedLq, DoubleIntegrator, Guess, Model, Outcome};
use crate::qp::{QpError, Status, Workspace};

/// A prepared axis with room for M free inputs.
#[derive(Clone, Debug)]
pub(super) struct Axis<const M: usize> {
    lq: BoundedLq<DoubleIntegrator, 2, M>,
    units: Units,
    bounded_output: Option<BoundedOutput<M>>,
    control_horizon: usize,
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
        let last = DoubleIntegrator.cost_of_held_input(last_steps);
        let angles = PredictedAngles::new(horizon, control_horizon, prediction_step_s, settings.input_gain);
        Ok(Self {
            lq: BoundedLq::prepare(DoubleIntegrator, increment_weight, control_horizon, last)?,
            units,
            bounded_output: BoundedOutput::prepare(&angles, settings)?,
            control_horizon,
            last_steps,
        })
    }

    /// Solves for `request`; the input is finite and inside its bounds whatever the status.
    pub(super) fn solve(&self, request: &AxisRequest, state: &mut AxisState<M>) -> Outcome {
        let AxisRequest { input_prev, reference_rad, .. } = *request;
        let start = self.start(request);
        let previous = self.units.input * input_prev;
        let mut outcome = self.lq.solve(&start, previous, &mut state.guess);
        if let (Some(bounded), Status::Solved) = (&self.bounded_output, outcome.status) {
            let one = self.units.angle * (-bounded.output_max_rad - reference_rad);
            let other = self.units.angle * (bounded.output_max_rad - reference_rad);
            let limits = if one < other { [one, other] } else { [other, one] };
            outcome = if self.control_horizon == 1 {
                self.cut_at_outputs(&start, &limits, outcome)
            } else {
                self.bound_outputs(bounded, request, &limits, state, outcome)
            };
        } else {
            outcome.input *= self.units.input_max;
        }
        if outcome.status != Status::Solved {
            outcome.input = self.present_input(input_prev);
        }
        outcome
    }

    /// The state, in the axis' units: angle from the reference, and rate.
    fn start(&self, request: &AxisRequest) -> [f32; 2] {
        [self.units.angle * (request.angle_rad - request.reference_rad), self.units.rate * request.rate_rad_s]
    }

    /// With one input over the whole horizon: cut where the first angle leaves its limits.
    #[inline(never)]
    fn cut_at_outputs(&self, start: &[f32; 2], limits: &[f32; 2], outcome: Outcome) -> Outcome {
        let ([angle, rate], [lower, upper]) = (*start, *limits);
        let (mut least, mut greatest, mut time) = (-1.0, 1.0, 0.0);
        for _ in 0..self.last_steps {
            time += 1.0;
            let free = angle + time * rate;
            let per_input = 2.0 / (time * time);
            let (from, to) = ((lower - free) * per_input, (upper - free) * per_input);
            if from > least {
                least = from;
            }
            if to < greatest {
                greatest = to;
            }
        }
        let input = if outcome.input < least {
            least
        } else if outcome.input > greatest {
            greatest
        } else {
            outcome.input
        };
        let status = if least <= greatest { Status::Solved } else { Status::Infeasible };
        Outcome { input: self.units.input_max * input, status, ..outcome }
    }

    /// With several inputs: the optimum without limits on the angle if it keeps them, else the dense program's.
    #[inline(never)]
    fn bound_outputs(
        &self,
        bounded: &BoundedOutput<M>,
        request: &AxisRequest,
        limits: &[f32; 2],
        state: &mut AxisState<M>,
        outcome: Outcome,
    ) -> Outcome {
        let start = self.start(request);
        let [lower, upper] = *limits;
        let keeps = |[angle, _]: &[f32; 2]| lower <= *angle && *angle <= upper;
        let previous = self.units.input * request.input_prev;
        if self.lq.trajectory(&start, previous, &state.guess, self.last_steps, keeps) {
            return Outcome { input: self.units.input_max * outcome.input, ..outcome };
        }
        let dense = bounded.solve(request, &mut state.dense);
        Outcome { iterations: outcome.iterations.saturating_add(dense.iterations), ..dense }
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
