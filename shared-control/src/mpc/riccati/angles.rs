//! Solving with bounds on the angle: the solution without them where it keeps them, else the one with them.

use super::angle_bounds::AngleBounds;
use super::dual::HeldAngles;
use super::guess::{LawsOf, PatternOf};
use super::problem::{Problem, Slot};
use super::solve::{Outcome, free_law};
use super::{BoundedLq, Model};
use crate::elementary::limit;
use crate::qp::Status;

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// Solves with bounds on the angle, beginning with what `pattern` and `angles` hold and leaving there what is held
    /// at the end.
    #[inline(always)]
    pub(in crate::mpc) fn solve_within<P: Problem<S>>(
        &self,
        problem: &P,
        bounds: &AngleBounds<'_, S>,
        (pattern, laws): (&mut PatternOf<P, S, M>, &mut LawsOf<P, S, M>),
        angles: &mut HeldAngles,
    ) -> Outcome {
        if angles.is_any() {
            return self.go_on_within(problem, bounds, (pattern, laws), angles);
        }
        let outcome = self.solve(problem, pattern, laws);
        if outcome.status != Status::Solved {
            return outcome;
        }
        self.keep_bounds(problem, bounds, (pattern, laws), angles, outcome)
    }

    /// From what the last solution held.
    #[inline(always)]
    fn go_on_within<P: Problem<S>>(
        &self,
        problem: &P,
        bounds: &AngleBounds<'_, S>,
        (pattern, laws): (&mut PatternOf<P, S, M>, &mut LawsOf<P, S, M>),
        angles: &mut HeldAngles,
    ) -> Outcome {
        if P::IS_REGULATION && laws.stamp != self.stamp {
            *angles = HeldAngles::NONE;
        }
        self.begin(problem, pattern, laws);
        self.solve_bounded(problem, bounds, (pattern, laws), angles)
    }

    /// The optimum without bounds on the angle if it keeps them, else the one with them.
    #[inline(never)]
    fn keep_bounds<P: Problem<S>>(
        &self,
        problem: &P,
        bounds: &AngleBounds<'_, S>,
        (pattern, laws): (&mut PatternOf<P, S, M>, &mut LawsOf<P, S, M>),
        angles: &mut HeldAngles,
        outcome: Outcome,
    ) -> Outcome {
        if self.control_horizon == 1 {
            if let Some((least, greatest)) = self.inputs_that_keep(problem, bounds) {
                let input = limit(outcome.input, least, greatest);
                if let Some(planned) = pattern.inputs.first_mut() {
                    planned.keep(input);
                }
                return Outcome { input, ..outcome };
            }
        } else if self.keeps(problem, bounds, (pattern, laws)) {
            return outcome;
        }
        self.give_up(problem, bounds, (pattern, laws), angles);
        let bounded = self.solve_bounded(problem, bounds, (pattern, laws), angles);
        Outcome { iterations: outcome.iterations.saturating_add(bounded.iterations), ..bounded }
    }

    /// The range of the one input that is held over the whole horizon; none if it is empty.
    fn inputs_that_keep<P: Problem<S>>(&self, problem: &P, bounds: &AngleBounds<'_, S>) -> Option<(f32, f32)> {
        let [mut least, mut greatest] = problem.bounds();
        self.model.see_held_input(problem.start(), bounds.soft.last_steps, |free, per_angle| {
            let (from, to) = ((bounds.lower - free) * per_angle, (bounds.upper - free) * per_angle);
            if from > least {
                least = from;
            }
            if to < greatest {
                greatest = to;
            }
        });
        (least <= greatest).then_some((least, greatest))
    }

    /// Whether all angles that the solved guess leads to are inside the bounds.
    pub(super) fn keeps<P: Problem<S>>(
        &self,
        problem: &P,
        bounds: &AngleBounds<'_, S>,
        (pattern, laws): (&PatternOf<P, S, M>, &LawsOf<P, S, M>),
    ) -> bool {
        let keeps = |angle: f32| bounds.lower <= angle && angle <= bounds.upper;
        let (mut state, mut input) = (*problem.start(), problem.previous());
        for index in 0..laws.held_count {
            let (Some(held), Some(law)) = (pattern.held.get(index), laws.laws.get(index)) else { break };
            input = problem.held_input(*held).unwrap_or_else(|| law.input(&state, input));
            state = self.model.advance(&state, input);
            if !keeps(state[0]) {
                return false;
            }
        }
        for index in laws.held_count..self.control_horizon {
            let (Some(free), Some(law)) = (self.free.get(index), laws.laws.get(index)) else { break };
            input = free_law::<P, S>(free, law).input(&state, input);
            state = self.model.advance(&state, input);
            if !keeps(state[0]) {
                return false;
            }
        }
        let mut all = true;
        self.model.see_extreme_angles(&state, input, bounds.soft.last_steps - 1, |_, angle| all &= keeps(angle));
        all
    }
}
