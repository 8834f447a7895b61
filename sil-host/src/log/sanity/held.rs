//! A command is in force from its row to the next: its mean over a span that begins and ends between rows is exact.

use std::ops::Range;

/// A command and its integral over time.
pub(super) struct Held<'l> {
    time_s: &'l [f64],
    command: Vec<f64>,
    /// Up to each row.
    integral: Vec<f64>,
}

impl<'l> Held<'l> {
    pub(super) fn new(time_s: &'l [f64], command: Vec<f64>) -> Held<'l> {
        let mut integral = vec![0.0; command.len()];
        for row in 1..command.len() {
            integral[row] = integral[row - 1] + command[row - 1] * (time_s[row] - time_s[row - 1]);
        }
        Held { time_s, command, integral }
    }

    /// Mean over each span of time that lies within its rows, between which there is no gap; NaN for others. Spans are
    /// in the order of time.
    pub(super) fn means(&self, spans: impl Iterator<Item = Option<Span>>) -> Vec<f64> {
        let mut at_row = [0; 2];
        spans
            .map(|span| {
                let Some(Span { s: [from_s, to_s], rows }) = span else { return f64::NAN };
                let is_within = |s: f64| self.time_s[rows.start] <= s && s <= self.time_s[rows.end - 1];
                if !is_within(from_s) || !is_within(to_s) {
                    return f64::NAN;
                }
                let area = self.integral_to(&mut at_row[1], to_s) - self.integral_to(&mut at_row[0], from_s);
                area / (to_s - from_s)
            })
            .collect()
    }

    /// The integral up to a time, from the row that an earlier time was in.
    fn integral_to(&self, row: &mut usize, at_s: f64) -> f64 {
        while self.time_s.get(*row + 1).is_some_and(|next_s| *next_s <= at_s) {
            *row += 1;
        }
        self.integral[*row] + self.command[*row] * (at_s - self.time_s[*row])
    }
}

/// A span of time, and the rows without a gap that it must lie in.
pub(super) struct Span {
    pub(super) s: [f64; 2],
    pub(super) rows: Range<usize>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_counts_each_command_for_as_long_as_it_is_in_force() {
        // rows come unevenly, and there is a gap after the fourth
        let time_s = [0.0, 0.010, 0.024, 0.030, 1.0, 1.01];
        let held = Held::new(&time_s, vec![1.0, 3.0, -2.0, 7.0, 5.0, 9.0]);
        let [first, second] = [0..4, 4..6];
        let span = |s: [f64; 2], rows: &Range<usize>| Some(Span { s, rows: rows.clone() });
        let spans = [
            span([0.004, 0.010], &first),
            span([0.006, 0.026], &first),
            span([0.020, 0.031], &first),
            None,
            span([0.995, 1.005], &second),
            span([1.002, 1.006], &second),
        ];
        let means = held.means(spans.into_iter());
        assert!((means[0] - 1.0).abs() < 1e-12);
        assert!((means[1] - (4.0 * 1.0 + 14.0 * 3.0 - 2.0 * 2.0) / 20.0).abs() < 1e-9, "{means:?}");
        assert!(means[2].is_nan() && means[3].is_nan() && means[4].is_nan());
        assert!((means[5] - 5.0).abs() < 1e-9, "{means:?}");
    }
}
