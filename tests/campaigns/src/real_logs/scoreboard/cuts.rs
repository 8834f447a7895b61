//! Parts of a log: the stretches that can be predicted, two halves of them, and the same log cut in another way.

use sil_host::log::Log;

/// How many other cuts of a log are tried.
pub const CUTS: usize = 8;
/// From cut to cut the windows' grid moves by an eighth of a window, s.
const SHIFT_S: f64 = 0.0625;
/// A shorter stretch holds no window of 0.5 s with the 50 ms before it, s.
const STRETCH_MIN_S: f64 = 0.56;
/// Halves part between two stretches where one ends within this share of the time from the middle.
const BETWEEN_STRETCHES: f64 = 0.1;

/// A span of time: from, to, s.
pub type Span = [f64; 2];

/// Stretches without a gap in which the motors run and that are long enough for a window.
pub fn usable(log: &Log) -> Vec<Span> {
    let active = log.active_rows();
    long_enough(spans_of(log, |row| active[row]))
}

/// Stretches without a gap of rows that are wanted.
pub fn spans_of(log: &Log, is_wanted: impl Fn(usize) -> bool) -> Vec<Span> {
    let longest_step_s = log.longest_regular_step_s();
    let mut spans: Vec<Span> = Vec::new();
    let mut last_row = None;
    for row in (0..log.rows()).filter(|row| is_wanted(*row)) {
        let time_s = log.time_s[row];
        let goes_on =
            last_row.is_some_and(|last: usize| last + 1 == row && time_s - log.time_s[last] <= longest_step_s);
        match spans.last_mut() {
            Some(span) if goes_on => span[1] = time_s,
            _ => spans.push([time_s, time_s]),
        }
        last_row = Some(row);
    }
    spans
}

/// Both halves of the manoeuvres: parted where half of the turning is over, or between two stretches where that is
/// near. Halves of the time may have all manoeuvres on one side, and the other says nothing.
pub fn halves(log: &Log, spans: &[Span]) -> [Vec<Span>; 2] {
    let whole_s = total_s(spans);
    let half_s = turning_half_over(log, spans);
    let ends_s = spans.iter().scan(0.0, |end_s, [from, to]| {
        *end_s += to - from;
        Some(*end_s)
    });
    let from_half_s = |end_s: &f64| (end_s - half_s).abs();
    let between = ends_s.filter(|end_s| from_half_s(end_s) <= BETWEEN_STRETCHES * whole_s);
    let middle_s = between.min_by(|a, b| from_half_s(a).total_cmp(&from_half_s(b))).unwrap_or(half_s);
    [part(spans, [0.0, middle_s]), part(spans, [middle_s, whole_s])]
}

/// The time, of what the spans have together, at which half of the squared rates (of each axis in units of its mean)
/// are over, s; half of the time of a log without rates.
fn turning_half_over(log: &Log, spans: &[Span]) -> f64 {
    let rows: Vec<usize> =
        (0..log.rows()).filter(|row| spans.iter().any(|span| is_in(span, log.time_s[*row]))).collect();
    let mut turning = vec![0.0; rows.len()];
    for rate in log.rate_rad_s.iter().flatten() {
        let mean = rows.iter().map(|row| rate[*row] * rate[*row]).sum::<f64>() / rows.len().max(1) as f64;
        if mean > 0.0 {
            rows.iter().zip(&mut turning).for_each(|(row, sum)| *sum += rate[*row] * rate[*row] / mean);
        }
    }
    let whole: f64 = turning.iter().sum();
    let mut over = 0.0;
    let middle = turning.iter().position(|turning| {
        over += turning;
        over > 0.5 * whole
    });
    let Some(at_s) = middle.map(|place| log.time_s[rows[place]]) else { return 0.5 * total_s(spans) };
    spans.iter().map(|[from, to]| (at_s.min(*to) - from).max(0.0)).sum()
}

fn is_in([from, to]: &Span, time_s: f64) -> bool {
    (*from..=*to).contains(&time_s)
}

/// Cut number 0 to 7: every stretch begins some eighths of a window later, and an eighth of the time is left out.
pub fn shifted(spans: &[Span], cut: usize) -> Vec<Span> {
    let later: Vec<Span> = spans.iter().map(|[from, to]| [from + SHIFT_S * cut as f64, *to]).collect();
    let later = long_enough(later);
    let eighth_s = total_s(&later) / CUTS as f64;
    let (out_from_s, out_to_s) = (eighth_s * cut as f64, eighth_s * (cut + 1) as f64);
    let mut kept = part(&later, [0.0, out_from_s]);
    kept.extend(part(&later, [out_to_s, f64::INFINITY]));
    kept
}

