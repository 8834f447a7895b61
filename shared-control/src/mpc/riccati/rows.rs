//! Which bounds on the angle are held.

use super::angle_bounds::AngleBounds;
use crate::mpc::HORIZON;

/// What is chosen for the angle after one prediction step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Row {
    /// Its bounds are ignored.
    Loose,
    /// At the upper bound.
    Upper,
    /// At the lower bound.
    Lower,
    /// At or above the upper bound, for which the cost rises with it.
    AboveUpper,
    /// At or below the lower bound.
    BelowLower,
}

impl Row {
    /// The angle that is to be kept.
    #[inline(always)]
    pub(super) fn held<const S: usize>(self, bounds: &AngleBounds<'_, S>) -> Option<f32> {
        match self {
            Self::Upper => Some(bounds.upper),
            Self::Lower => Some(bounds.lower),
            Self::Loose | Self::AboveUpper | Self::BelowLower => None,
        }
    }

    /// Slope of the cost beyond a bound that is given up.
    #[inline(always)]
    pub(super) fn slope<const S: usize>(self, bounds: &AngleBounds<'_, S>) -> f32 {
        match self {
            Self::AboveUpper => bounds.soft.weight,
            Self::BelowLower => -bounds.soft.weight,
            Self::Loose | Self::Upper | Self::Lower => 0.0,
        }
    }

    /// The multiplier of the bound, from that of the angle.
    #[inline(always)]
    pub(super) fn multiplier(self, of_angle: f32) -> f32 {
        if self == Self::Lower { -of_angle } else { of_angle }
    }

    /// What it becomes when its multiplier has reached the greatest one.
    pub(super) fn given_up(self) -> Self {
        match self {
            Self::Upper => Self::AboveUpper,
            Self::Lower => Self::BelowLower,
            other => other,
        }
    }
}

/// The choices for all angles: a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Rows {
    upper: u32,
    lower: u32,
    above: u32,
    below: u32,
}

const _: () = assert!(HORIZON <= 32, "a bit for each angle");

impl Rows {
    /// None is held.
    pub(super) const LOOSE: Self = Self { upper: 0, lower: 0, above: 0, below: 0 };

    pub(super) fn get(&self, index: usize) -> Row {
        let bit = bit(index);
        if self.upper & bit != 0 {
            Row::Upper
        } else if self.lower & bit != 0 {
            Row::Lower
        } else if self.above & bit != 0 {
            Row::AboveUpper
        } else if self.below & bit != 0 {
            Row::BelowLower
        } else {
            Row::Loose
        }
    }

    pub(super) fn set(&mut self, index: usize, row: Row) {
        let bit = bit(index);
        for bits in [&mut self.upper, &mut self.lower, &mut self.above, &mut self.below] {
            *bits &= !bit;
        }
        match row {
            Row::Loose => {}
            Row::Upper => self.upper |= bit,
            Row::Lower => self.lower |= bit,
            Row::AboveUpper => self.above |= bit,
            Row::BelowLower => self.below |= bit,
        }
    }

    /// Whether the angle is held at a bound.
    #[inline(always)]
    pub(super) fn is_held(&self, index: usize) -> bool {
        (self.upper | self.lower) & bit(index) != 0
    }

    /// The angles that are held, the earliest first.
    #[inline(always)]
    pub(super) fn held(&self) -> Indices {
        Indices(self.upper | self.lower)
    }

    #[inline(always)]
    pub(super) fn has_given_up(&self) -> bool {
        self.above | self.below != 0
    }

    /// The angles whose bounds are given up.
    #[inline(always)]
    pub(super) fn given_up(&self) -> Indices {
        Indices(self.above | self.below)
    }
}

/// No bit for what is no angle.
#[inline(always)]
fn bit(index: usize) -> u32 {
    if index < HORIZON { 1 << index } else { 0 }
}

/// Of the bits that are set.
#[derive(Clone, Copy)]
pub(super) struct Indices(u32);

impl Indices {
    pub(super) fn last(self) -> Option<usize> {
        (self.0 != 0).then(|| 31 - self.0.leading_zeros() as usize)
    }
}

impl Iterator for Indices {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let index = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_is_what_it_was_set_to_last() {
        let all = [Row::Upper, Row::Lower, Row::AboveUpper, Row::BelowLower, Row::Loose];
        let mut rows = Rows::LOOSE;
        for first in all {
            for then in all {
                rows.set(7, first);
                rows.set(7, then);
                let is_held = matches!(then, Row::Upper | Row::Lower);
                let is_given_up = matches!(then, Row::AboveUpper | Row::BelowLower);
                assert_eq!((rows.get(7), rows.get(6), rows.get(8)), (then, Row::Loose, Row::Loose));
                assert_eq!((rows.is_held(7), rows.is_held(6), rows.has_given_up()), (is_held, false, is_given_up));
            }
        }
    }

    #[test]
    fn the_angles_held_and_given_up_are_listed_in_their_order() {
        let mut rows = Rows::LOOSE;
        assert!(rows.held().next().is_none() && rows.given_up().last().is_none());
        let choices = [(9, Row::Upper), (0, Row::Lower), (4, Row::AboveUpper), (HORIZON - 1, Row::Upper)];
        for (index, row) in choices.into_iter().chain([(2, Row::BelowLower)]) {
            rows.set(index, row);
        }
        assert!(rows.held().eq([0, 9, HORIZON - 1]) && rows.given_up().eq([2, 4]));
        assert_eq!((rows.held().last(), rows.given_up().last()), (Some(HORIZON - 1), Some(4)));
    }

    #[test]
    fn what_is_no_angle_is_not_held() {
        let mut rows = Rows::LOOSE;
        rows.set(HORIZON, Row::Upper);
        assert_eq!(rows, Rows::LOOSE);
    }
}
