//! Which rows are predicted: windows of 0.5 s in which the motors run and no row is missing, but for pauses.

use super::error::NotPredictable;
use crate::log::Log;
use crate::statistics::variance;

/// Length of a window, s.
pub const WINDOW_S: f64 = 0.5;

/// Rows this long before and after a start serve to find the state at the start, s (docs/commands.md: at most 50 ms
/// before).
const START_REACH_S: f64 = 0.05;

/// What was commanded before a stretch of rows is unknown: motors and delayed commands have forgotten it after so long,
/// s.
const UNKNOWN_BEFORE_S: f64 = 0.25;

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
    /// Nothing: enough others of a long log are fitted.
    Spare,
}

/// Groups of four windows of which numbers are fitted to two: a minute. More of a longer log would cost time and tell
/// little.
const FOURS_FITTED: usize = 30;

/// Cuts the log into windows, one behind the other. Neither a gap longer than a pause nor a row with standing motors
/// lies within a window or within the rows that its start state comes from.
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
    share_out(log, &mut windows);
    if !log.active_rows().contains(&true) {
        return Err(NotPredictable::MotorsStand { rows: log.rows(), duration_s: log.duration_s() });
    }
    if windows.is_empty() {
        return Err(NotPredictable::NoWindow { window_s: WINDOW_S, rows: log.rows(), duration_s: log.duration_s() });
    }
    Ok(windows)
}

/// Runs of rows (first, one past the last) without a gap in time in which the motors run.
pub(super) fn stretches(log: &Log) -> Vec<(usize, usize)> {
    let active = log.active_rows();
    let longest_uncut_s = log.longest_uncut_step_s();
    let mut stretches = Vec::new();
    let mut first = 0;
    for row in 0..log.rows() {
        if !active[row] {
            first = row + 1;
            continue;
        }
        let ends = match log.time_s.get(row + 1) {
            Some(next_s) => !active[row + 1] || next_s - log.time_s[row] > longest_uncut_s,
            None => true,
        };
        if ends {
            stretches.push((first, row + 1));
            first = row + 1;
        }
    }
    stretches
}

/// Another cut of a log: an eighth of its time is left out, from cut to cut another part, and the windows' grid is
/// moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cut {
    /// From 0.
    pub(crate) number: usize,
    /// Cuts in all.
    pub(crate) of: usize,
}

/// Share of a log's time that is left out.
const LEFT_OUT: f64 = 0.125;

impl Cut {
    /// What is left of a log; none where that is no log any more.
    pub(crate) fn of(&self, log: &Log) -> Option<Log> {
        let place = (self.number as f64 + 0.5) / self.of as f64;
        let (mut is_left, mut runs) = (vec![true; log.rows()], Vec::new());
        for (first, end) in stretches(log) {
            let begin_s = log.time_s[first] + place * WINDOW_S;
            let begin = (first..end).find(|row| log.time_s[*row] >= begin_s).unwrap_or(end);
            is_left[first..begin].fill(false);
            runs.extend(begin..end);
        }
        let (from, count) = ((place * runs.len() as f64) as usize, (LEFT_OUT * runs.len() as f64) as usize);
        (from..from + count).for_each(|number| is_left[runs[number % runs.len()]] = false);
        log.only(|row| is_left[row])
    }
}

/// All windows of one stretch; times count as equal within `tolerance_s`, half a step.
fn cut(time_s: &[f64], first: usize, end: usize, tolerance_s: f64, windows: &mut Vec<Window>) {
    let row_at = |from: usize, at_s: f64| (from..end).find(|row| time_s[*row] >= at_s - tolerance_s);
    let Some(mut start) = row_at(first, time_s[first] + UNKNOWN_BEFORE_S) else {
        return;
    };
    // the row that ends a window must be there: its command is in force up to it
    while let Some(window_end) = row_at(start, time_s[start] + WINDOW_S) {
        if window_end - start >= ROWS_MIN {
            let index = windows.len();
            windows.push(Window { index, ..Window::between(time_s, first, start, window_end) });
        }
        start = window_end;
    }
}

