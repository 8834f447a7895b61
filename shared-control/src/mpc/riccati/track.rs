//! Tracking: the problem at the head of [`super`] with a reference that changes over the horizon, tracking(x_k) being
//! (angle_k - r_k)^2, and with bounds of any two values.
//!
//! Quadratic parts of the costs know nothing of reference and bounds. So each pass is a sweep of the linear parts through
//! the free stages at the end, whose laws were made at start-up, a whole sweep through the stages up to the last held one,
//! and a roll-out. Nothing of one solve is needed in the next but which inputs were held: a warm start fits any problem.

use super::quadratic::{Law, Quadratic};
use super::{BoundedLq, Held, Model, Outcome, SLACK};
use crate::qp::Status;

/// Passes that the last solve's pattern is given before a start with everything free.
const WARM_LIMIT: u16 = 6;
/// Passes in which any number of inputs changes.
const BLOCK_LIMIT: u16 = WARM_LIMIT + 12;
/// Passes altogether; after [`BLOCK_LIMIT`] inputs change one by one, which cannot go round in circles. A loop with a deadline has
/// no time for all that this could take.
const PASS_LIMIT: u16 = 40;

/// What is to be solved now.
#[derive(Clone, Copy, Debug)]
pub(in crate::mpc) struct Tracking<'a, const S: usize> {
    /// The present state.
    pub(in crate::mpc) start: [f32; S],
    /// The input before the first.
    pub(in crate::mpc) previous: f32,
    /// Least and greatest input.
    pub(in crate::mpc) bounds: [f32; 2],
    /// r_1 to r_N, one for each step of the prediction. As many as the problem was prepared for: the control horizon's, and
    /// those over which the last input is held.
    pub(in crate::mpc) reference: &'a [f32],
}

impl<const S: usize> Tracking<'_, S> {
    fn is_sound(&self) -> bool {
        let [low, high] = self.bounds;
        let sum = self.reference.iter().chain(&self.start).fold(self.previous, |sum, value| sum + value.abs());
        // false for what is no number
        low <= high && (high - low).is_finite() && sum.is_finite()
    }

    #[inline(always)]
    fn cut(&self, wish: f32) -> (f32, Held) {
        let [low, high] = self.bounds;
        if wish > high {
            (high, Held::High)
        } else if wish < low {
            (low, Held::Low)
        } else {
            (wish, Held::Free)
        }
    }

    #[inline(always)]
    fn held_input(&self, held: Held) -> Option<f32> {
        let [low, high] = self.bounds;
        match held {
            Held::Free => None,
            Held::High => Some(high),
            Held::Low => Some(low),
        }
    }

    /// Whether an input so held does not stay so, its law asking for `wish`.
    #[inline(always)]
    fn is_left(&self, held: Held, wish: f32) -> bool {
        let [low, high] = self.bounds;
        match held {
            Held::Free => wish > high || wish < low,
            Held::High => wish < high - SLACK,
            Held::Low => wish > low + SLACK,
        }
    }
}

/// Which inputs the last solve held, and the whole plan that came out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Pattern<const M: usize> {
    held: [Held; M],
    /// The inputs of the plan, as many as the control horizon.
    pub(in crate::mpc) inputs: [f32; M],
}

