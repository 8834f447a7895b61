//! Time in minutes under a name that says seconds. Such a log seems sixty times as short and as fast as it is: a flight
//! of half a minute is over in half a second, too short for the means that the other checks take, and a minute differs
//! little from the 57.3 by which degrees differ from radians. So it is recognised row by row, and by a rate of rows
//! that hardly any logger reaches.

use super::super::Log;
use super::super::contradiction::Contradiction;
use super::super::quantity::Quantity;
use super::finding::Columns;
use crate::axis::Axis;

const MINUTE_S: f64 = 60.0;
/// 25 rows a true second; of what seems faster hardly any is a log of degrees that are labelled as radians.
const SEEMING_ROWS_PER_S: f64 = 25.0 * MINUTE_S;
/// Turns are compared over so many rows, so that an attitude's noise has little part in them.
const SPAN_ROWS: usize = 8;
/// The rate must explain so much of the turns.
const EXPLAINED_MIN: f64 = 0.7;
/// By how much a wrong scale of the gyro may be added to the factor of a minute.
const FACTOR_MIN: f64 = MINUTE_S / 1.5;
const FACTOR_MAX: f64 = MINUTE_S * 1.5;
/// Slower turns than this, as the log has them, are noise, rad/s.
const RATE_RMS_MIN_RAD_S: f64 = 0.02;

/// The contradiction, where roll and pitch turn sixty times as fast as their rates say, each of them that turns at all.
pub(super) fn contradiction(log: &Log, columns: &Columns<'_>) -> Option<Contradiction> {
    let seeming_hz = 1.0 / log.mean_regular_step_s();
    if seeming_hz < SEEMING_ROWS_PER_S {
        return None;
    }
    let factors: Vec<(Axis, f64)> =
        [Axis::Roll, Axis::Pitch].into_iter().filter_map(|axis| Some((axis, factor(log, axis)?))).collect();
    let is_a_minute = |(_, factor): &(Axis, f64)| (FACTOR_MIN..=FACTOR_MAX).contains(factor);
    let (axis, factor) = *factors.first().filter(|_| factors.iter().all(is_a_minute))?;
    let (angle, rate) = (columns.called(Quantity::Angle(axis)), columns.called(Quantity::Rate(axis)));
    Some(Contradiction {
        seen: format!(
            "{} gives {seeming_hz:.0} rows per second over {:.1} s, and {angle} turns {factor:.0} times as fast as \
             {rate} says",
            columns.called(Quantity::Time),
            log.duration_s()
        ),
        likely: "the time is likely in minutes".to_owned(),
        map_lines: vec![columns.line("time_min", Quantity::Time, 1.0)],
        ..Contradiction::default()
    })
}

/// How many times as fast as its rate an angle turns; none where the log does not tell.
fn factor(log: &Log, axis: Axis) -> Option<f64> {
    let (angle, rate) = (log.column(Quantity::Angle(axis))?, log.column(Quantity::Rate(axis))?);
    let longest_s = log.longest_regular_step_s();
    let (mut by_rate, mut squares, mut turns, mut spans, mut seen_s) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for first in (0..log.rows().saturating_sub(SPAN_ROWS)).step_by(SPAN_ROWS) {
        let rows = first..first + SPAN_ROWS;
        let step_s = |row: usize| log.time_s[row + 1] - log.time_s[row];
        if rows.clone().any(|row| step_s(row) > longest_s) {
            continue;
        }
        let expected: f64 = rows.clone().map(|row| step_s(row) * 0.5 * (rate[row] + rate[row + 1])).sum();
        let turned = angle[rows.end] - angle[rows.start];
        by_rate += expected * turned;
        squares += expected * expected;
        turns += turned * turned;
        spans += 1.0;
        seen_s += log.time_s[rows.end] - log.time_s[rows.start];
    }
    // root mean square of the rate, from that of the expected turns
    let rate_rad_s = (squares / spans).sqrt() / (seen_s / spans);
    let is_explained = by_rate > 0.0 && by_rate * by_rate >= EXPLAINED_MIN * squares * turns;
    (is_explained && rate_rad_s >= RATE_RMS_MIN_RAD_S).then(|| by_rate / squares)
}