/// Which windows serve what: of each four in the order of how much the vehicle turns in them two are fitted, one
/// chooses, one is reported. A manoeuvre or two is often all that a log says of its vehicle, and each part must have
/// its share; windows in which feedback holds the vehicle still show the feedback.
///
/// Which of the four serves what goes by the sequences of Thue and Morse and of Rudin and Shapiro, which have no
/// period: with every second window a disturbance of 1 Hz would push all fitted windows one way, and all others the
/// other. Three windows have all three parts.
fn share_out(log: &Log, windows: &mut [Window]) {
    use Part::{Choice, Fit, Report};
    const OF_FOUR: [[Part; 4]; 4] = [
        [Fit, Choice, Report, Fit],
        [Fit, Report, Choice, Fit],
        [Choice, Fit, Fit, Report],
        [Report, Fit, Fit, Choice],
    ];
    let turning = turning(log, windows);
    let mut order: Vec<usize> = (0..windows.len()).collect();
    order.sort_by(|a, b| turning[*b].total_cmp(&turning[*a]));
    let fours = windows.len().div_ceil(4);
    for (place, window) in order.into_iter().enumerate() {
        let four = place / 4;
        let (ones, pairs_of_ones) = (four.count_ones() % 2, (four & (four >> 1)).count_ones() % 2);
        let part = OF_FOUR[(2 * ones + pairs_of_ones) as usize][place % 4];
        windows[window].part = if part == Report || is_fitted(four, fours) { part } else { Part::Spare };
    }
}

/// Does a group of four, of those in the order of how much the vehicle turns in them, serve fits? Of a long log half of
/// those that do are the first, where the manoeuvres are, and the others lie evenly among the rest.
fn is_fitted(four: usize, of: usize) -> bool {
    let first = FOURS_FITTED / 2;
    if of <= FOURS_FITTED || four < first {
        return true;
    }
    let (behind, rest, wanted) = (four - first, of - first, FOURS_FITTED - first);
    behind * wanted / rest != (behind + 1) * wanted / rest
}

