//! Two records of one flight: by two loggers, or the same log after its unit, its calibration or its time were changed.
//! Gusts and manoeuvres are in both, so that spreads between flights say nothing of what they differ by: only what was
//! recorded differently does.

use std::iter::once;

use crate::axis::Axis;
use crate::log::{Log, Quantity};

/// Times of rows that are as near as this are one time, in steps of the log.
const SAME_TIME: f64 = 1e-2;
/// Share of the shorter record's rows that both have.
const COMMON_MIN: f64 = 0.8;
/// Root mean square of the differences of a column that is one, written with other digits, over its own deviation.
const SAME_COLUMN: f64 = 1e-2;
/// Share of the rows in which noise changes a column: constants and scripted steps are alike in any two flights.
const CHANGING_MIN: f64 = 0.3;

/// Both records at the rows that both have, where they are of one flight: a measured column, or a command that a
/// controller makes of those, is the same in both.
pub(super) fn aligned(log: &Log, other: &Log) -> Option<[Log; 2]> {
    let (own, others) = common_rows(log, other);
    let shorter = log.rows().min(other.rows()) as f64;
    if own.is_empty() || (own.len() as f64) < COMMON_MIN * shorter {
        return None;
    }
    let is_one = |quantity: Quantity| {
        let (Some(ours), Some(theirs)) = (log.column(quantity), other.column(quantity)) else { return false };
        let ours: Vec<f64> = own.iter().map(|row| ours[*row]).collect();
        let mean = ours.iter().sum::<f64>() / ours.len() as f64;
        let changing = ours.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64;
        let squares: f64 = ours.iter().map(|value| (value - mean).powi(2)).sum();
        let differences: f64 = ours.iter().zip(&others).map(|(ours, row)| (ours - theirs[*row]).powi(2)).sum();
        changing > CHANGING_MIN * ours.len() as f64 && differences <= SAME_COLUMN.powi(2) * squares
    };
    if !columns().any(is_one) {
        return None;
    }
    let at = |log: &Log, rows: &[usize]| log.within(&spans_s(log, rows)).ok();
    Some([at(log, &own)?, at(other, &others)?])
}

/// What noise is in.
fn columns() -> impl Iterator<Item = Quantity> {
    let of_axes = Axis::ALL.into_iter().flat_map(|axis| {
        let measured = [Quantity::Rate(axis), Quantity::Angle(axis), Quantity::Accel(axis), Quantity::Velocity(axis)];
        measured.into_iter().chain(once(Quantity::Command(axis)))
    });
    of_axes.chain((0..4).map(Quantity::Motor)).chain(once(Quantity::Height))
}

/// The rows of both logs whose times are the same.
fn common_rows(log: &Log, other: &Log) -> (Vec<usize>, Vec<usize>) {
    let near_s = SAME_TIME * log.median_step_s();
    let (mut own, mut others) = (Vec::new(), Vec::new());
    let (mut here, mut there) = (0, 0);
    while here < log.rows() && there < other.rows() {
        let later_s = log.time_s[here] - other.time_s[there];
        if later_s.abs() <= near_s {
            own.push(here);
            others.push(there);
        }
        here += usize::from(later_s <= near_s);
        there += usize::from(later_s >= -near_s);
    }
    (own, others)
}

/// The times of some rows, neighbours together.
fn spans_s(log: &Log, rows: &[usize]) -> Vec<[f64; 2]> {
    let mut spans: Vec<(usize, usize)> = Vec::new();
    for row in rows {
        match spans.last_mut() {
            Some((_, last)) if *last + 1 == *row => *last = *row,
            _ => spans.push((*row, *row)),
        }
    }
    spans.into_iter().map(|(first, last)| [log.time_s[first], log.time_s[last]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// 4 s at 100 Hz: a gyro with noise, and steps of a command that a script gives.
    fn log(seed: u64) -> Log {
        let mut random = RandomStream::new(seed, "flights");
        Log {
            time_s: (0..400).map(|row| f64::from(row) * 0.01).collect(),
            rate_rad_s: [Some((0..400).map(|_| random.normal()).collect()), None, None],
            axis_command: [Some((0..400).map(|row| f64::from(row / 50 % 2)).collect()), None, None],
            ..Log::default()
        }
    }

    #[test]
    fn another_record_of_a_flight_is_recognised_at_the_rows_that_both_have() {
        let mut changed = log(1);
        changed.axis_command[0].iter_mut().flatten().for_each(|command| *command *= 0.75);
        // written with three decimals
        changed.rate_rad_s[0].iter_mut().flatten().for_each(|rate| *rate = (1e3 * *rate).round() / 1e3);
        let part = changed.within(&[[0.1, 2.0], [2.5, 3.8]]).unwrap();
        let [own, other] = aligned(&part, &log(1)).unwrap();
        assert_eq!((own.rows(), &own.time_s), (part.rows(), &other.time_s));
    }

    #[test]
    fn two_flights_of_one_script_are_two() {
        assert!(aligned(&log(1), &log(2)).is_none());
        let mut later = log(1);
        later.time_s.iter_mut().for_each(|time_s| *time_s += 0.004);
        assert!(aligned(&later, &log(1)).is_none());
    }
}
