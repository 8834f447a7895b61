//! How fast a column changes: a velocity where a log has the place only.

/// Half the time over which a change is taken, s: a vehicle's velocity hardly changes within a tenth of a second, and
/// what a millimetre of noise makes of it is a hundredth of a metre per second.
const HALF_S: f64 = 0.05;
/// A row this much further away is rounding of a time, s.
const ROUNDING_S: f64 = 1e-6;

/// Change of the readings per second, taken over a tenth of a second about each, less at the ends; NaN where a reading
/// is missing, and where there is but one.
pub(super) fn rate_of_change(time_s: &[f64], readings: &[f64]) -> Vec<f64> {
    let known: Vec<(f64, f64)> =
        time_s.iter().copied().zip(readings.iter().copied()).filter(|(_, reading)| reading.is_finite()).collect();
    let rate_at = |at_s: f64| {
        let last = known.len().saturating_sub(1);
        let from = known.partition_point(|(time_s, _)| *time_s < at_s - HALF_S - ROUNDING_S).min(last);
        let to = known.partition_point(|(time_s, _)| *time_s <= at_s + HALF_S + ROUNDING_S).saturating_sub(1);
        // readings further apart than that: from the one before to the one after
        let (from, to) = if from < to { (from, to) } else { (to.saturating_sub(1), last.min(to + 1)) };
        match (known.get(from), known.get(to)) {
            (Some((from_s, from)), Some((to_s, to))) if to_s > from_s => (to - from) / (to_s - from_s),
            _ => f64::NAN,
        }
    };
    let of_row = |(at_s, reading): (&f64, &f64)| if reading.is_finite() { rate_at(*at_s) } else { f64::NAN };
    time_s.iter().zip(readings).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_changes_by_its_slope_and_its_ends_by_what_is_there() {
        let time_s: Vec<f64> = (0..50).map(|row| 0.01 * f64::from(row)).collect();
        let place: Vec<f64> = time_s.iter().map(|t| 3.0 * t * t).collect();
        let rate = rate_of_change(&time_s, &place);
        // of a parabola a difference about a point is exact
        for row in 6..44 {
            assert!((rate[row] - 6.0 * time_s[row]).abs() < 1e-9, "{row}: {}", rate[row]);
        }
        // at the first row only what follows is there: the slope of 25 ms later
        assert!((rate[0] - 6.0 * 0.025).abs() < 0.02, "{}", rate[0]);
    }

    #[test]
    fn missing_readings_stay_missing_and_slow_ones_have_their_neighbours() {
        let time_s = [0.0, 0.2, 0.4, 0.6, 0.8];
        let rate = rate_of_change(&time_s, &[0.0, 1.0, f64::NAN, 3.0, 5.0]);
        assert!(rate[2].is_nan());
        let expected = [5.0, 5.0, f64::NAN, 4.0 / 0.6, 10.0];
        for row in [0, 1, 3, 4] {
            assert!((rate[row] - expected[row]).abs() < 1e-9, "{row}: {}", rate[row]);
        }
        assert!(rate_of_change(&[1.0], &[2.0])[0].is_nan());
    }
}