/// How much the vehicle turns in each window: variance of each rate, or else of the angle, in units of its mean over
/// all windows.
fn turning(log: &Log, windows: &[Window]) -> Vec<f64> {
    let mut turning = vec![0.0; windows.len()];
    for axis in 0..3 {
        let Some(column) = log.rate_rad_s[axis].as_ref().or(log.angle_rad[axis].as_ref()) else { continue };
        let variances: Vec<f64> =
            windows.iter().map(|window| variance(column[window.start..window.end].iter().copied())).collect();
        let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
        if mean > 0.0 {
            turning.iter_mut().zip(&variances).for_each(|(sum, variance)| *sum += variance / mean);
        }
    }
    turning
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
        // 4 s less the quarter of a second before the first start
        assert_eq!(windows.len(), 7);
        for (index, window) in windows.iter().enumerate() {
            // rows of 4 ms: the nearest to 0.25 s, and twelve of them to 50 ms
            assert_eq!(window.start, 62 + 125 * index);
            assert_eq!(window.end, window.start + 125);
            assert_eq!((window.lead, window.tail), (window.start - 12, window.start + 13));
            use Part::{Choice, Fit, Report};
            // nothing turns: the first four in order, the next four in another one
            assert_eq!(window.part, [Fit, Choice, Report, Fit, Choice, Fit, Fit][index]);
        }
    }

    /// What windows serve in which the vehicle turns by so much.
    fn parts(turning: &[f64]) -> Vec<Part> {
        let rows = |value: &f64| [*value, -value];
        let log = Log { rate_rad_s: [None, Some(turning.iter().flat_map(rows).collect()), None], ..Log::default() };
        let window = |index: usize| {
            let (start, end) = (2 * index, 2 * index + 2);
            Window { index, lead: start, start, tail: end, end, part: Part::Fit }
        };
        let mut windows: Vec<Window> = (0..turning.len()).map(window).collect();
        share_out(&log, &mut windows);
        windows.iter().map(|window| window.part).collect()
    }

    #[test]
    fn each_part_has_its_share_of_the_manoeuvres() {
        // four manoeuvres in a hundred windows of rest
        let manoeuvres = [20, 21, 60, 90];
        let turning: Vec<f64> = (0..100).map(|i| if manoeuvres.contains(&i) { 5.0 } else { 0.1 }).collect();
        let parts = parts(&turning);
        let count = |of: Part| manoeuvres.iter().filter(|window| parts[**window] == of).count();
        assert_eq!([Part::Fit, Part::Choice, Part::Report].map(count), [2, 1, 1]);
        let count = |of: Part| parts.iter().filter(|part| **part == of).count();
        assert_eq!([Part::Fit, Part::Choice, Part::Report].map(count), [50, 25, 25]);
    }

    #[test]
    fn of_a_long_log_a_minute_is_fitted_manoeuvres_first_and_all_its_quarter_is_reported() {
        // ten minutes, 20 s of manoeuvres in the middle
        let turning: Vec<f64> = (0..1200).map(|i| if (600..640).contains(&i) { 5.0 } else { 0.1 }).collect();
        let parts = parts(&turning);
        let count = |of: Part, among: core::ops::Range<usize>| parts[among].iter().filter(|part| **part == of).count();
        assert_eq!([Part::Fit, Part::Choice, Part::Report].map(|of| count(of, 0..1200)), [60, 30, 300]);
        assert_eq!([Part::Fit, Part::Choice, Part::Report].map(|of| count(of, 600..640)), [20, 10, 10]);
        // rest from the beginning to the end
        assert!((0..4).all(|quarter| count(Part::Fit, 300 * quarter..300 * (quarter + 1)) > 0));
    }

    #[test]
    fn a_cut_leaves_out_an_eighth_and_moves_the_grid() {
        let log = log_at((0..4001).map(|row| f64::from(row) * 0.004).collect());
        let begin_s = |log: &Log| log.time_s[windows(log).unwrap()[0].start];
        let mut begins: Vec<f64> = Vec::new();
        for number in 0..8 {
            let cut = Cut { number, of: 8 }.of(&log).unwrap();
            // 16 s less 2 s, less what does not fill a window on either side of the hole
            let windows = windows(&cut).unwrap();
            assert!((24..=28).contains(&windows.len()), "{number}: {}", windows.len());
            // the rows are the log's own
            assert!(cut.time_s.iter().all(|time_s| log.time_s.contains(time_s)));
            let middle_of_hole_s = (2.0 * (number as f64 + 1.0)) % 16.0;
            let held = |window: &Window| {
                cut.time_s[window.lead] <= middle_of_hole_s && middle_of_hole_s <= cut.time_s[window.end - 1]
            };
            assert!(!windows.iter().any(held), "{number}");
            begins.push(begin_s(&cut));
        }
        begins.sort_by(f64::total_cmp);
        begins.dedup();
        assert!(begins.len() >= 7 && !begins.contains(&begin_s(&log)), "{begins:?}");
    }

    #[test]
    fn no_periodic_moment_pushes_the_fitted_windows_one_way_and_the_others_another() {
        // mean of a sine over each window of 0.5 s; phase and frequency that part the halves most
        let worst = |parts: &[Part]| {
            let mut worst = 0.0_f64;
            for (step, phase) in (1..80).flat_map(|step| [0.0, 0.25].map(|phase| (step, phase))) {
                let turns = |window: f64| f64::from(step) * 0.05 * 0.5 * window + phase;
                let cosine = |window: f64| libm::cos(core::f64::consts::TAU * turns(window));
                let mean = |of: Part| -> f64 {
                    let windows: Vec<usize> = (0..120).filter(|window| parts[*window] == of).collect();
                    windows.iter().map(|window| cosine(*window as f64 + 0.5)).sum::<f64>() / windows.len() as f64
                };
                let [fit, choice, report] = [Part::Fit, Part::Choice, Part::Report].map(mean);
                worst = worst.max((fit - choice).abs()).max((fit - report).abs());
            }
            worst
        };
        let alternating: Vec<Part> =
            (0..120).map(|window| [Part::Fit, Part::Choice, Part::Fit, Part::Report][window % 4]).collect();
        assert!(worst(&alternating) > 1.9);
        // in the order of time, where nothing else orders them
        let alike = parts(&[1.0; 120]);
        assert!(worst(&alike) < 0.9, "{}", worst(&alike));
        let count = |of: Part| alike.iter().filter(|part| **part == of).count();
        assert_eq!([Part::Fit, Part::Choice, Part::Report].map(count), [60, 30, 30]);
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
        assert_eq!(long.iter().map(|window| (window.start, window.end)).collect::<Vec<_>>(), [(62, 562)]);
        assert!(Window::of_length(&log.time_s, &windows, 0.01).is_empty());
        assert!(Window::of_length(&log.time_s, &[], 0.1).is_empty());
    }

    #[test]
    fn a_fast_logs_pauses_cut_no_window_and_longer_gaps_do() {
        // a row each 2 ms, and after each quarter of a second none for so long
        let with = |pause_s: f64| {
            let time_s = |row: u32| 0.002 * f64::from(row) + f64::from(row / 125) * (pause_s - 0.002);
            windows(&log_at((0..5000).map(time_s).collect()))
        };
        assert!(with(0.03).unwrap().len() > 15);
        assert!(with(0.05).is_err());
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
        assert_eq!(windows(&standing), Err(NotPredictable::MotorsStand { rows: 1000, duration_s: 9.99 }));
        // a moment is too short for a window
        standing.thrust_command.as_mut().unwrap()[500..510].fill(0.5);
        assert!(matches!(windows(&standing), Err(NotPredictable::NoWindow { .. })));
    }
}
