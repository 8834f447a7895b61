//! How far series are off: the thesis' measure of a simulated closed loop, table 5.1 (the mean absolute deviation from
//! the measured angle), and the variance.

use std::f64::consts::{PI, TAU};

/// Mean of |a - b| over the rows, in the unit of both; the difference of two angles in rad is taken the short way
/// round. `None` if there are no rows or the lengths differ.
pub fn mean_absolute_deviation(a_rad: &[f64], b_rad: &[f64]) -> Option<f64> {
    if a_rad.is_empty() || a_rad.len() != b_rad.len() {
        return None;
    }
    let sum: f64 = a_rad.iter().zip(b_rad).map(|(a, b)| wrapped(a - b).abs()).sum();
    Some(sum / a_rad.len() as f64)
}

/// Mean square of what values differ from their mean by; 0 of none.
pub(crate) fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / count
}

/// The same angle in [-pi, pi).
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    if (-PI..PI).contains(&angle_rad) {
        return angle_rad;
    }
    angle_rad - TAU * ((angle_rad + PI) / TAU).floor()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_mean_distance_the_short_way_round() {
        assert_eq!(mean_absolute_deviation(&[0.5, -0.25], &[0.25, 0.0]), Some(0.25));
        let across_the_cut = mean_absolute_deviation(&[PI - 0.1], &[-PI + 0.1]).unwrap();
        // 2 pi is rounded to 4.4e-16
        assert!((across_the_cut - 0.2).abs() < 1e-15);
        assert_eq!(variance([1.0, 3.0, 1.0, 3.0].into_iter()), 1.0);
        assert_eq!(variance(std::iter::empty()), 0.0);
        assert_eq!(mean_absolute_deviation(&[], &[]), None);
        assert_eq!(mean_absolute_deviation(&[1.0], &[1.0, 2.0]), None);
    }
}
