//! What moves the state from stage to stage.

use super::quadratic::Quadratic;

/// A linear model with S states and one input, which a stage holds for one prediction step.
///
/// Written out for each model rather than as matrices: most entries are 0 or 1.
pub(in crate::mpc) trait Model<const S: usize> {
    /// The state after one step.
    fn advance(&self, state: &[f32; S], input: f32) -> [f32; S];

    /// A cost after the step, in (state after, input of the step), as one in (state before, input); adds nothing.
    fn pull_back(&self, after: &Quadratic<S>) -> Quadratic<S>;

    /// The linear part of [`Self::pull_back`] alone: from (state, input) after the step to before it.
    fn pull_back_linear(&self, state: &[f32; S], input: f32) -> ([f32; S], f32);

    /// The tracking cost of a state, the reference being zero.
    fn add_tracking(&self, cost: &mut Quadratic<S>);

    /// The same for a reference: what adds to the linear part.
    fn add_reference(&self, state_linear: &mut [f32; S], reference: f32);

    /// Shows `see` angles after 1 to `steps` more steps with the input held, with the step's number: the least and the
    /// greatest of them, whatever bounds are next to, and maybe others.
    fn see_extreme_angles(&self, state: &[f32; S], input: f32, steps: usize, mut see: impl FnMut(usize, f32)) {
        let mut state = *state;
        for step in 1..=steps {
            state = self.advance(&state, input);
            see(step, state[0]);
        }
    }

    /// Shows `see` every angle after 1 to `steps` steps as what it is with an input of 0 held, and by how much an input
    /// must change for one unit of it.
    fn see_held_input(&self, start: &[f32; S], steps: usize, mut see: impl FnMut(f32, f32)) {
        let (mut free, mut of_input) = (*start, [0.0; S]);
        for _ in 0..steps {
            free = self.advance(&free, 0.0);
            of_input = self.advance(&of_input, 1.0);
            see(free[0], 1.0 / of_input[0]);
        }
    }

    /// The cost ahead of an input that is held for `steps`.
    fn cost_of_held_input(&self, steps: usize) -> Quadratic<S> {
        let mut cost = Quadratic::ZERO;
        for _ in 0..steps {
            self.add_tracking(&mut cost);
            cost = self.pull_back(&cost);
        }
        cost
    }
}

/// Angle error and rate of a rigid body, in units in which the prediction step, the weight of the angle and the effect
/// of the input are 1: angle' = angle + rate + input/2, rate' = rate + input, cost angle^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct DoubleIntegrator;

impl Model<2> for DoubleIntegrator {
    #[inline(always)]
    fn advance(&self, state: &[f32; 2], input: f32) -> [f32; 2] {
        let [angle, rate] = *state;
        [angle + rate + 0.5 * input, rate + input]
    }

    /// T'QT with T = [[1, 1, 1/2], [0, 1, 1], [0, 0, 1]].
    #[inline(always)]
    fn pull_back(&self, after: &Quadratic<2>) -> Quadratic<2> {
        let [[p11, p12], [_, p22]] = after.state;
        let [c1, c2] = after.cross;
        let (state_linear, input_linear) = self.pull_back_linear(&after.state_linear, after.input_linear);
        // the columns of QT that belong to the input
        let column1 = 0.5 * p11 + p12 + c1;
        let column2 = 0.5 * p12 + p22 + c2;
        let column3 = 0.5 * c1 + c2 + after.input;
        let next12 = p11 + p12;
        let rate_column = column1 + column2;
        Quadratic {
            state: [[p11, next12], [0.0, next12 + p12 + p22]],
            cross: [column1, rate_column],
            input: 0.5 * column1 + column2 + column3,
            state_linear,
            input_linear,
        }
    }

    #[inline(always)]
    fn pull_back_linear(&self, [angle, rate]: &[f32; 2], input: f32) -> ([f32; 2], f32) {
        ([*angle, angle + rate], 0.5 * angle + rate + input)
    }

    #[inline(always)]
    fn add_tracking(&self, cost: &mut Quadratic<2>) {
        let [[angle, _], _] = &mut cost.state;
        *angle += 1.0;
    }

    #[inline(always)]
    fn add_reference(&self, [angle, _]: &mut [f32; 2], reference: f32) {
        *angle -= reference;
    }

    /// The ends, and the two steps around the vertex of the parabola.
    #[inline(always)]
    fn see_extreme_angles(&self, state: &[f32; 2], input: f32, steps: usize, mut see: impl FnMut(usize, f32)) {
        let [angle, rate] = *state;
        // 0 for what is negative or no number, the greatest integer for what is beyond
        let vertex = (-rate / input) as usize;
        for step in [1, vertex, vertex.saturating_add(1), steps] {
            if 1 <= step && step <= steps {
                let time = step as f32;
                see(step, angle + time * (rate + 0.5 * time * input));
            }
        }
    }

    /// The parabola.
    #[inline(always)]
    fn see_held_input(&self, [angle, rate]: &[f32; 2], steps: usize, mut see: impl FnMut(f32, f32)) {
        let mut time = 0.0;
        for _ in 0..steps {
            time += 1.0;
            see(angle + time * rate, 2.0 / (time * time));
        }
    }

    /// By sums, which are whole numbers and therefore exact.
    fn cost_of_held_input(&self, steps: usize) -> Quadratic<2> {
        let mut cost = Quadratic::ZERO;
        for step in 1..=steps {
            // angle + time rate + turn input
            let time = step as f32;
            let turn = 0.5 * time * time;
            let [[angle, angle_rate], [_, rate]] = &mut cost.state;
            *angle += 1.0;
            *angle_rate += time;
            *rate += time * time;
            let [cross_angle, cross_rate] = &mut cost.cross;
            *cross_angle += turn;
            *cross_rate += time * turn;
            cost.input += turn * turn;
        }
        cost
    }
}
