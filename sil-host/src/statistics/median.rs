//! The middle of a series, which a few wild values do not move.

/// The value that half of them do not exceed: of an even number the mean of the two in the middle; NaN without any.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    let (count, middle) = (values.len(), values.len() / 2);
    if count == 0 {
        return f64::NAN;
    }
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    match below.iter().copied().max_by(f64::total_cmp) {
        Some(lower) if count % 2 == 0 => 0.5 * (lower + *upper),
        _ => *upper,
    }
}

/// The usual step from each of some times to the next, in their unit; none of fewer than two.
pub(crate) fn median_step(times: &[f64]) -> Option<f64> {
    (times.len() > 1).then(|| median(times.windows(2).map(|pair| pair[1] - pair[0]).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_found_whatever_the_order_and_number() {
        for (values, expected) in [
            (vec![3.0], 3.0),
            (vec![4.0, 1.0], 2.5),
            (vec![9.0, 1.0, 2.0], 2.0),
            (vec![7.0, 1.0, 100.0, 3.0], 5.0),
            (vec![2.0, 2.0, 2.0, 2.0], 2.0),
        ] {
            assert_eq!(median(values.clone()), expected, "{values:?}");
        }
        assert!(median(Vec::new()).is_nan());
    }

    #[test]
    fn a_gap_among_steps_is_not_usual() {
        assert_eq!(median_step(&[0.0, 1.0, 2.0, 9.0, 10.0]), Some(1.0));
        assert_eq!((median_step(&[5.0]), median_step(&[])), (None, None));
    }
}
