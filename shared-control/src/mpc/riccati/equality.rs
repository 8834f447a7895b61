//! The problem with chosen bounds held as equalities and all others ignored: columns, and one roll-out.

use super::angle_bounds::AngleBounds;
use super::columns::{self, Column, Columns};
use super::guess::{Held, LawsOf, PatternOf};
use super::problem::{Problem, Slot};
use super::quadratic::Law;
use super::rows::Rows;
use super::solve::free_law;
use super::working_set::{Change, DualPoint, Violation};
use super::{BoundedLq, Model};

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

/// The guess and its laws.
pub(super) type Present<'a, P, const S: usize, const M: usize> = (&'a PatternOf<P, S, M>, &'a LawsOf<P, S, M>);

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
    /// Past a stage whose input follows `law` or is held at `bound`: the input's effect, 0 if it is held, and the law's
    /// offset per multiplier.
    #[inline(always)]
    fn pass(&mut self, bound: Option<f32>, law: &Law<S>, effect: &mut f32, offset: &mut f32) {
        *offset = -self.input * law.previous * self.inverse_weight;
        if let Some(bound) = bound {
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
    /// Multipliers of the held angles under the guess' laws, to `point`, and what they add to these.
    pub(super) fn shift<P: Problem<S>>(
        &self,
        problem: &P,
        present: Present<'_, P, S, M>,
        rows: &Rows,
        bounds: &AngleBounds<'_, S>,
        shifts: &mut Shifts<S, M>,
        point: &mut DualPoint<M>,
    ) -> Shifted {
        let Shifts { columns, offsets } = shifts;
        let unchanged = columns::choose(columns, rows, |column| {
            let (row, weights) = (column.row, column.weights);
            let weight = |index: usize| weights.get(row.wrapping_sub(index)).copied().unwrap_or(0.0);
            self.carry_back(problem, present, bounds, (row, row.saturating_sub(2)), weight, column);
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
            self.carry_back(problem, present, bounds, (last, 0), weight, &mut given_up);
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

    /// Carries a sum of angles, from the angle `last` to `first` at most, back to the present: effects, offsets,
    /// excess.
    #[inline(always)]
    fn carry_back<P: Problem<S>>(
        &self,
        problem: &P,
        (pattern, laws): Present<'_, P, S, M>,
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
        let held_count = if laws.held_count < count { laws.held_count } else { count };
        // after each stage but the last lies an angle
        let step_back = |sum: &mut Sum<'_, D, S>, stage: usize| {
            if stage + 1 < count {
                sum.step_back(if stage + 1 > first { weight(stage) } else { 0.0 });
            }
        };
        for stage in (held_count..count).rev() {
            let (Some(free), Some(law)) = (self.free.get(stage), laws.laws.get(stage)) else { continue };
            let Some((effect, offset)) = column.at(stage) else { continue };
            step_back(&mut sum, stage);
            sum.pass(None, free_law::<P, S>(free, law), effect, offset);
        }
        for stage in (0..held_count).rev() {
            let (Some(held), Some(law)) = (pattern.held.get(stage), laws.laws.get(stage)) else { continue };
            let Some((effect, offset)) = column.at(stage) else { continue };
            step_back(&mut sum, stage);
            sum.pass(problem.held_input(*held), law, effect, offset);
        }
        let constant = sum.constant + sum.input * problem.previous();
        column.value =
            sum.state.iter().zip(problem.start()).fold(constant, |total, (entry, value)| total + entry * value);
    }

    /// Follows the shifted laws, without cutting: the plan to `pattern`, multipliers of held inputs to `point`; returns
    /// the first input and the worst violation.
    pub(super) fn follow<P: Problem<S>>(
        &self,
        problem: &P,
        (pattern, laws): (&mut PatternOf<P, S, M>, &LawsOf<P, S, M>),
        rows: &Rows,
        bounds: &AngleBounds<'_, S>,
        shifts: &Shifts<S, M>,
        point: &mut DualPoint<M>,
    ) -> (f32, Option<Change>) {
        let (mut state, mut input, mut first) = (*problem.start(), problem.previous(), None);
        let mut violation = Violation::none(problem.bounds(), bounds, rows);
        let (count, held_count) = (self.control_horizon, laws.held_count);
        for index in 0..held_count {
            let (Some(offset), Some(multiplier)) = (shifts.offsets.get(index), point.inputs.get_mut(index)) else {
                break;
            };
            let Some((held, planned, law, _)) = self.stage(pattern, laws, index) else { break };
            let wish = law.input(&state, input) + offset;
            if let Some(bound) = problem.held_input(*held) {
                let curvature = self.increment_weight / law.previous;
                *multiplier = curvature * (wish - bound) * held.sign();
                input = bound;
            } else {
                violation.see_free_input(index, wish);
                input = wish;
            }
            planned.keep(problem.cut(input).0);
            first = first.or(Some(input));
            state = self.model.advance(&state, input);
            violation.see_angle(index, state[0]);
        }
        for index in held_count..count {
            let Some((_, planned, law, free)) = self.stage(pattern, laws, index) else { break };
            let Some(offset) = shifts.offsets.get(index) else { break };
            input = free_law::<P, S>(free, law).input(&state, input) + offset;
            violation.see_free_input(index, input);
            planned.keep(problem.cut(input).0);
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
    pub(super) fn cancel<P: Problem<S>>(
        &self,
        (pattern, laws): Present<'_, P, S, M>,
        rows: &Rows,
        shifts: &mut Shifts<S, M>,
        rates: &mut DualPoint<M>,
    ) {
        shifts.offsets = [0.0; M];
        add_offsets(&shifts.columns, &mut shifts.offsets);
        let stages = pattern.held.iter().zip(&laws.laws).take(laws.held_count).zip(&shifts.offsets);
        for (((held, law), offset), rate) in stages.zip(&mut rates.inputs) {
            if *held != Held::Free {
                *rate = self.increment_weight / law.previous * offset * held.sign();
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
