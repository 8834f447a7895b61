//! The solve: roll-out and sweep in turn, the same for what flies and for the thesis' problem.
//!
//! A reference and bounds other than 1 enter the linear terms of the costs only: quadratic parts, gains and the
//! division of free stages stay as they were made at start-up. So a tracking problem's sweep takes the linear terms
//! through the free stages at the end, and then whole costs through the stages up to the last held one; a regulation
//! problem has none of the first, and goes on where costs are as they were.

use super::guess::{Held, Laws, LawsOf, Pattern, PatternOf};
use super::problem::{Problem, Slot};
use super::quadratic::{Law, Quadratic};
use super::{BoundedLq, FreeStage, Model};
use crate::qp::Status;

/// Passes that a guess from the last solve is given before a start with everything free.
pub(super) const WARM_LIMIT: u16 = 6;

/// Passes in which any number of inputs changes; after them one by one, which cannot go round in circles. From a start
/// with everything free the thesis' problems need 8 at most (docs/solver.md); references that jump to and fro, and
/// other weights, can make them go round in circles.
pub(super) const BLOCK_LIMIT: u16 = WARM_LIMIT + 12;

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Outcome {
    /// The first input: inside its bounds, if there are any, whatever the status.
    pub(in crate::mpc) input: f32,
    pub(in crate::mpc) status: Status,
    /// Passes; 1 if the first guess was right.
    pub(in crate::mpc) iterations: u16,
}

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// Solves, beginning with the guess in `pattern`, and with `laws` if the problem keeps them, and leaving the last
    /// ones there.
    #[inline(always)]
    pub(in crate::mpc) fn solve<P: Problem<S>>(
        &self,
        problem: &P,
        pattern: &mut PatternOf<P, S, M>,
        laws: &mut LawsOf<P, S, M>,
    ) -> Outcome {
        // The quiet case, which is the most frequent one, in a dozen operations; false for what is no number.
        if P::IS_REGULATION
            && laws.held_count == 0
            && let Some(first) = self.free.first()
            && first.reaches_no_bound(problem.start(), problem.previous())
        {
            let input = first.law.input(problem.start(), problem.previous());
            return Outcome { input, status: Status::Solved, iterations: 1 };
        }
        self.search(problem, pattern, laws, P::PASS_LIMIT)
    }

    /// The alternation of roll-outs and sweeps, `limit` of the former at most.
    #[inline(never)]
    pub(super) fn search<P: Problem<S>>(
        &self,
        problem: &P,
        pattern: &mut PatternOf<P, S, M>,
        laws: &mut LawsOf<P, S, M>,
        limit: u16,
    ) -> Outcome {
        if !problem.is_sound() {
            return Outcome { input: 0.0, status: Status::NumericalError, iterations: 0 };
        }
        self.begin(problem, pattern, laws);
        let is_warm = laws.held_count > 0;
        let mut iterations = 0;
        loop {
            iterations += 1;
            let changed = if iterations <= BLOCK_LIMIT {
                self.roll_out(problem, pattern, laws)
            } else {
                self.change_first(problem, pattern, laws)
            };
            if changed == 0 || iterations >= limit {
                let status = if changed == 0 { Status::Solved } else { Status::IterationLimit };
                return self.finish(problem, pattern, laws, Outcome { input: 0.0, status, iterations });
            }
            if is_warm && iterations == WARM_LIMIT {
                pattern.clear();
                laws.held_count = 0;
                self.sweep(problem, pattern, laws, 0);
            } else {
                self.sweep(problem, pattern, laws, changed);
            }
        }
    }

    /// Laws for the guess to begin with.
    #[inline(always)]
    pub(super) fn begin<P: Problem<S>>(
        &self,
        problem: &P,
        pattern: &mut PatternOf<P, S, M>,
        laws: &mut LawsOf<P, S, M>,
    ) {
        if !P::IS_REGULATION {
            self.sweep(problem, pattern, laws, self.control_horizon);
        } else if laws.stamp != self.stamp {
            pattern.clear();
            (laws.held_count, laws.stamp) = (0, self.stamp);
        }
    }

    /// The first input, after the last roll-out.
    fn finish<P: Problem<S>>(
        &self,
        problem: &P,
        pattern: &mut PatternOf<P, S, M>,
        laws: &mut LawsOf<P, S, M>,
        outcome: Outcome,
    ) -> Outcome {
        let planned = pattern.inputs.first().and_then(Slot::kept);
        let (input, _) = problem.cut(planned.unwrap_or_else(|| self.first_wish(problem, laws)));
        if input.is_nan() {
            pattern.clear();
            laws.held_count = 0;
            return Outcome { input: 0.0, status: Status::NumericalError, ..outcome };
        }
        if P::IS_REGULATION && outcome.status != Status::Solved {
            // its laws are those of another guess: no warm start
            pattern.clear();
            laws.held_count = 0;
        }
        Outcome { input, ..outcome }
    }

    fn first_wish<P: Problem<S>>(&self, problem: &P, laws: &LawsOf<P, S, M>) -> f32 {
        let law = match (laws.laws.first(), self.free.first()) {
            (Some(law), _) if laws.held_count > 0 => law,
            (_, Some(free)) => &free.law,
            _ => return 0.0,
        };
        law.input(problem.start(), problem.previous())
    }

    /// Follows the laws from the present state, cuts the inputs, and notes in `pattern` which ones were cut.
    ///
    /// Returns the number of stages up to the last that changed, 0 if none did.
    fn roll_out<P: Problem<S>>(&self, problem: &P, pattern: &mut PatternOf<P, S, M>, laws: &LawsOf<P, S, M>) -> usize {
        let (mut state, mut input, mut changed) = (*problem.start(), problem.previous(), 0);
        let held_count = laws.held_count;
        for index in 0..held_count {
            let Some((held, planned, law, _)) = self.stage(pattern, laws, index) else { break };
            let wish = law.input(&state, input);
            let (applied, cut) = problem.cut(wish);
            input = applied;
            planned.keep(applied);
            if cut != *held && problem.is_left(*held, wish) {
                *held = cut;
                changed = index + 1;
            }
            state = self.model.advance(&state, input);
        }
        if P::IS_REGULATION && self.free.get(held_count).is_some_and(|free| free.reaches_no_bound(&state, input)) {
            return changed;
        }
        for index in held_count..self.control_horizon {
            let Some((held, planned, law, free)) = self.stage(pattern, laws, index) else { break };
            let (applied, cut) = problem.cut(free_law::<P, S>(free, law).input(&state, input));
            input = applied;
            planned.keep(applied);
            if cut != Held::Free {
                *held = cut;
                changed = index + 1;
            }
            state = self.model.advance(&state, input);
        }
        changed
    }

    /// Follows the laws without cutting, up to the first input that is held wrongly or wrongly free, and changes that
    /// one alone; returns the number of stages up to it, 0 if there is none.
    ///
    /// Least-index pivoting (Murty, *Note on a Bard-type scheme for solving the complementarity problem*, Opsearch 11,
    /// 1974; with upper bounds too: Judice and Pires, Computers & OR 21, 1994): no guess comes twice, so that it ends,
    /// because the Hessian is positive definite. One by one it is slow, and the exit from the circles only.
    fn change_first<P: Problem<S>>(
        &self,
        problem: &P,
        pattern: &mut PatternOf<P, S, M>,
        laws: &LawsOf<P, S, M>,
    ) -> usize {
        let (mut state, mut input) = (*problem.start(), problem.previous());
        for index in 0..self.control_horizon {
            let Some((held, planned, law, free)) = self.stage(pattern, laws, index) else { break };
            let law = if index < laws.held_count { law } else { free_law::<P, S>(free, law) };
            let wish = law.input(&state, input);
            let (applied, cut) = problem.cut(wish);
            planned.keep(applied);
            if problem.is_left(*held, wish) {
                *held = if *held == Held::Free { cut } else { Held::Free };
                return index + 1;
            }
            input = problem.held_input(*held).unwrap_or(wish);
            planned.keep(input);
            state = self.model.advance(&state, input);
        }
        0
    }

    /// What belongs to one stage.
    #[inline(always)]
    pub(super) fn stage<'a, I, C>(
        &'a self,
        pattern: &'a mut Pattern<M, I>,
        laws: &'a Laws<S, M, C>,
        index: usize,
    ) -> Option<(&'a mut Held, &'a mut I, &'a Law<S>, &'a FreeStage<S>)> {
        let Pattern { held, inputs } = pattern;
        Some((held.get_mut(index)?, inputs.get_mut(index)?, laws.laws.get(index)?, self.free.get(index)?))
    }

    /// Makes laws and costs anew for what `changed` of the first stages say of the inputs; later ones are as they were.
    pub(super) fn sweep<P: Problem<S>>(
        &self,
        problem: &P,
        pattern: &PatternOf<P, S, M>,
        laws: &mut LawsOf<P, S, M>,
        changed: usize,
    ) {
        let seen = if changed > laws.held_count { changed } else { laws.held_count };
        let is_held = |held: &Held| *held != Held::Free;
        let held_count = pattern.held.iter().take(seen).rposition(is_held).map_or(0, |index| index + 1);
        let has_moved = held_count != laws.held_count;
        laws.held_count = held_count;
        // The cost ahead of the last stage to be swept: of a stage after which all are free now, or as it was.
        let kept = laws.costs.get(..changed).and_then(|costs| costs.last()).and_then(Slot::kept);
        let (count, mut ahead) = match kept {
            Some(ahead) if !has_moved => (changed, ahead),
            _ => {
                let (state_linear, input_linear) = self.sweep_free(problem, laws);
                let Some(last) = self.free.get(..held_count).and_then(|stages| stages.last()) else { return };
                (held_count, Quadratic { state_linear, input_linear, ..last.ahead })
            }
        };
        for stage in (0..count).rev() {
            let (Some(held), Some(law)) = (pattern.held.get(stage), laws.laws.get_mut(stage)) else { continue };
            if let Some(cost) = laws.costs.get_mut(stage) {
                cost.keep(ahead);
            }
            let (stage_law, mut remaining) = ahead.eliminate(self.increment_weight, problem.held_input(*held));
            *law = stage_law;
            self.add_reference_before(problem, stage, &mut remaining.state_linear);
            self.model.add_tracking(&mut remaining);
            ahead = self.model.pull_back(&remaining);
        }
    }

    /// Takes the linear terms that the reference makes through the free stages at the end; returns those ahead of the
    /// last held stage, in (state, input).
    #[inline(always)]
    fn sweep_free<P: Problem<S>>(&self, problem: &P, laws: &mut LawsOf<P, S, M>) -> ([f32; S], f32) {
        let mut linear = ([0.0; S], 0.0);
        if P::IS_REGULATION {
            return linear;
        }
        let count = self.control_horizon;
        // the last stage answers for the reference after it and for all that follow
        for reference in problem.reference().get(count.saturating_sub(1)..).unwrap_or(&[]).iter().rev() {
            let (state, input) = &mut linear;
            self.model.add_reference(state, *reference);
            linear = self.model.pull_back_linear(state, *input);
        }
        let inverse_weight = 1.0 / self.increment_weight;
        for stage in (laws.held_count..count).rev() {
            let (Some(free), Some(law)) = (self.free.get(stage), laws.laws.get_mut(stage)) else { continue };
            let (state, input) = &mut linear;
            *law = Law { offset: -*input * free.law.previous * inverse_weight, ..free.law };
            for (entry, gain) in state.iter_mut().zip(&law.state) {
                *entry += *input * gain;
            }
            *input *= law.previous;
            self.add_reference_before(problem, stage, state);
            linear = self.model.pull_back_linear(state, *input);
        }
        linear
    }

    /// r_k belongs to the state before stage k.
    #[inline(always)]
    fn add_reference_before<P: Problem<S>>(&self, problem: &P, stage: usize, state_linear: &mut [f32; S]) {
        if !P::IS_REGULATION
            && let Some(reference) = stage.checked_sub(1).and_then(|index| problem.reference().get(index))
        {
            self.model.add_reference(state_linear, *reference);
        }
    }

    /// The first input's law when every input is free and the reference is zero.
    pub(in crate::mpc) fn first_free_law(&self) -> Law<S> {
        self.free.first().map_or(Law::ZERO, |stage| stage.law)
    }

    /// The prediction model.
    pub(in crate::mpc) fn model(&self) -> &D {
        &self.model
    }
}

/// The law of a stage from the last held one on.
#[inline(always)]
pub(super) fn free_law<'a, P: Problem<S>, const S: usize>(free: &'a FreeStage<S>, law: &'a Law<S>) -> &'a Law<S> {
    if P::IS_REGULATION { &free.law } else { law }
}
