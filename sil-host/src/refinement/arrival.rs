//! Times of rows that were sampled evenly and stamped when they arrived.
//!
//! A stand's telemetry is stamped by a computer's clock, in bundles as the operating system hands them over: the times
//! jump by 16 ms and stand still between. A row can be late and never early, so the earliest of the rows that follow
//! within a short while, less as many periods, is when it was sampled. Where rows were lost, all that follow are late
//! for good, and the gap remains.

use crate::statistics::median;

/// Rows over which the period is measured, at most: few enough for most spans to be without a loss.
const SPAN_ROWS: usize = 200;
/// Rows within which one comes without delay: longer than any bundle of the stands that were seen (6 rows).
const WINDOW_ROWS: usize = 30;
/// Half a day, in s: a step back by more is midnight.
const HALF_DAY_S: f64 = 43_200.0;
/// A gap of more periods is worth a note.
const GAP_PERIODS: f64 = 3.0;

/// When rows were sampled, from 0 on, by when they arrived (s), and what should be known of it.
///
/// # Errors
/// The clock runs back, or does not run.
pub(super) fn sampled(arrived_s: &[f64]) -> Result<(Vec<f64>, Vec<String>), String> {
    let Some(first) = arrived_s.first().copied() else { return Ok((Vec::new(), Vec::new())) };
    let (mut time_s, mut days_s) = (Vec::with_capacity(arrived_s.len()), 0.0);
    for (row, arrived) in arrived_s.iter().enumerate() {
        let before = time_s.last().copied().unwrap_or(0.0);
        if arrived - first + days_s < before - HALF_DAY_S {
            days_s += 2.0 * HALF_DAY_S;
        }
        let now = arrived - first + days_s;
        if now < before {
            return Err(format!("the clock runs back at row {}", row + 1));
        }
        time_s.push(now);
    }
    let span = SPAN_ROWS.min(time_s.len() - 1).max(1);
    let steps = time_s.windows(span + 1).map(|part| (part[span] - part[0]) / span as f64).collect();
    let period_s = median(steps);
    if period_s.is_nan() || period_s <= 0.0 {
        return Err("the clock does not run".to_owned());
    }
    let late = |row: usize| time_s[row] - row as f64 * period_s;
    let earliest = |row: usize| {
        let end = (row + WINDOW_ROWS).min(time_s.len());
        (row..end).map(late).fold(f64::INFINITY, f64::min)
    };
    let sampled_s: Vec<f64> = (0..time_s.len()).map(|row| row as f64 * period_s + earliest(row)).collect();
    let gaps = sampled_s.windows(2).filter(|pair| pair[1] - pair[0] > GAP_PERIODS * period_s).count();
    let mut note =
        format!("rows every {:.2} ms, by the rows' order; the clock's times come in bundles", 1e3 * period_s);
    if gaps > 0 {
        note += &format!("; {gaps} gaps where rows are missing");
    }
    let begin = sampled_s.first().copied().unwrap_or(0.0);
    Ok((sampled_s.into_iter().map(|time| time - begin).collect(), vec![note]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1000 rows of 10 ms, handed over every 16 ms; 18 rows lost in the middle.
    #[test]
    fn bundles_are_undone_and_losses_remain() {
        let true_s: Vec<f64> =
            (0..1018).filter(|row| !(500..518).contains(row)).map(|row| 0.01 * f64::from(row)).collect();
        let arrived_s: Vec<f64> = true_s.iter().map(|time| 67_000.0 + (time / 0.016).ceil() * 0.016).collect();
        let (sampled_s, notes) = sampled(&arrived_s).unwrap();
        // less than half a row: none is taken for its neighbour, and none of the lost ones for another; the last bundle
        // has no later row to be measured by
        for (sampled, truth) in sampled_s.iter().zip(&true_s).take(true_s.len() - WINDOW_ROWS) {
            assert!((sampled - truth).abs() < 5e-3, "{sampled} {truth}");
        }
        assert!(notes[0].contains("10.00 ms") && notes[0].contains("1 gaps"), "{notes:?}");
    }

    #[test]
    fn midnight_is_no_step_back() {
        let arrived_s: Vec<f64> = (0..100).map(|row| (86_399.5 + 0.01 * f64::from(row)) % 86_400.0).collect();
        let (sampled_s, _) = sampled(&arrived_s).unwrap();
        assert!((sampled_s[99] - 0.99).abs() < 1e-6, "{}", sampled_s[99]);
        assert!(sampled(&[5.0, 6.0, 4.0]).is_err());
        assert!(sampled(&[5.0, 5.0, 5.0]).is_err());
    }
}
