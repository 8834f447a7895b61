//! The bounds that are held, their multipliers, and what changes next.

use super::angle_bounds::AngleBounds;
use super::guess::{Held, Pattern};
use super::rows::{Row, Rows};
use crate::elementary::larger;
use crate::mpc::HORIZON;

/// One bound, and what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    Input(usize, Held),
    Row(usize, Row),
}

impl Change {
    /// Whether both speak of the same input or angle.
    pub(super) fn is_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Input(one, _), Self::Input(two, _)) | (Self::Row(one, _), Self::Row(two, _)) => one == two,
            _ => false,
        }
    }

    /// Makes it so; returns the number of stages up to the last whose law is another now.
    pub(super) fn apply<I, const M: usize>(self, pattern: &mut Pattern<M, I>, rows: &mut Rows) -> usize {
        match self {
            Self::Input(index, held) => {
                set(&mut pattern.held, index, held);
                index + 1
            }
            Self::Row(index, row) => {
                rows.set(index, row);
                0
            }
        }
    }
}

#[inline(always)]
pub(super) fn set<T>(list: &mut [T], index: usize, value: T) {
    if let Some(slot) = list.get_mut(index) {
        *slot = value;
    }
}

/// What a violation of an input's bound counts beside one of an angle's. So inputs are seen to first as long as they
/// are far beyond their bounds, and three times fewer passes are needed at most than with angles first.
const INPUT_SHARE: f32 = 32.0;

/// The worst violation so far.
pub(super) struct Violation<'a, const S: usize> {
    bounds: &'a AngleBounds<'a, S>,
    rows: &'a Rows,
    amount: f32,
    change: Option<Change>,
    input_bounds: [f32; 2],
    /// What is within these is no worse: inputs, and angles.
    input_low: f32,
    input_high: f32,
    lower: f32,
    upper: f32,
}

impl<'a, const S: usize> Violation<'a, S> {
    #[inline(always)]
    pub(super) fn none(input_bounds: [f32; 2], bounds: &'a AngleBounds<'a, S>, rows: &'a Rows) -> Self {
        let ([_, amount], [input_low, input_high]) = (bounds.tolerances, input_bounds);
        let (lower, upper) = (bounds.lower, bounds.upper);
        let mut violation =
            Self { bounds, rows, amount, change: None, input_bounds, input_low, input_high, lower, upper };
        violation.look_beyond(amount);
        violation
    }

    #[inline(always)]
    pub(super) fn see_free_input(&mut self, index: usize, input: f32) {
        let [low, high] = self.input_bounds;
        if input > self.input_high {
            self.is_worse(INPUT_SHARE * (input - high), Change::Input(index, Held::High));
        } else if input < self.input_low {
            self.is_worse(INPUT_SHARE * (low - input), Change::Input(index, Held::Low));
        }
    }

    #[inline(always)]
    pub(super) fn see_angle(&mut self, index: usize, angle: f32) {
        if angle > self.upper || angle < self.lower {
            self.see_bound(index, angle);
        }
    }

    #[inline(never)]
    fn see_bound(&mut self, index: usize, angle: f32) {
        let (above, below) = (angle - self.bounds.upper, self.bounds.lower - angle);
        let (amount, to) = match self.rows.get(index) {
            Row::Loose if above > below => (above, Row::Upper),
            Row::Loose => (below, Row::Lower),
            Row::AboveUpper => (-above, Row::Upper),
            Row::BelowLower => (-below, Row::Lower),
            Row::Upper | Row::Lower => return,
        };
        let [_, tolerance] = self.bounds.tolerances;
        if amount > tolerance * (index + 1) as f32 && amount > self.amount {
            self.is_worse(amount, Change::Row(index, to));
        }
    }

    fn is_worse(&mut self, amount: f32, change: Change) {
        self.change = Some(change);
        self.look_beyond(amount);
    }

    #[inline(always)]
    fn look_beyond(&mut self, amount: f32) {
        let [input_tolerance, _] = self.bounds.tolerances;
        self.amount = amount;
        let ([low, high], beyond) = (self.input_bounds, larger(input_tolerance, amount * (1.0 / INPUT_SHARE)));
        (self.input_low, self.input_high) = (low - beyond, high + beyond);
        // where bounds are given up, an angle inside them may be wrong
        let outside = if self.rows.has_given_up() { f32::NEG_INFINITY } else { amount };
        (self.lower, self.upper) = (self.bounds.lower - outside, self.bounds.upper + outside);
    }

    pub(super) fn worst(&self) -> Option<Change> {
        self.change
    }
}

/// Multipliers of held inputs and of held bounds on the angle: 0 or more, and those of angles at most the weight. Where
/// nothing is held they mean nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DualPoint<const M: usize> {
    pub(super) inputs: [f32; M],
    pub(super) rows: [f32; HORIZON],
}

/// Where the multiplier of a bound that is taken in goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Direction {
    Rises,
    Falls,
}

