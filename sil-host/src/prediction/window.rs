//! Which rows are predicted: windows of 0.5 s in which the motors run and no row is missing.

use super::error::NotPredictable;
use crate::log::Log;

/// Length of a window, s.
pub const WINDOW_S: f64 = 0.5;

/// Rows this long before and after a start serve to find the state at the start, s (docs/commands.md: at most 50 ms
/// before).
const START_REACH_S: f64 = 0.05;

/// Fewer rows say nothing about a window.
const ROWS_MIN: usize = 5;

/// One stretch of rows that is predicted from its own start state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Number among the windows of the log, from 0.
    pub index: usize,
    /// First row used to find the state at the start.
    pub lead: usize,
    /// The row at which the prediction starts.
    pub start: usize,
    /// The row after the last one used to find the start state.
    pub tail: usize,
    /// The row after the last one that is compared; the next window starts there.
    pub end: usize,
    /// What it serves.
    pub part: Part,
}

/// What a window serves: no window that a model was fitted to, or chosen by, is in a figure that is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Numbers are fitted to it: half of the windows.
    Fit,
    /// It decides which effects are in the model: a quarter.
    Choice,
    /// Errors are reported of it: a quarter.
    Report,
}

/// Cuts the log into windows, one behind the other. Neither a gap nor a row with standing motors lies within a window
/// or within the rows that its start state comes from.
///
/// # Errors
/// The rows are too far apart, or there is no window at all.
pub(crate) fn windows(log: &Log) -> Result<Vec<Window>, NotPredictable> {
    let step_s = log.median_step_s();
    if step_s * ROWS_MIN as f64 > WINDOW_S {
        return Err(NotPredictable::TooSlow { step_s, window_s: WINDOW_S, rows_min: ROWS_MIN });
    }
    let mut windows = Vec::new();
    for (first, end) in stretches(log) {
        cut(&log.time_s, first, end, 0.5 * step_s, &mut windows);
    }
    if windows.is_empty() {
        return Err(NotPredictable::NoWindow { window_s: WINDOW_S, rows: log.rows(), duration_s: log.duration_s() });
    }
    Ok(windows)
}

/// Runs of rows (first, one past the last) without a gap in time in which the motors run.
pub(super) fn stretches(log: &Log) -> Vec<(usize, usize)> {
    let active = log.active_rows();
    let longest_regular_s = log.longest_regular_step_s();
    let mut stretches = Vec::new();
    let mut first = 0;
    for row in 0..log.rows() {
        if !active[row] {
            first = row + 1;
            continue;
        }
        let ends = match log.time_s.get(row + 1) {
            Some(next_s) => !active[row + 1] || next_s - log.time_s[row] > longest_regular_s,
            None => true,
        };
        if ends {
            stretches.push((first, row + 1));
            first = row + 1;
        }
    }
    stretches
}

/// All windows of one stretch; times count as equal within `tolerance_s`, half a step.
fn cut(time_s: &[f64], first: usize, end: usize, tolerance_s: f64, windows: &mut Vec<Window>) {
    let row_at = |from: usize, at_s: f64| (from..end).find(|row| time_s[*row] >= at_s - tolerance_s);
    let Some(mut start) = row_at(first, time_s[first] + START_REACH_S) else {
        return;
    };
    // the row that ends a window must be there: its command is in force up to it
    while let Some(window_end) = row_at(start, time_s[start] + WINDOW_S) {
        if window_end - start >= ROWS_MIN {
            let index = windows.len();
            windows.push(Window { index, part: part(index), ..Window::between(time_s, first, start, window_end) });
        }
        start = window_end;
    }
}

/// Which windows serve what. Every second one in the order of Thue and Morse is fitted, two in each four; the others
/// part as the sequence of Rudin and Shapiro says. Neither has a period: with every second window a disturbance of 1 Hz
/// would push all fitted windows one way, and all others the other. The sequences are entered where three windows have
/// all three.
fn part(index: usize) -> Part {
    let place = index + 204;
    let pairs_of_ones = (place & (place >> 1)).count_ones();
    match (place.count_ones() % 2, pairs_of_ones % 2) {
        (0, _) => Part::Fit,
        (_, 0) => Part::Choice,
        _ => Part::Report,
    }
}

impl Window {
    /// A window over these rows, the first of its kind; rows from `earliest` on may serve to find its start.
    fn between(time_s: &[f64], earliest: usize, start: usize, end: usize) -> Window {
        let (start_s, reach_s) = (time_s[start], START_REACH_S + 1e-9);
        let lead = (earliest..=start).find(|row| time_s[*row] >= start_s - reach_s).unwrap_or(start);
        let tail = (start..end).find(|row| time_s[*row] > start_s + reach_s).unwrap_or(end);
        Window { index: 0, lead, start, tail, end, part: Part::Fit }
    }

    /// Windows of another length over the same rows, end to end from the first one's start to the last one's end; `run`
    /// are windows that follow each other without a gap. Empty where the rows are too few.
    pub(crate) fn of_length(time_s: &[f64], run: &[Window], length_s: f64) -> Vec<Window> {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return Vec::new() };
        let tolerance_s = 0.5 * (time_s[last.end] - time_s[first.start]) / (last.end - first.start) as f64;
        let row_at = |from: usize, at_s: f64| (from..=last.end).find(|row| time_s[*row] >= at_s - tolerance_s);
        let mut windows = Vec::new();
        let mut start = first.start;
        while let Some(end) = row_at(start, time_s[start] + length_s) {
            if end - start < ROWS_MIN {
                return Vec::new();
            }
            windows.push(Window { part: first.part, ..Window::between(time_s, first.lead, start, end) });
            start = end;
        }
        windows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{Quantity, Threshold};

