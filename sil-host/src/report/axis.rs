//! One axis of a chart: the range of values it shows, and round numbers along it.

use std::ops::RangeInclusive;

/// Values beyond this are treated like infinities: the difference of two of them could overflow.
const LARGEST: f64 = 1e150;

/// Below this fraction of their magnitude, differences between values are rounding: the values count as constant.
const SMALLEST_RELATIVE_SPAN: f64 = 1e-9;

/// Whether a chart can show this value; NaN, infinities and absurdly large values it can't.
pub(super) fn is_plottable(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// The least and the greatest plottable value, or `None` if there is none.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|&value| is_plottable(value)).fold(None, |extent, value| match extent {
        None => Some((value, value)),
        Some((low, high)) => Some((low.min(value), high.max(value))),
    })
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    /// Shows `low..=high` (plottable values) with about `tick_count` ticks; a range of zero is widened around its
    /// value.
    pub(super) fn new((low, high): (f64, f64), tick_count: u32) -> Self {
        let magnitude = low.abs().max(high.abs());
        let (low, high) = if high - low > SMALLEST_RELATIVE_SPAN * magnitude {
            (low, high)
        } else {
            let margin = if magnitude > 0.0 { 0.1 * magnitude } else { 1.0 };
            (low - margin, high + margin)
        };
        Self { low, high, step: round_step((high - low) / f64::from(tick_count)) }
    }

    /// The same with a margin of 5 % at both ends, so that curves stay clear of the frame.
    pub(super) fn with_margin(extent: (f64, f64), tick_count: u32) -> Self {
        let tight = Self::new(extent, tick_count);
        let margin = 0.05 * (tight.high - tight.low);
        Self { low: tight.low - margin, high: tight.high + margin, step: tight.step }
    }

    /// The same for labels with one digit more.
    pub(super) fn finer(&self) -> Self {
        Self { step: self.step / 10.0, ..*self }
    }

    pub(super) fn range(&self) -> RangeInclusive<f64> {
        self.low..=self.high
    }

    /// Where a plottable value lies: 0 at the low end, 1 at the high end; values outside are moved to the nearer end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// The round values within the range, ascending.
    pub(super) fn ticks(&self) -> Vec<f64> {
        // A log of 30 s ends at 29.9975 s: a tick just outside (1 % of a step) is shown at the end.
        let first = (self.low / self.step - 0.01).ceil() as i64;
        let last = (self.high / self.step + 0.01).floor() as i64;
        (first..=last).map(|index| index as f64 * self.step).collect()
    }

    /// The value with as many digits as the distance of the ticks calls for, and a true minus sign.
    pub(super) fn label(&self, value: f64) -> String {
        let step_exponent = decimal_exponent(self.step);
        let largest_exponent = decimal_exponent(self.low.abs().max(self.high.abs()));
        let is_scientific = step_exponent < -5 || largest_exponent > 5;
        let text = if is_scientific && value == 0.0 {
            "0".to_owned()
        } else if is_scientific {
            let decimals = (decimal_exponent(value) - step_exponent).clamp(0, 9);
            format!("{value:.*e}", decimals.unsigned_abs() as usize)
        } else {
            format!("{value:.*}", step_exponent.min(0).unsigned_abs() as usize)
        };
        with_minus_sign(&text)
    }
}

/// Sets a typographic minus for the hyphen of machines, and drops the sign of a zero.
pub(super) fn with_minus_sign(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(digits) if digits.chars().all(|digit| matches!(digit, '0' | '.')) => digits.to_owned(),
        _ => number.replace('-', "\u{2212}"),
    }
}

/// The number of the form 1, 2 or 5 times a power of ten that is nearest to `rough` in ratio.
fn round_step(rough: f64) -> f64 {
    let power = libm::pow(10.0, f64::from(decimal_exponent(rough)));
    let leading = rough / power;
    // The limits are the geometric means of neighbours: sqrt(1 * 2), sqrt(2 * 5), sqrt(5 * 10).
    let rounded = if leading < 1.414 {
        1.0
    } else if leading < 3.162 {
        2.0
    } else if leading < 7.071 {
        5.0
    } else {
        10.0
    };
    rounded * power
}

/// The exponent in scientific notation; 0 for 0. A step such as 0.1 may be stored a little low, hence the small
/// addition.
fn decimal_exponent(value: f64) -> i32 {
    if value == 0.0 { 0 } else { (libm::log10(value.abs()) + 1e-9).floor() as i32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ticks_are_round_and_labelled_without_noise() {
        let labels = |range, count| {
            let axis = Axis::new(range, count);
            axis.ticks().into_iter().map(|tick| axis.label(tick)).collect::<Vec<_>>()
        };
        assert_eq!(labels((0.0, 29.9975), 6), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(labels((-17.0, 16.0), 5), ["−15", "−10", "−5", "0", "5", "10", "15"]);
        assert_eq!(labels((0.0, 0.32), 3), ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(labels((-1e-7, 2.1e-7), 3), ["−1e−7", "0", "1e−7", "2e−7"]);
        assert_eq!(labels((0.0, 2e6), 4), ["0", "5e5", "1.0e6", "1.5e6", "2.0e6"]);
    }

    #[test]
    fn a_range_of_zero_is_widened_around_its_value() {
        assert_eq!(Axis::new((0.0, 0.0), 5).range(), -1.0..=1.0);
        assert_eq!(Axis::new((-20.0, -20.0), 5).range(), -22.0..=-18.0);
        assert_eq!(Axis::new((3.0, 3.0), 5).fraction(3.0), 0.5);
    }

    #[test]
    fn the_sign_of_zero_is_dropped() {
        assert_eq!(with_minus_sign("-0.00"), "0.00");
        assert_eq!(with_minus_sign("-0.01"), "−0.01");
    }

    #[test]
    fn extent_ignores_what_cannot_be_drawn() {
        assert_eq!(extent([f64::NAN, 2.0, f64::INFINITY, -1.0, 1e200]), Some((-1.0, 2.0)));
        assert_eq!(extent([f64::NAN]), None);
        assert_eq!(extent([]), None);
    }

    proptest! {
        #[test]
        fn any_range_has_a_few_distinct_ticks_inside(
            first in -1e150..1e150_f64, exponent in -300..0, offset in -1.0..1.0_f64, count in 3..8_u32,
        ) {
            let second = first + offset * first.abs() * 10_f64.powi(exponent);
            let axis = Axis::new((first.min(second), first.max(second)), count);
            let ticks = axis.ticks();
            // Rounding the step to 1, 2, 5 changes the count by a factor of at most sqrt(5/2); both ends may add one.
            prop_assert!(!ticks.is_empty() && ticks.len() <= 2 * count as usize + 2, "{} ticks", ticks.len());
            prop_assert!(ticks.windows(2).all(|pair| pair[0] < pair[1]));
            prop_assert!(ticks.iter().all(|&tick| (0.0..=1.0).contains(&axis.fraction(tick))));
            prop_assert!(ticks.iter().all(|&tick| !axis.label(tick).is_empty()));
        }
    }
}
