//! Sweep, roll-out, and their alternation.

use super::{BoundedLq, Guess, Held, Law, Model, Stage};
use crate::qp::Status;

/// Roll-outs that a guess from the last solve is given before a start with everything free.
const WARM_LIMIT: u16 = 6;

/// Roll-outs in which any number of inputs changes. From a start with everything free the shipped problems need 8 at
/// most (docs/solver.md); other weights can make them go round in circles.
const BLOCK_LIMIT: u16 = WARM_LIMIT + 12;

/// Most roll-outs from a start with everything free that any state of the shipped problems takes: found by following every way
/// that they can go (tests/campaigns/src/worst_case).
#[cfg(test)]
pub(super) const COLD_MOST: u16 = 8;

/// Roll-outs altogether.
const ITERATION_LIMIT: u16 = 500;

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Outcome {
    /// The first input: inside its bounds whatever the status.
    pub(in crate::mpc) input: f32,
    pub(in crate::mpc) status: Status,
    /// Roll-outs; 1 if the first guess was right.
    pub(in crate::mpc) iterations: u16,
}

/// Cuts an input at its bounds.
#[inline(always)]
pub(super) fn cut(wish: f32) -> (f32, Held) {
    if wish > 1.0 {
        (1.0, Held::High)
    } else if wish < -1.0 {
        (-1.0, Held::Low)
    } else {
        (wish, Held::Free)
    }
}

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// Solves from the state `start` and the input `previous`, beginning with `guess` and leaving the last one there.
    #[inline(always)]
    pub(in crate::mpc) fn solve(&self, start: &[f32; S], previous: f32, guess: &mut Guess<S, M>) -> Outcome {
        // The quiet case, which is the most frequent one, in a dozen operations; false for what is no number.
        match self.free.first() {
            Some(first) if guess.held_count == 0 && first.reaches_no_bound(start, previous) => {
                Outcome { input: first.law.input(start, previous), status: Status::Solved, iterations: 1 }
            }
            _ => self.search(start, previous, guess, ITERATION_LIMIT),
        }
    }

    /// The alternation of sweeps and roll-outs, `limit` of the latter at most.
    #[inline(never)]
    pub(super) fn search(&self, start: &[f32; S], previous: f32, guess: &mut Guess<S, M>, limit: u16) -> Outcome {
        let is_number = previous.is_finite() && start.iter().all(|value| value.is_finite());
        if !is_number {
            return Outcome { input: 0.0, status: Status::NumericalError, iterations: 0 };
        }
        if guess.stamp != self.stamp {
            guess.clear();
            guess.stamp = self.stamp;
        }
        let restart = if guess.held_count > 0 { WARM_LIMIT } else { 0 };
        let mut iterations = 0;
        loop {
            iterations += 1;
            let changed = if iterations <= BLOCK_LIMIT {
                self.roll_out(start, previous, guess)
            } else {
                self.change_first(start, previous, guess)
            };
            let is_last = changed == 0 || iterations >= limit;
            if is_last {
                let status = if changed == 0 { Status::Solved } else { Status::IterationLimit };
                let outcome = self.finish(start, previous, guess, Outcome { input: 0.0, status, iterations });
                if changed > 0 {
                    // its laws are those of another guess: no warm start
                    guess.clear();
                }
                return outcome;
            }
            if iterations == restart {
                guess.clear();
            } else {
                self.sweep(guess, changed);
            }
        }
    }

    /// The first input, after the last roll-out.
    fn finish(&self, start: &[f32; S], previous: f32, guess: &mut Guess<S, M>, outcome: Outcome) -> Outcome {
        let wish = match (guess.stages.first(), self.free.first()) {
            (Some(stage), _) if guess.held_count > 0 => stage.law.input(start, previous),
            (_, Some(stage)) => stage.law.input(start, previous),
            _ => 0.0,
        };
        let (input, _) = cut(wish);
        if input.is_nan() {
            guess.clear();
            return Outcome { input: 0.0, status: Status::NumericalError, ..outcome };
        }
        Outcome { input, ..outcome }
    }

    /// Follows the laws of `guess` from the present state, cuts the inputs, and notes in `guess` which ones were cut.
    ///
    /// Returns the number of stages up to the last that changed, 0 if none did.
    fn roll_out(&self, start: &[f32; S], previous: f32, guess: &mut Guess<S, M>) -> usize {
        let (mut state, mut input, mut changed) = (*start, previous, 0);
        let mut places = 1..;
        for (stage, place) in guess.stages.iter_mut().take(guess.held_count).zip(&mut places) {
            let wish = stage.law.input(&state, input);
            let (applied, held) = cut(wish);
            input = applied;
            if held != stage.held && stage.held.is_left(wish) {
                stage.held = held;
                changed = place;
            }
            state = self.model.advance(&state, input);
        }
        let rest = self.free.iter().zip(&mut guess.stages).take(self.control_horizon);
        for ((free, stage), place) in rest.skip(guess.held_count).zip(guess.held_count + 1..) {
            if place == guess.held_count + 1 && free.reaches_no_bound(&state, input) {
                break;
            }
            let (applied, held) = cut(free.law.input(&state, input));
            input = applied;
            if held != Held::Free {
                stage.held = held;
                changed = place;
            }
            state = self.model.advance(&state, input);
        }
        changed
    }

    /// Follows the laws of `guess` without cutting, up to the first input that is held wrongly or wrongly free, and changes
    /// that one alone; returns the number of stages up to it, 0 if there is none.
    ///
    /// Least-index pivoting (Murty, *Note on a Bard-type scheme for solving the complementarity problem*, Opsearch 11,
    /// 1974; with upper bounds too: Judice and Pires, Computers & OR 21, 1994): no guess comes twice, so that it ends,
    /// because the Hessian is positive definite. One by one it is slow, and the exit from the circles only.
    fn change_first(&self, start: &[f32; S], previous: f32, guess: &mut Guess<S, M>) -> usize {
        let (mut state, mut input) = (*start, previous);
        let stages = guess.stages.iter_mut().zip(&self.free).take(self.control_horizon);
        for (place, (stage, free)) in (1..).zip(stages) {
            let law = if place <= guess.held_count { &stage.law } else { &free.law };
            let wish = law.input(&state, input);
            if stage.held.is_left(wish) {
                stage.held = if stage.held == Held::Free { cut(wish).1 } else { Held::Free };
                return place;
            }
            input = stage.held.input().unwrap_or(wish);
            state = self.model.advance(&state, input);
        }
        0
    }

    /// Makes laws and costs anew for what `changed` of the first stages, from the last roll-out, say of the inputs.
    pub(super) fn sweep(&self, guess: &mut Guess<S, M>, changed: usize) {
        let seen = if changed > guess.held_count { changed } else { guess.held_count };
        let is_held = |stage: &Stage<S>| stage.held != Held::Free;
        let held_count = guess.stages.iter().take(seen).rposition(is_held).map_or(0, |index| index + 1);
        // The cost ahead of the last stage to be swept: of a stage after which all are free now, or as it was.
        let (count, ahead) = if held_count == guess.held_count {
            (changed, guess.stages.get(..changed).and_then(|stages| stages.last()).map(|stage| stage.ahead))
        } else {
            (held_count, self.free.get(..held_count).and_then(|stages| stages.last()).map(|stage| stage.ahead))
        };
        guess.held_count = held_count;
        let Some(mut ahead) = ahead else { return };
        for stage in guess.stages.iter_mut().take(count).rev() {
            stage.ahead = ahead;
            let (law, mut cost) = ahead.eliminate(self.increment_weight, stage.held.input());
            stage.law = law;
            self.model.add_tracking(&mut cost);
            ahead = self.model.pull_back(&cost);
        }
    }
}

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// Whether all angles that the solved `guess` leads to satisfy `test`, the last input being held for `last_steps`.
    pub(in crate::mpc) fn trajectory(
        &self,
        start: &[f32; S],
        previous: f32,
        guess: &Guess<S, M>,
        last_steps: usize,
        test: impl Fn(f32) -> bool,
    ) -> bool {
        let (mut state, mut input) = (*start, previous);
        for stage in guess.stages.iter().take(guess.held_count) {
            input = stage.held.input().unwrap_or_else(|| stage.law.input(&state, input));
            state = self.model.advance(&state, input);
            if !test(state[0]) {
                return false;
            }
        }
        for stage in self.free.iter().take(self.control_horizon).skip(guess.held_count) {
            input = stage.law.input(&state, input);
            state = self.model.advance(&state, input);
            if !test(state[0]) {
                return false;
            }
        }
        let mut all = true;
        self.model.see_extreme_angles(&state, input, last_steps - 1, |_, angle| all &= test(angle));
        all
    }

    /// The first input's law when every input is free.
    pub(in crate::mpc) fn first_free_law(&self) -> Law<S> {
        self.free.first().map_or(Law::ZERO, |stage| stage.law)
    }
}