impl<const M: usize> Pattern<M> {
    /// Everything free.
    pub(in crate::mpc) const fn new() -> Self {
        Self { held: [Held::Free; M], inputs: [0.0; M] }
    }
}

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// Solves, beginning with the inputs held that `pattern` says and leaving there which ones are, and the plan. The
    /// first input of the result is inside the bounds if there are any.
    pub(in crate::mpc) fn track(&self, problem: &Tracking<'_, S>, pattern: &mut Pattern<M>) -> Outcome {
        self.track_within(PASS_LIMIT, problem, pattern)
    }

    /// The same in so many passes at most.
    fn track_within(&self, limit: u16, problem: &Tracking<'_, S>, pattern: &mut Pattern<M>) -> Outcome {
        if !problem.is_sound() {
            return Outcome { input: 0.0, status: Status::NumericalError, iterations: 0 };
        }
        let mut laws = [Law::ZERO; M];
        let is_warm = pattern.held.iter().any(|held| *held != Held::Free);
        let mut iterations = 0;
        let status = loop {
            iterations += 1;
            self.sweep_tracking(problem, &pattern.held, &mut laws);
            let has_changed = if iterations <= BLOCK_LIMIT {
                self.roll_out_tracking(problem, &laws, pattern)
            } else {
                self.change_first_tracking(problem, &laws, pattern)
            };
            match has_changed {
                false => break Status::Solved,
                true if iterations >= limit => break Status::IterationLimit,
                true if is_warm && iterations == WARM_LIMIT => pattern.held = [Held::Free; M],
                true => {}
            }
        };
        let (input, _) = problem.cut(pattern.inputs.first().copied().unwrap_or_default());
        if input.is_nan() {
            *pattern = Pattern::new();
            return Outcome { input: 0.0, status: Status::NumericalError, iterations };
        }
        Outcome { input, status, iterations }
    }

    /// The prediction model.
    pub(in crate::mpc) fn model(&self) -> &D {
        &self.model
    }

    /// Laws of all stages for a guess of which inputs are held.
    #[inline(never)]
    fn sweep_tracking(&self, problem: &Tracking<'_, S>, held: &[Held; M], laws: &mut [Law<S>; M]) {
        let count = self.control_horizon;
        let held_count = held.iter().take(count).rposition(|held| *held != Held::Free).map_or(0, |index| index + 1);
        // r_k belongs to the state before stage k; the last stage answers for its own and for all that follow
        let (before, last) = problem.reference.split_at_checked(count.saturating_sub(1)).unwrap_or((&[], &[]));
        let mut linear = self.linear_of_held_input(last);
        let inverse_weight = 1.0 / self.increment_weight;
        let stages = self.free.iter().zip(laws.iter_mut()).take(count).enumerate();
        for (stage, (free, law)) in stages.skip(held_count).rev() {
            let (state, input) = &mut linear;
            *law = Law { offset: -*input * free.law.previous * inverse_weight, ..free.law };
            for (entry, gain) in state.iter_mut().zip(&law.state) {
                *entry += *input * gain;
            }
            *input *= law.previous;
            if let Some(reference) = stage.checked_sub(1).and_then(|index| before.get(index)) {
                self.model.add_reference(state, *reference);
            }
            linear = self.model.pull_back_linear(state, *input);
        }
        let Some(last_held) = self.free.get(..held_count).and_then(|stages| stages.last()) else { return };
        let mut ahead = Quadratic { state_linear: linear.0, input_linear: linear.1, ..last_held.ahead };
        for (stage, (held, law)) in held.iter().zip(laws.iter_mut()).take(held_count).enumerate().rev() {
            let (stage_law, mut cost) = ahead.eliminate(self.increment_weight, problem.held_input(*held));
            *law = stage_law;
            if let Some(reference) = stage.checked_sub(1).and_then(|index| before.get(index)) {
                self.model.add_reference(&mut cost.state_linear, *reference);
            }
            self.model.add_tracking(&mut cost);
            ahead = self.model.pull_back(&cost);
        }
    }

    /// What the references over the held last input add to the cost ahead of it, in (state, input).
    fn linear_of_held_input(&self, reference: &[f32]) -> ([f32; S], f32) {
        reference.iter().rev().fold(([0.0; S], 0.0), |(mut state, input), reference| {
            self.model.add_reference(&mut state, *reference);
            self.model.pull_back_linear(&state, input)
        })
    }

    /// Follows the laws, cuts the inputs, and notes which ones were cut; true if that differs from the guess.
    #[inline(never)]
    fn roll_out_tracking(&self, problem: &Tracking<'_, S>, laws: &[Law<S>; M], pattern: &mut Pattern<M>) -> bool {
        let (mut state, mut input, mut has_changed) = (problem.start, problem.previous, false);
        let stages = pattern.held.iter_mut().zip(&mut pattern.inputs).zip(laws);
        for ((held, kept), law) in stages.take(self.control_horizon) {
            let wish = law.input(&state, input);
            let (applied, cut) = problem.cut(wish);
            if cut != *held && problem.is_left(*held, wish) {
                *held = cut;
                has_changed = true;
            }
            input = applied;
            *kept = applied;
            state = self.model.advance(&state, input);
        }
        has_changed
    }

    /// Follows the laws without cutting up to the first input that is held wrongly or wrongly free, and changes that one
    /// alone (Murty's least index, as in the solve without references); true if there was one.
    fn change_first_tracking(&self, problem: &Tracking<'_, S>, laws: &[Law<S>; M], pattern: &mut Pattern<M>) -> bool {
        let (mut state, mut input) = (problem.start, problem.previous);
        let stages = pattern.held.iter_mut().zip(&mut pattern.inputs).zip(laws);
        for ((held, kept), law) in stages.take(self.control_horizon) {
            let wish = law.input(&state, input);
            (*kept, _) = problem.cut(wish);
            if problem.is_left(*held, wish) {
                *held = if *held == Held::Free { problem.cut(wish).1 } else { Held::Free };
                return true;
            }
            input = problem.held_input(*held).unwrap_or(wish);
            *kept = input;
            state = self.model.advance(&state, input);
        }
        false
    }
}

#[cfg(test)]
mod tests;
