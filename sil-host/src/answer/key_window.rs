//! The one picture of a page: measured, and predicted by each model, in the window that shows it best.

use crate::report::Chart;

/// Of what is before and behind the window, so much is shown, s.
const AROUND_S: f64 = 0.5;

/// A channel window by window, in one unit; NaN in the gaps between windows.
pub struct Predicted<'a> {
    /// Title and unit of the picture.
    pub title: String,
    /// Unit of all values.
    pub unit: String,
    /// Times, s.
    pub time_s: &'a [f64],
    /// Measured values in the windows.
    pub measured: &'a [f64],
    /// All that was measured, window or not: times and values; empty where the log has no such column.
    pub all: (&'a [f64], Vec<f64>),
    /// Measured less predicted, of each model by its name.
    pub errors: Vec<(&'static str, &'a [f64])>,
}

impl Predicted<'_> {
    /// The picture of one window; none without a window.
    pub fn picture(&self) -> Option<Chart> {
        let window = self.best()?;
        let time_s = &self.time_s[window.clone()];
        let (from_s, to_s) = (time_s[0], time_s[time_s.len() - 1]);
        let chart = Chart::time_series(&self.title, &self.unit).span(from_s, to_s, "predicted from the commands alone");
        let around = (from_s - AROUND_S)..=(to_s + AROUND_S);
        let (times, values) = &self.all;
        let (near_s, near): (Vec<f64>, Vec<f64>) =
            times.iter().zip(values).filter(|(time_s, _)| around.contains(time_s)).map(|(t, v)| (*t, *v)).unzip();
        let chart = if near.is_empty() {
            chart.series("measured", time_s, &self.measured[window.clone()])
        } else {
            chart.series("measured", &near_s, &near)
        };
        Some(self.errors.iter().fold(chart, |chart, (name, errors)| {
            let errors = &errors[window.clone()];
            let predicted: Vec<f64> = self.measured[window.clone()].iter().zip(errors).map(|(m, e)| m - e).collect();
            chart.series(*name, time_s, &predicted)
        }))
    }

    /// Where the first model's error exceeds the last one's most; of one model, where it is largest.
    fn best(&self) -> Option<std::ops::Range<usize>> {
        let (_, first) = self.errors.first()?;
        let last = self.errors.last().filter(|_| self.errors.len() > 1).map(|(_, last)| *last);
        let square = |errors: &[f64]| errors.iter().map(|error| error * error).sum::<f64>();
        let excess = |window: &std::ops::Range<usize>| {
            square(&first[window.clone()]) - last.map_or(0.0, |last| square(&last[window.clone()]))
        };
        let windows = windows(self.time_s).into_iter().filter(|window| window.len() > 2);
        windows.max_by(|a, b| excess(a).total_cmp(&excess(b)))
    }
}

/// The stretches between gaps.
fn windows(time_s: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut windows = Vec::new();
    let mut start = 0;
    for end in (0..=time_s.len()).filter(|&end| time_s.get(end).is_none_or(|time| time.is_nan())) {
        if end > start {
            windows.push(start..end);
        }
        start = end + 1;
    }
    windows
}

/// The times around the largest step of references that hold their values: a little before it, and until the next
/// step or two seconds behind it; none where nothing steps.
pub fn largest_step(time_s: &[f64], references: &[&[f64]]) -> Option<(usize, [f64; 2])> {
    const BEFORE_S: f64 = 0.2;
    const BEHIND_S: f64 = 2.0;
    let steps = |reference: &&[f64]| -> Vec<(usize, f64)> {
        (1..reference.len().min(time_s.len()))
            .map(|row| (row, (reference[row] - reference[row - 1]).abs()))
            .filter(|(_, size)| *size > 1e-6)
            .collect()
    };
    let all = references.iter().enumerate().flat_map(|(axis, of)| steps(of).into_iter().map(move |step| (axis, step)));
    // the first of several of one size
    let (axis, (row, _)) = all.reduce(|best, one| if one.1.1 > best.1.1 * (1.0 + 1e-9) { one } else { best })?;
    let next = steps(&references[axis]).into_iter().find(|(other, _)| *other > row).map(|(other, _)| time_s[other]);
    let end_s = next.unwrap_or(f64::INFINITY).min(time_s[row] + BEHIND_S);
    Some((axis, [time_s[row] - BEFORE_S, end_s]))
}

/// The rows of a series within times.
pub fn cut(time_s: &[f64], values: &[f64], [from_s, to_s]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
    let pairs = time_s.iter().zip(values).filter(|(time, _)| (from_s..to_s).contains(*time));
    pairs.map(|(time, value)| (*time, *value)).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_is_where_the_models_differ_most() {
        let gap = f64::NAN;
        let time_s = [0.0, 0.1, 0.2, gap, 1.0, 1.1, 1.2, gap, 2.0, 2.1, 2.2, gap];
        let measured = [0.0; 12];
        let nominal = [5.0, 5.0, 5.0, gap, 1.0, 2.0, 3.0, gap, 0.1, 0.1, 0.1, gap];
        let extended = [5.0, 5.0, 5.0, gap, 0.0, 0.0, 0.0, gap, 0.1, 0.1, 0.1, gap];
        let of = |errors| Predicted {
            title: String::new(),
            unit: String::new(),
            time_s: &time_s,
            measured: &measured,
            all: (&[], Vec::new()),
            errors,
        };
        assert_eq!(of(vec![("nominal", &nominal[..]), ("extended", &extended)]).best(), Some(4..7));
        assert_eq!(of(vec![("nominal", &nominal[..])]).best(), Some(0..3));
        assert_eq!(of(Vec::new()).best(), None);
    }

    #[test]
    fn the_largest_step_ends_before_the_next() {
        let time_s: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.1).collect();
        let small: Vec<f64> = time_s.iter().map(|t| if *t > 1.0 { 0.1 } else { 0.0 }).collect();
        let large: Vec<f64> = time_s.iter().map(|t| if (3.0..4.0).contains(t) { 0.5 } else { 0.0 }).collect();
        let (axis, [from_s, to_s]) = largest_step(&time_s, &[&small, &large]).unwrap();
        assert_eq!(axis, 1);
        assert!((from_s - 2.8).abs() < 0.11 && (to_s - 4.0).abs() < 0.11, "{from_s} {to_s}");
        assert_eq!(largest_step(&time_s, &[&[0.3; 100]]), None);
    }
}
