//! Take-off and landing: a vehicle that touches the ground is held by it, and the ground's moments answer to its
//! commands as no vehicle does. Crazyflies of the CrazyPAD logs command 30 % of roll and pitch while they rise from it.
//!
//! The motors carry a vehicle from about the usual collective on. Where a height is logged, it is off the ground once
//! it is [`CLEAR_M`] above where it stood, and up to where it is last as much above where it comes to rest. Without a
//! height it is given [`LEAVING_S`]; not so what turns about some of its axes only, which a rig holds off the ground.

use core::ops::Range;

use crate::log::{Log, Quantity};
use crate::statistics::median;

/// Share of the usual collective at which a vehicle leaves the ground: less a tenth for a battery that is still full.
const LIFTED: f64 = 0.9;
/// Take-off and landing are so short, s: a bench may have no usual collective at all.
const GROUND_MAX_S: f64 = 3.0;
/// Higher than any skid or leg gives way, m.
const CLEAR_M: f64 = 0.1;
/// What a vehicle takes from the collective that carries it to that height, s (0.3 to 0.6 s in CrazyPAD's flights).
const LEAVING_S: f64 = 0.5;

/// A flight's rows without take-off and landing; a flight that goes on beyond the log has none there.
pub(super) fn off_the_ground(log: &Log, collective: &[f64], usual: f64, rows: Range<usize>) -> Range<usize> {
    let is_up = |row: &usize| collective[*row] >= LIFTED * usual;
    let is_short = |from: usize, to: usize| log.time_s[to] - log.time_s[from] <= GROUND_MAX_S;
    let first = rows.clone().find(is_up).filter(|first| rows.start > 0 && is_short(rows.start, *first));
    let last = rows.clone().rev().find(is_up).filter(|last| rows.end < log.rows() && is_short(*last, rows.end - 1));
    let start = first.map_or(rows.start, |first| left(log, first, rows.end));
    let end = last.map_or(rows.end, |last| reached(log, last, rows.start) + 1);
    if start < end { start..end } else { rows }
}

/// The row at which a vehicle has left the ground that its motors begin to carry at `row`.
fn left(log: &Log, row: usize, end: usize) -> usize {
    let standing = (0..=row).filter(|other| log.time_s[*other] > log.time_s[row] - LEAVING_S);
    clear(log, row..end, standing)
}

/// The last row before a vehicle touches the ground on which its motors cease to carry it at `row`.
fn reached(log: &Log, row: usize, start: usize) -> usize {
    let later_s = |other: usize| log.time_s[other] - log.time_s[row];
    let landed = (row..log.rows()).take_while(|other| later_s(*other) < 2.0 * LEAVING_S);
    let resting = landed.clone().skip(landed.count() / 2);
    clear(log, (start..=row).rev(), resting)
}

/// The first of some rows, which lead away from the ground, that is clear of it, seen from rows on it.
fn clear(log: &Log, rows: impl Iterator<Item = usize> + Clone, on_ground: impl Iterator<Item = usize>) -> usize {
    let first = rows.clone().next().unwrap_or_default();
    let away_s = |row: usize| (log.time_s[row] - log.time_s[first]).abs();
    let leaving_s = if log.axes == [true; 3] { LEAVING_S } else { 0.0 };
    let by_time = || rows.clone().find(|row| away_s(*row) >= leaving_s).or(rows.clone().last()).unwrap_or_default();
    let Some(height) = log.column(Quantity::Height) else { return by_time() };
    let clear_m = median(on_ground.map(|row| height[row]).collect()) + CLEAR_M;
    let near = rows.clone().take_while(|row| away_s(*row) <= GROUND_MAX_S);
    match near.clone().filter(|row| height[*row] <= clear_m).last() {
        Some(low) if Some(low) == near.clone().last() => by_time(),
        Some(low) => near.skip_while(|row| *row != low).nth(1).unwrap_or(low),
        None => first,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.02;

    /// 3 s of idle, 10 s of flight at 1 m with a climb of 0.5 m/s that begins a second after the motors carry, the same
    /// down, 3 s of idle.
    fn hop(ground_m: f64) -> (Log, Vec<f64>) {
        let time_s: Vec<f64> = (0..800).map(|row| STEP_S * f64::from(row)).collect();
        let carries = |t: &f64| (3.0..13.0).contains(t);
        let height = |t: &f64| ground_m + (0.5 * (t - 4.0)).min(0.5 * (12.0 - t)).clamp(0.0, 1.0);
        let collective = time_s.iter().map(|t| if carries(t) { 0.6 } else { 0.1 }).collect();
        let height = time_s.iter().map(height).collect();
        (Log { axes: [true; 3], height_m: Some(height), time_s, ..Log::default() }, collective)
    }

    fn span(log: &Log, collective: &[f64]) -> [f64; 2] {
        let rows = off_the_ground(log, collective, 0.6, 150..650);
        [log.time_s[rows.start], log.time_s[rows.end - 1]]
    }

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1.5 * STEP_S)
    }

    #[test]
    fn a_vehicle_flies_while_it_is_above_the_ground_wherever_that_is() {
        for ground_m in [0.0, 3.7, -1.0] {
            let (log, collective) = hop(ground_m);
            // 0.1 m of a climb of 0.5 m/s
            assert!(near(span(&log, &collective), [4.2, 11.8]), "{:?}", span(&log, &collective));
        }
    }

    #[test]
    fn without_a_height_it_is_given_half_a_second() {
        let (log, collective) = hop(0.0);
        let log = Log { height_m: None, ..log };
        assert!(near(span(&log, &collective), [3.5, 12.48]), "{:?}", span(&log, &collective));
        // a height that does not move is that of a stand
        let log = Log { height_m: Some(vec![0.3; log.rows()]), ..log };
        assert!(near(span(&log, &collective), [3.5, 12.48]), "{:?}", span(&log, &collective));
        let of_bench = Log { axes: [false, true, false], ..log };
        assert!(near(span(&of_bench, &collective), [3.0, 12.98]), "{:?}", span(&of_bench, &collective));
    }

    #[test]
    fn a_log_that_begins_and_ends_in_the_air_is_all_flight() {
        let (log, collective) = hop(0.0);
        let rows = 250..560;
        let part = log.within(&[[log.time_s[rows.start], log.time_s[rows.end - 1]]]).unwrap();
        let all = off_the_ground(&part, &collective[rows.clone()], 0.6, 0..part.rows());
        assert_eq!(all, 0..rows.len());
    }
}