    fn log_at(time_s: Vec<f64>) -> Log {
        Log { time_s, ..Log::default() }
    }

    #[test]
    fn regular_rows_give_windows_end_to_end_with_50_ms_around_each_start() {
        let log = log_at((0..1001).map(|row| f64::from(row) * 0.004).collect());
        let windows = windows(&log).unwrap();
        // 4 s less the 50 ms before the first start
        assert_eq!(windows.len(), 7);
        for (index, window) in windows.iter().enumerate() {
            // the twelfth row of 4 ms is the nearest to 50 ms
            assert_eq!(window.start, 12 + 125 * index);
            assert_eq!(window.end, window.start + 125);
            assert_eq!((window.lead, window.tail), (window.start - 12, window.start + 13));
            use Part::{Choice, Fit, Report};
            assert_eq!(window.part, [Fit, Choice, Report, Fit, Report, Fit, Fit][index]);
        }
    }

    #[test]
    fn no_periodic_moment_pushes_the_fitted_windows_one_way_and_the_others_another() {
        // mean of a sine over each window of 0.5 s; phase and frequency that part the halves most
        let worst = |part: fn(usize) -> Part| {
            let mut worst = 0.0_f64;
            for (step, phase) in (1..80).flat_map(|step| [0.0, 0.25].map(|phase| (step, phase))) {
                let turns = |window: f64| f64::from(step) * 0.05 * 0.5 * window + phase;
                let cosine = |window: f64| libm::cos(core::f64::consts::TAU * turns(window));
                let mean = |of: Part| -> f64 {
                    let windows: Vec<usize> = (0..120).filter(|window| part(*window) == of).collect();
                    windows.iter().map(|window| cosine(*window as f64 + 0.5)).sum::<f64>() / windows.len() as f64
                };
                let [fit, choice, report] = [Part::Fit, Part::Choice, Part::Report].map(mean);
                worst = worst.max((fit - choice).abs()).max((fit - report).abs());
            }
            worst
        };
        let alternating = |window: usize| [Part::Fit, Part::Choice, Part::Fit, Part::Report][window % 4];
        assert!(worst(alternating) > 1.9);
        assert!(worst(part) < 0.9, "{}", worst(part));
        let count = |of: Part| (0..120).filter(|window| part(*window) == of).count();
        assert_eq!([Part::Fit, Part::Choice, Part::Report].map(count), [60, 33, 27]);
    }

    #[test]
    fn the_same_rows_give_windows_of_other_lengths() {
        let log = log_at((0..1001).map(|row| f64::from(row) * 0.004).collect());
        let windows = windows(&log).unwrap();
        let fifths = Window::of_length(&log.time_s, &windows[1..2], 0.1);
        assert_eq!(fifths.len(), 5);
        assert_eq!((fifths[0].start, fifths[4].end), (windows[1].start, windows[1].end));
        assert!(fifths.iter().all(|fifth| fifth.end - fifth.start == 25 && fifth.part == Part::Choice));
        assert_eq!((fifths[1].lead, fifths[1].tail), (fifths[1].start - 12, fifths[1].start + 13));
        // seven windows of 0.5 s hold one of 2 s, and a start without rows before it keeps what is there
        let long = Window::of_length(&log.time_s, &windows, 2.0);
        assert_eq!(long.iter().map(|window| (window.start, window.end)).collect::<Vec<_>>(), [(12, 512)]);
        assert!(Window::of_length(&log.time_s, &windows, 0.01).is_empty());
        assert!(Window::of_length(&log.time_s, &[], 0.1).is_empty());
    }

    #[test]
    fn no_window_holds_a_gap_or_a_row_with_standing_motors() {
        let mut time_s = 0.0;
        let jitter = |row: u32| 0.004 * (1.0 + 0.4 * f64::from(row % 7) / 7.0);
        let times: Vec<f64> = (0..2000)
            .map(|row| {
                time_s += if row == 700 { 0.07 } else { jitter(row) };
                time_s
            })
            .collect();
        let mut log = log_at(times);
        let stands = |row: usize| (1200..1300).contains(&row);
        log.thrust_command = Some((0..2000).map(|row| if stands(row) { 0.0 } else { 0.3 }).collect());
        log.active_when = Some(Threshold { quantity: Quantity::Thrust, above: 0.0 });
        let windows = windows(&log).unwrap();
        assert!(windows.len() > 10);
        for window in &windows {
            assert!(window.end <= 700 || window.lead >= 700, "{window:?}");
            assert!(window.end <= 1200 || window.lead >= 1300, "{window:?}");
            let length_s = log.time_s[window.end] - log.time_s[window.start];
            assert!((length_s - WINDOW_S).abs() <= 0.003, "{length_s}");
            let before_s = log.time_s[window.start] - log.time_s[window.lead];
            assert!((0.04..=0.05 + 1e-9).contains(&before_s), "{before_s}");
        }
    }

    #[test]
    fn slow_and_standing_logs_are_refused() {
        let slow = log_at((0..200).map(|row| f64::from(row) * 0.2).collect());
        assert!(matches!(windows(&slow), Err(NotPredictable::TooSlow { .. })));
        let mut standing = log_at((0..1000).map(|row| f64::from(row) * 0.01).collect());
        standing.thrust_command = Some(vec![0.0; 1000]);
        standing.active_when = Some(Threshold { quantity: Quantity::Thrust, above: 0.0 });
        assert!(matches!(windows(&standing), Err(NotPredictable::NoWindow { .. })));
    }
}