/// How far multipliers can move before one of them reaches an end, and what its bound becomes there.
#[derive(Clone, Copy)]
pub(super) struct Blocking {
    pub(super) step: f32,
    pub(super) change: Change,
}

impl<const M: usize> DualPoint<M> {
    pub(super) const ZERO: Self = Self { inputs: [0.0; M], rows: [0.0; HORIZON] };

    /// Whether these rates move the multiplier of the bound in its direction.
    pub(super) fn goes(&self, change: Change, direction: Direction) -> bool {
        let rate = match change {
            Change::Input(index, _) => self.inputs.get(index),
            Change::Row(index, _) => self.rows.get(index),
        };
        rate.is_some_and(|rate| (*rate > 0.0) == (direction == Direction::Rises))
    }

    /// Begins the multiplier of a bound that is taken in: at 0, or at `weight` if it had been given up.
    pub(super) fn begin(&mut self, change: Change, rows: &Rows, weight: f32) -> Direction {
        match change {
            Change::Input(index, _) => set(&mut self.inputs, index, 0.0),
            Change::Row(index, _) if rows.get(index) != Row::Loose => {
                set(&mut self.rows, index, weight);
                return Direction::Falls;
            }
            Change::Row(index, _) => set(&mut self.rows, index, 0.0),
        }
        Direction::Rises
    }

    /// Where multipliers, moving from here by `rate(now, towards)` each, first reach an end of their range; none if
    /// none does before `step`.
    pub(super) fn first_blocking<I>(
        &self,
        (pattern, held_count, rows): (&Pattern<M, I>, usize, &Rows),
        weight: f32,
        towards: &Self,
        mut step: f32,
        rate: impl Fn(f32, f32) -> f32,
    ) -> Option<Blocking> {
        let mut change = None;
        let inputs = pattern.held.iter().take(held_count).zip(self.inputs.iter().zip(&towards.inputs));
        for (index, (held, (now, aim))) in inputs.enumerate() {
            let rate = rate(*now, *aim);
            // written without the division, which few need
            if now + step * rate < 0.0 && *held != Held::Free {
                step = -now / rate;
                change = Some(Change::Input(index, Held::Free));
            }
        }
        for index in rows.held() {
            let (Some(now), Some(aim)) = (self.rows.get(index), towards.rows.get(index)) else { continue };
            let rate = rate(*now, *aim);
            let there = now + step * rate;
            if there < 0.0 {
                step = -now / rate;
                change = Some(Change::Row(index, Row::Loose));
            } else if there > weight {
                step = (weight - now) / rate;
                change = Some(Change::Row(index, rows.get(index).given_up()));
            }
        }
        change.map(|change| Blocking { step, change })
    }

    /// Moves the multipliers.
    pub(super) fn walk(&mut self, rows: &Rows, towards: &Self, step: f32, rate: impl Fn(f32, f32) -> f32) {
        let walk = |(now, aim): (&mut f32, &f32)| {
            let moved = *now + step * rate(*now, *aim);
            // rounding may end a hair below zero
            *now = if moved > 0.0 { moved } else { 0.0 };
        };
        self.inputs.iter_mut().zip(&towards.inputs).for_each(walk);
        for index in rows.held() {
            self.rows.get_mut(index).zip(towards.rows.get(index)).into_iter().for_each(walk);
        }
    }

    /// Lets go of every held input whose multiplier would be negative a quarter of the way to `towards`; returns the
    /// number of stages up to the last of them.
    pub(super) fn let_go_near<I>(&self, pattern: &mut Pattern<M, I>, held_count: usize, towards: &Self) -> usize {
        let mut changed = 0;
        let stages = pattern.held.iter_mut().take(held_count).zip(self.inputs.iter().zip(&towards.inputs));
        for (place, (held, (now, aim))) in (1..).zip(stages) {
            if *held != Held::Free && 3.0 * now + aim < 0.0 {
                *held = Held::Free;
                changed = place;
            }
        }
        changed
    }

    /// Lets go of every bound whose multiplier is out of range, and gives up those above the weight; returns the number
    /// of stages up to the last that changed, or none if nothing did.
    pub(super) fn drop_wrong<I>(
        &self,
        pattern: &mut Pattern<M, I>,
        held_count: usize,
        rows: &mut Rows,
        weight: f32,
    ) -> Option<usize> {
        let mut changed = None;
        for index in rows.held() {
            let multiplier = self.rows.get(index).copied().unwrap_or(0.0);
            if multiplier < 0.0 {
                rows.set(index, Row::Loose);
                changed = Some(0);
            } else if multiplier > weight {
                let row = rows.get(index);
                rows.set(index, row.given_up());
                changed = Some(0);
            }
        }
        let stages = pattern.held.iter_mut().take(held_count).zip(&self.inputs);
        for (place, (held, multiplier)) in (1..).zip(stages) {
            if *held != Held::Free && *multiplier < 0.0 {
                *held = Held::Free;
                changed = Some(place);
            }
        }
        changed
    }
}
