//! Quantiles, and paired bootstrap intervals of their differences (Efron and Tibshirani, An Introduction to the
//! Bootstrap, 1993, chapter 13: percentile interval).

use sil_host::sensors::random::RandomStream;

/// Resamples of an interval.
const RESAMPLES: usize = 10_000;
/// Probability of each tail outside the interval.
const TAIL: f64 = 0.025;

/// A difference with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Of the sample itself.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// The value below which this share lies, between neighbours by linear interpolation; not a number of nothing.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, share)
}

/// The middle value.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// Quantile of `ours` minus the same quantile of `theirs`. The two are paired: a resample takes both values of a draw
/// or neither, so that what makes a draw hard for both does not widen the interval.
pub fn paired_difference(ours: &[f64], theirs: &[f64], share: f64) -> Difference {
    let mut stream = RandomStream::new(0, "bootstrap");
    let count = ours.len().min(theirs.len());
    let (mut a, mut b) = (vec![0.0; count], vec![0.0; count]);
    let mut differences: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            for (a, b) in a.iter_mut().zip(&mut b) {
                let index = ((stream.uniform() * count as f64) as usize).min(count - 1);
                (*a, *b) = (ours[index], theirs[index]);
            }
            quantile(&a, share) - quantile(&b, share)
        })
        .collect();
    differences.sort_by(f64::total_cmp);
    Difference {
        value: quantile(ours, share) - quantile(theirs, share),
        low: quantile_of_sorted(&differences, TAIL),
        high: quantile_of_sorted(&differences, 1.0 - TAIL),
    }
}

fn quantile_of_sorted(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let position = share * last as f64;
    let below = (position as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (position - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_a_few_values() {
        let values = [4.0, 1.0, 3.0, 2.0, 5.0];
        assert_eq!([0.0, 0.25, 0.5, 0.95, 1.0].map(|share| quantile(&values, share)), [1.0, 2.0, 3.0, 4.8, 5.0]);
        assert_eq!(median(&[1.0, 2.0]), 1.5);
        assert!(median(&[]).is_nan());
    }

    /// Pairs that differ by a constant have no uncertainty about it, however much they scatter; unpaired they would.
    #[test]
    fn what_both_share_does_not_widen_the_interval() {
        let mut stream = RandomStream::new(1, "test");
        let theirs: Vec<f64> = (0..100).map(|_| 10.0 * stream.normal()).collect();
        let ours: Vec<f64> = theirs.iter().map(|value| value - 0.5).collect();
        for share in [0.5, 0.95] {
            let difference = paired_difference(&ours, &theirs, share);
            for end in [difference.low, difference.value, difference.high] {
                assert!((end + 0.5).abs() < 1e-12, "{difference:?}");
            }
        }
    }

    /// The median of n normal values has the standard error 1.2533 / sqrt(n).
    #[test]
    fn the_interval_is_as_wide_as_theory_has_it() {
        let mut stream = RandomStream::new(2, "test");
        let ours: Vec<f64> = (0..2000).map(|_| stream.normal()).collect();
        let difference = paired_difference(&ours, &vec![0.0; ours.len()], 0.5);
        let expected = 2.0 * 1.96 * 1.2533 / (ours.len() as f64).sqrt();
        // a bootstrap of a median depends on the density of this one sample: a fifth
        assert!(((difference.high - difference.low) / expected - 1.0).abs() < 0.2, "{difference:?}");
    }
}
