//! The problem with chosen bounds held as equalities and all others ignored: columns, and one roll-out.

use super::columns::{self, Column, Columns};
use super::quadratic::Law;
use super::working_set::{AngleBounds, Change, DualPoint, Rows, Violation};
use super::{BoundedLq, Guess, Held, Model};

/// What the bounds on the angle add to the laws.
pub(super) struct Shifts<const S: usize, const M: usize> {
    pub(super) columns: Columns<S, M>,
    /// On each stage's law.
    pub(super) offsets: [f32; M],
}

impl<const S: usize, const M: usize> Shifts<S, M> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { columns: Columns::new(), offsets: [0.0; M] }
    }
}

/// Whether all held bounds can be kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shifted {
    Kept,
    /// The bound on this angle can't be kept beside the others.
    Dependent(usize),
    /// Far too many are held.
    Overfull,
}

/// State and previous input.
pub(super) type Present<'a, const S: usize> = (&'a [f32; S], f32);

/// A sum of angles on its way back from its latest angle to the present.
struct Sum<'a, D, const S: usize> {
    model: &'a D,
    inverse_weight: f32,
    /// What it depends on at the stage that it has come to.
    state: [f32; S],
    input: f32,
    constant: f32,
}

impl<D: Model<S>, const S: usize> Sum<'_, D, S> {
    /// Past a stage whose input follows `law` or is held: the input's effect, 0 if it is held, and the law's offset per
    /// multiplier.
    #[inline(always)]
    fn pass(&mut self, held: Held, law: &Law<S>, effect: &mut f32, offset: &mut f32) {
        *offset = -self.input * law.previous * self.inverse_weight;
        if let Some(bound) = held.input() {
            *effect = 0.0;
            self.constant += self.input * bound;
            self.input = 0.0;
        } else {
            *effect = self.input;
            self.constant += self.input * law.offset;
            for (entry, gain) in self.state.iter_mut().zip(&law.state) {
                *entry += self.input * gain;
            }
            self.input *= law.previous;
        }
    }

    /// To the stage before, at whose end the angle has this weight in the sum.
    #[inline(always)]
    fn step_back(&mut self, weight: f32) {
        self.state[0] += weight;
        (self.state, self.input) = self.model.pull_back_linear(&self.state, self.input);
    }
}

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// Multipliers of the held angles under the laws of `guess`, to `point`, and what they add to these.
    pub(super) fn shift(
        &self,
        present: Present<'_, S>,
        guess: &Guess<S, M>,
        rows: &Rows,
        bounds: &AngleBounds<'_, S>,
        shifts: &mut Shifts<S, M>,
        point: &mut DualPoint<M>,
    ) -> Shifted {
        let Shifts { columns, offsets } = shifts;
        let unchanged = columns::choose(columns, rows, |column| {
            let (row, weights) = (column.row, column.weights);
            let weight = |index: usize| weights.get(row.wrapping_sub(index)).copied().unwrap_or(0.0);
            self.carry_back(present, guess, bounds, (row, row.saturating_sub(2)), weight, column);
        });
        let Some(unchanged) = unchanged else { return Shifted::Overfull };
        for column in columns.iter_mut() {
            // differences are to be 0
            let bound = if column.is_difference() { None } else { rows.get(column.row).held(bounds) };
            column.excess = column.value - bound.unwrap_or(0.0);
        }
        *offsets = [0.0; M];
        if let Some(last) = rows.given_up().last() {
            let mut given_up = Column::new(last, [0.0; 3]);
            let weight = |index: usize| rows.get(index).slope(bounds);
            self.carry_back(present, guess, bounds, (last, 0), weight, &mut given_up);
            for column in columns.iter_mut() {
                column.excess += column.coupling(&given_up);
            }
            *offsets = given_up.offsets;
        }
        if let Some(row) = columns::solve(columns, unchanged) {
            return Shifted::Dependent(row);
        }
        add_offsets(columns, offsets);
        columns::row_multipliers(columns, rows, &mut point.rows);
        Shifted::Kept
    }

    /// Carries a sum of angles, from the angle `last` to `first` at most, back to the present: effects, offsets, excess.
    #[inline(always)]
    fn carry_back(
        &self,
        (start, previous): Present<'_, S>,
        guess: &Guess<S, M>,
        bounds: &AngleBounds<'_, S>,
        (last, first): (usize, usize),
        weight: impl Fn(usize) -> f32,
        column: &mut Column<S, M>,
    ) {
        let inverse_weight = 1.0 / self.increment_weight;
        let mut sum = Sum { model: &self.model, inverse_weight, state: [0.0; S], input: 0.0, constant: 0.0 };
        let last_stage = self.control_horizon - 1;
        let count = if last < last_stage {
            sum.step_back(weight(last));
            last + 1
        } else {
            let earliest = first.saturating_sub(last_stage);
            let while_held = bounds.soft.while_held.get(earliest..=last - last_stage).unwrap_or(&[]);
            for ((state, input), index) in while_held.iter().zip(last_stage + earliest..) {
                let weight = weight(index);
                for (entry, part) in sum.state.iter_mut().zip(state) {
                    *entry += weight * part;
                }
                sum.input += weight * input;
            }
            last_stage + 1
        };
        let held_count = if guess.held_count < count { guess.held_count } else { count };
        let (Some(free), Some(held)) = (self.free.get(held_count..count), guess.stages.get(..held_count)) else {
            return;
        };
        let (Some((held_effects, effects)), Some((held_offsets, offsets))) =
            (column.effects.split_at_mut_checked(held_count), column.offsets.split_at_mut_checked(held_count))
        else {
            return;
        };
        // between the stages lie the angles before `index`
        let mut index = count;
        let mut step_back = |sum: &mut Sum<'_, D, S>| {
            if index < count {
                sum.step_back(if index > first { weight(index - 1) } else { 0.0 });
            }
            index -= 1;
        };
        for ((free, effect), offset) in free.iter().zip(effects).zip(offsets).rev() {
            step_back(&mut sum);
            sum.pass(Held::Free, &free.law, effect, offset);
        }
        for ((stage, effect), offset) in held.iter().zip(held_effects).zip(held_offsets).rev() {
            step_back(&mut sum);
            sum.pass(stage.held, &stage.law, effect, offset);
        }
        let constant = sum.constant + sum.input * previous;
        column.value = sum.state.iter().zip(start).fold(constant, |total, (entry, value)| total + entry * value);
    }

    /// Follows the shifted laws, without cutting: multipliers of held inputs to `point`; returns the first input and the
    /// worst violation.
    pub(super) fn follow(
        &self,
        (start, previous): Present<'_, S>,
        guess: &Guess<S, M>,
        rows: &Rows,
        bounds: &AngleBounds<'_, S>,
        shifts: &Shifts<S, M>,
        point: &mut DualPoint<M>,
    ) -> (f32, Option<Change>) {
        let (mut state, mut input, mut first) = (*start, previous, None);
        let mut violation = Violation::none(bounds, rows);
        let (count, held_count) = (self.control_horizon, guess.held_count);
        let stages = guess.stages.iter().zip(&shifts.offsets).zip(&mut point.inputs).take(held_count);
        for (index, ((stage, offset), multiplier)) in stages.enumerate() {
            let wish = stage.law.input(&state, input) + offset;
            if let Some(bound) = stage.held.input() {
                let curvature = self.increment_weight / stage.law.previous;
                *multiplier = curvature * (wish - bound) * bound;
                input = bound;
            } else {
                violation.see_free_input(index, wish);
                input = wish;
            }
            first = first.or(Some(input));
            state = self.model.advance(&state, input);
            violation.see_angle(index, state[0]);
        }
        let stages = self.free.iter().zip(&shifts.offsets).take(count).skip(held_count);
        for (index, (free, offset)) in (held_count..).zip(stages) {
            input = free.law.input(&state, input) + offset;
            violation.see_free_input(index, input);
            first = first.or(Some(input));
            state = self.model.advance(&state, input);
            violation.see_angle(index, state[0]);
        }
        let more_steps = bounds.soft.last_steps - 1;
        if rows.has_given_up() {
            for index in count..count + more_steps {
                state = self.model.advance(&state, input);
                violation.see_angle(index, state[0]);
            }
        } else {
            let see = |step, angle| violation.see_angle(count - 1 + step, angle);
            self.model.see_extreme_angles(&state, input, more_steps, see);
        }
        (first.unwrap_or(0.0), violation.worst())
    }

    /// The combination of held bounds that moves nothing, as rates of their multipliers.
    pub(super) fn cancel(&self, guess: &Guess<S, M>, rows: &Rows, shifts: &mut Shifts<S, M>, rates: &mut DualPoint<M>) {
        shifts.offsets = [0.0; M];
        add_offsets(&shifts.columns, &mut shifts.offsets);
        let stages = guess.stages.iter().take(guess.held_count).zip(&shifts.offsets);
        for ((stage, offset), rate) in stages.zip(&mut rates.inputs) {
            if let Some(bound) = stage.held.input() {
                *rate = self.increment_weight / stage.law.previous * offset * bound;
            }
        }
        columns::row_multipliers(&shifts.columns, rows, &mut rates.rows);
    }
}

/// What the multipliers add to the laws.
fn add_offsets<const S: usize, const M: usize>(columns: &[Column<S, M>], offsets: &mut [f32; M]) {
    for column in columns {
        for (sum, offset) in offsets.iter_mut().zip(&column.offsets).take(column.row + 1) {
            *sum += column.multiplier * offset;
        }
    }
}
