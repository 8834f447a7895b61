//! One axis: its problem in units of its own, prepared at start-up, and the solve at each control step.

use crate::mpc::AxisSettings;
use crate::mpc::riccati::{
    AngleBounds, BoundedLq, DoubleIntegrator, HeldAngles, Laws, Model, Outcome, Pattern, Problem, Regulating, Slot,
    SoftAngle,
};
use crate::qp::{QpError, Status};

/// A prepared axis with room for M free inputs.
#[derive(Clone, Debug)]
pub(super) struct Axis<const M: usize> {
    lq: BoundedLq<DoubleIntegrator, 2, M>,
    units: Units,
    output: Option<OutputBound>,
}

/// What the problem keeps of the cost ahead of a stage.
type Cost = <Regulating<2> as Problem<2>>::Cost;

/// Warm starts of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisState<const M: usize> {
    pattern: Pattern<M, ()>,
    laws: Laws<2, M, Cost>,
    /// Of the problem with bounds on the angle.
    held: HeldAngles,
}

impl<const M: usize> AxisState<M> {
    pub(super) const fn new() -> Self {
        Self { pattern: Pattern::new(), laws: Laws::blank(Cost::BLANK), held: HeldAngles::NONE }
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
                let angle_max = output_max_rad * units.angle;
                let soft = SoftAngle::new(&DoubleIntegrator, last_steps, increment_weight, angle_max);
                OutputBound { output_max_rad, soft }
            }),
        })
    }

    /// Solves for `request`; the input is finite and inside its bounds whatever the status.
    pub(super) fn solve(&self, request: &AxisRequest, state: &mut AxisState<M>) -> Outcome {
        let problem = Regulating {
            start: [
                self.units.angle * (request.angle_rad - request.reference_rad),
                self.units.rate * request.rate_rad_s,
            ],
            previous: self.units.input * request.input_prev,
        };
        let AxisState { pattern, laws, held } = state;
        let outcome = match &self.output {
            Some(output) => {
                let bounds = self.angle_bounds(output, request.reference_rad);
                self.lq.solve_within(&problem, &bounds, (pattern, laws), held)
            }
            None => self.lq.solve(&problem, pattern, laws),
        };
        let input = match outcome.status {
            Status::Solved => self.units.input_max * outcome.input,
            _ => self.present_input(request.input_prev),
        };
        Outcome { input, ..outcome }
    }

    /// In the axis' units, from the reference.
    fn angle_bounds<'a>(&self, output: &'a OutputBound, reference_rad: f32) -> AngleBounds<'a, 2> {
        let ends_rad = [-output.output_max_rad, output.output_max_rad];
        AngleBounds::new(ends_rad.map(|end_rad| self.units.angle * (end_rad - reference_rad)), &output.soft)
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
