//! One axis: its problem in units of its own, prepared at start-up, and the solve at each control step.

use super::AxisSettings;
use super::riccati::{AngleBounds, BoundedLq, DoubleIntegrator, Guess, HeldAngles, Model, Outcome, SoftAngle};
use crate::elementary::limit;
use crate::qp::{QpError, Status};

/// A prepared axis with room for M free inputs.
#[derive(Clone, Debug)]
pub(super) struct Axis<const M: usize> {
    lq: BoundedLq<DoubleIntegrator, 2, M>,
    units: Units,
    output: Option<OutputBound>,
    control_horizon: usize,
    /// Prediction steps over which the last input is held.
    last_steps: usize,
}

/// Warm starts of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisState<const M: usize> {
    guess: Guess<2, M>,
    /// Of the problem with bounds on the angle.
    held: HeldAngles,
}

impl<const M: usize> AxisState<M> {
    pub(super) const fn new() -> Self {
        Self { guess: Guess::new(), held: HeldAngles::NONE }
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

/// A bound on the angle over the horizon.
#[derive(Clone, Copy, Debug)]
struct OutputBound {
    output_max_rad: f32,
    soft: SoftAngle<2>,
}

/// What a violation of the angle's bound costs, per step and unit of angle: the weight of the increments and this floor,
/// all in the axis' units. Where the increments cost next to nothing, it is the tracking over thirty steps that multipliers
/// work against. The multipliers of bounds that can be kept are below it but at the edge (docs/solver.md).
const PENALTY_FLOOR: f32 = 1e5;
/// So much of the bound is rounding, after one step.
const ANGLE_TOLERANCE: f32 = 1.5e-7;

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
        Ok(Self {
            lq: BoundedLq::prepare(DoubleIntegrator, increment_weight, control_horizon, last)?,
            units,
            output: settings.output_max_rad.map(|output_max_rad| {
                let tolerance = ANGLE_TOLERANCE * output_max_rad * units.angle.abs();
                let soft = SoftAngle::new(&DoubleIntegrator, last_steps, increment_weight + PENALTY_FLOOR, tolerance);
                OutputBound { output_max_rad, soft }
            }),
            control_horizon,
            last_steps,
        })
    }

    /// Solves for `request`; the input is finite and inside its bounds whatever the status.
    pub(super) fn solve(&self, request: &AxisRequest, state: &mut AxisState<M>) -> Outcome {
        let start =
            [self.units.angle * (request.angle_rad - request.reference_rad), self.units.rate * request.rate_rad_s];
        let previous = self.units.input * request.input_prev;
        let outcome = match &self.output {
            Some(output) if state.held.is_any() => {
                let bounds = self.angle_bounds(output, request.reference_rad);
                self.lq.solve_bounded(&start, previous, &bounds, &mut state.guess, &mut state.held)
            }
            Some(output) => {
                let outcome = self.lq.solve(&start, previous, &mut state.guess);
                if outcome.status == Status::Solved {
                    let bounds = self.angle_bounds(output, request.reference_rad);
                    self.keep_bounds(&bounds, &start, previous, state, outcome)
                } else {
                    outcome
                }
            }
            None => self.lq.solve(&start, previous, &mut state.guess),
        };
        let input = match outcome.status {
            Status::Solved => self.units.input_max * outcome.input,
            _ => self.present_input(request.input_prev),
        };
        Outcome { input, ..outcome }
    }

    /// In the axis' units, from the reference.
    fn angle_bounds<'a>(&self, output: &'a OutputBound, reference_rad: f32) -> AngleBounds<'a, 2> {
        let one = self.units.angle * (-output.output_max_rad - reference_rad);
        let other = self.units.angle * (output.output_max_rad - reference_rad);
        let (lower, upper) = if one < other { (one, other) } else { (other, one) };
        AngleBounds::new(lower, upper, &output.soft)
    }

    /// The optimum without bounds on the angle if it keeps them, else the one with them.
    #[inline(never)]
    fn keep_bounds(
        &self,
        bounds: &AngleBounds<'_, 2>,
        start: &[f32; 2],
        previous: f32,
        state: &mut AxisState<M>,
        outcome: Outcome,
    ) -> Outcome {
        if self.control_horizon == 1 {
            if let Some((least, greatest)) = self.inputs_that_keep(bounds, start) {
                return Outcome { input: limit(outcome.input, least, greatest), ..outcome };
            }
        } else {
            let keeps = |angle: f32| bounds.lower <= angle && angle <= bounds.upper;
            if self.lq.trajectory(start, previous, &state.guess, self.last_steps, keeps) {
                return outcome;
            }
        }
        self.lq.give_up(start, bounds, &mut state.guess, &mut state.held);
        let bounded = self.lq.solve_bounded(start, previous, bounds, &mut state.guess, &mut state.held);
        Outcome { iterations: outcome.iterations.saturating_add(bounded.iterations), ..bounded }
    }

    /// The range of the one input that is held over the whole horizon; none if it is empty.
    fn inputs_that_keep(&self, bounds: &AngleBounds<'_, 2>, start: &[f32; 2]) -> Option<(f32, f32)> {
        let [angle, rate] = *start;
        let (mut least, mut greatest, mut time) = (-1.0, 1.0, 0.0);
        for _ in 0..self.last_steps {
            time += 1.0;
            let free = angle + time * rate;
            let per_input = 2.0 / (time * time);
            let (from, to) = ((bounds.lower - free) * per_input, (bounds.upper - free) * per_input);
            if from > least {
                least = from;
            }
            if to < greatest {
                greatest = to;
            }
        }
        (least <= greatest).then_some((least, greatest))
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