/// What of the spans lies between two points of the time that they have together, s.
fn part(spans: &[Span], [from_s, to_s]: [f64; 2]) -> Vec<Span> {
    let mut before_s = 0.0;
    let mut parts = Vec::new();
    for [first, last] in spans {
        let from = first + (from_s - before_s).max(0.0);
        let to = last.min(first + to_s - before_s);
        before_s += last - first;
        parts.push([from, to]);
    }
    long_enough(parts)
}

fn long_enough(mut spans: Vec<Span>) -> Vec<Span> {
    spans.retain(|[from, to]| to - from >= STRETCH_MIN_S);
    spans
}

fn total_s(spans: &[Span]) -> f64 {
    spans.iter().map(|[from, to]| to - from).sum()
}

#[cfg(test)]
mod tests {
    use sil_host::log::{Quantity, Threshold};

    use super::*;

    #[test]
    fn what_is_usable_has_running_motors_and_no_gap() {
        let time_s: Vec<f64> = (0..1000).map(|row| 0.01 * f64::from(row) + if row < 600 { 0.0 } else { 1.0 }).collect();
        let thrust = (0..1000).map(|row| if (100..900).contains(&row) { 0.5 } else { 0.0 }).collect();
        let active_when = Some(Threshold { quantity: Quantity::Thrust, above: 0.0 });
        let log = Log { time_s, thrust_command: Some(thrust), active_when, ..Log::default() };
        let spans = usable(&log);
        let near = |a: Span, b: Span| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        assert_eq!(spans.len(), 2);
        assert!(near(spans[0], [1.0, 5.99]) && near(spans[1], [7.0, 9.99]), "{spans:?}");
    }

    #[test]
    fn halves_have_half_of_the_turning_each_and_part_between_stretches() {
        let log = |rate: &dyn Fn(f64) -> f64| {
            let time_s: Vec<f64> = (0..2500).map(|row| 0.01 * f64::from(row)).collect();
            let rate_rad_s = [None, Some(time_s.iter().map(|time_s| rate(*time_s)).collect()), None];
            Log { time_s, rate_rad_s, ..Log::default() }
        };
        let parted_at = |rate: &dyn Fn(f64) -> f64, spans: &[Span]| {
            let [first, second] = halves(&log(rate), spans);
            (first.last().unwrap()[1], second[0][0])
        };
        let even = |_| 1.0;
        // two doublets late in the log: one in each half
        let late = |time_s: f64| if (6.0..7.0).contains(&time_s) || (8.0..9.0).contains(&time_s) { 1.0 } else { 0.0 };
        let (end, begin) = parted_at(&late, &[[0.0, 10.0]]);
        assert!((6.9..=8.1).contains(&end) && (begin - end).abs() < 1e-9, "{end}");
        let (end, begin) = parted_at(&even, &[[0.0, 10.0]]);
        assert!((end - 5.0).abs() < 0.02 && (begin - end).abs() < 1e-9, "{end}");
        assert_eq!(parted_at(&even, &[[4.5, 11.0], [18.0, 25.0]]), (11.0, 18.0));
    }

    #[test]
    fn of_many_short_stretches_the_one_that_ends_nearest_to_the_middle_ends_the_first_half() {
        let time_s: Vec<f64> = (0..2500).map(|row| 0.01 * f64::from(row)).collect();
        let log = Log { rate_rad_s: [None, Some(vec![1.0; 2500]), None], time_s, ..Log::default() };
        let spans: Vec<Span> = (0..24).map(|second| [f64::from(second), f64::from(second) + 0.9]).collect();
        let [first, second] = halves(&log, &spans);
        assert_eq!((first.len(), second.len()), (12, 12));
    }

    #[test]
    fn cuts_move_the_grid_and_leave_out_an_eighth_each() {
        let spans = [[0.0, 8.0], [10.0, 18.0]];
        assert_eq!(shifted(&spans, 0), [[2.0, 8.0], [10.0, 18.0]]);
        // each stretch begins 0.1875 s later; of 15.625 s the eighth from 5.859 to 7.8125, which is the first one's end
        assert_eq!(shifted(&spans, 3), [[0.1875, 6.046875], [10.1875, 18.0]]);
        assert_eq!(shifted(&spans, 7).last().unwrap()[1], 18.0 - (16.0 - 0.875) / 8.0);
        for cut in 0..CUTS {
            let left_s = 16.0 - 2.0 * SHIFT_S * cut as f64;
            assert!((total_s(&shifted(&spans, cut)) - 0.875 * left_s).abs() < 1e-9, "{cut}");
        }
    }
}
