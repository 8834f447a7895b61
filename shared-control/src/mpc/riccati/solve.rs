//! Sweep, roll-out, and their alternation.

use super::{BoundedLq, FreeStage, Guess, Held, Model, Quadratic};

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Outcome {
    pub(in crate::mpc) input: f32,
    pub(in crate::mpc) is_solved: bool,
    pub(in crate::mpc) iterations: u16,
}

#[inline(always)]
fn cut(wish: f32) -> (f32, Held) {
    if wish > 1.0 {
        (1.0, Held::High)
    } else if wish < -1.0 {
        (-1.0, Held::Low)
    } else {
        (wish, Held::Free)
    }
}

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// `last` is the cost ahead of the last input, which is held to the horizon's end.
    pub(in crate::mpc) fn prepare(model: D, increment_weight: f32, control_horizon: usize, last: Quadratic<S>) -> Self {
        let blank = FreeStage {
            law: super::Law { state: [0.0; S], previous: 0.0, offset: 0.0 },
            ahead: Quadratic::ZERO,
            reach_state: [0.0; S],
            reach_previous: 0.0,
        };
        let mut free = [blank; M];
        let mut ahead = last;
        for stage in free.iter_mut().take(control_horizon).rev() {
            let (law, mut cost) = ahead.eliminate(increment_weight, Held::Free);
            stage.law = law;
            stage.ahead = ahead;
            model.add_tracking(&mut cost);
            ahead = model.pull_back(&cost);
        }
        let mut lq = Self { model, increment_weight, control_horizon, free };
        lq.fill_reach();
        lq
    }

    fn fill_reach(&mut self) {
        for start in 0..self.control_horizon {
            for which in 0..=S {
                let mut state = [0.0; S];
                let mut previous = 0.0;
                match state.get_mut(which) { Some(entry) => *entry = 1.0, None => previous = 1.0 }
                let mut greatest = 0.0;
                for stage in self.free.iter().take(self.control_horizon).skip(start) {
                    let input = stage.law.input(&state, previous);
                    let size = if input < 0.0 { -input } else { input };
                    if size > greatest { greatest = size }
                    state = self.model.advance(&state, input);
                    previous = input;
                }
                // a hair more, for rounding
                greatest *= 1.00001;
                if let Some(stage) = self.free.get_mut(start) {
                    match stage.reach_state.get_mut(which) { Some(entry) => *entry = greatest, None => stage.reach_previous = greatest }
                }
            }
        }
    }

    pub(in crate::mpc) fn solve(&self, start: &[f32; S], previous: f32, guess: &mut Guess<S, M>) -> Outcome {
        let mut iterations = 0;
        loop {
            iterations += 1;
            let changed = self.roll_out(start, previous, guess);
            if changed == 0 || iterations > 100 {
                let wish = match guess.stages.first() {
                    Some(stage) if guess.held_count > 0 => stage.law.input(start, previous),
                    _ => self.free.first().map_or(0.0, |stage| stage.law.input(start, previous)),
                };
                return Outcome { input: cut(wish).0, is_solved: changed == 0, iterations };
            }
            self.sweep(guess, changed);
        }
    }

    /// Returns the number of stages up to the last that changed, 0 if none.
    fn roll_out(&self, start: &[f32; S], previous: f32, guess: &mut Guess<S, M>) -> usize {
        let mut state = *start;
        let mut input = previous;
        let mut changed = 0;
        for (index, stage) in guess.stages.iter_mut().take(guess.held_count).enumerate() {
            let (applied, held) = cut(stage.law.input(&state, input));
            input = applied;
            if held != stage.held {
                stage.held = held;
                changed = index + 1;
            }
            state = self.model.advance(&state, input);
        }
        let mut tail = self.free.iter().zip(&mut guess.stages).take(self.control_horizon).enumerate().skip(guess.held_count);
        if let Some(free) = self.free.get(guess.held_count) {
            let start = free.reach_previous * input.abs();
            let reach = free.reach_state.iter().zip(&state).fold(start, |sum, (reach, value)| sum + reach * value.abs());
            if reach <= 1.0 {
                return changed;
            }
        }
        for (index, (free, stage)) in &mut tail {
            let (applied, held) = cut(free.law.input(&state, input));
            input = applied;
            if held != Held::Free {
                stage.held = held;
                changed = index + 1;
            }
            state = self.model.advance(&state, input);
        }
        changed
    }

    fn sweep(&self, guess: &mut Guess<S, M>, changed: usize) {
        let seen = if changed > guess.held_count { changed } else { guess.held_count };
        let held_count = guess.stages.iter().take(seen).rposition(|stage| stage.held != Held::Free).map_or(0, |index| index + 1);
        let top = if held_count != guess.held_count { held_count } else { changed };
        let ahead = if held_count != guess.held_count {
            self.free.get(top.wrapping_sub(1)).map(|stage| stage.ahead)
        } else {
            guess.stages.get(top.wrapping_sub(1)).map(|stage| stage.ahead)
        };
        guess.held_count = held_count;
        let Some(mut ahead) = ahead else { return };
        for stage in guess.stages.iter_mut().take(top).rev() {
            stage.ahead = ahead;
            let (law, mut cost) = ahead.eliminate(self.increment_weight, stage.held);
            stage.law = law;
            self.model.add_tracking(&mut cost);
            ahead = self.model.pull_back(&cost);
        }
    }
}
