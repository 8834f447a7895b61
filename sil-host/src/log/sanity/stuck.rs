//! Readings that stand still while the vehicle moves: a sensor's reading that never changes, or stops changing, while
//! what it should follow moves as much as ever; and a log in which from some time on nothing changes any more.

use std::ops::Range;

use super::super::Log;
use super::super::contradiction::Contradiction;
use super::super::quantity::Quantity;
use super::super::runs::runs;
use super::finding::Columns;
use crate::axis::Axis;
use crate::statistics::variance;

/// A shorter stretch is a radio's or a logger's hiccup, s.
const STRETCH_MIN_S: f64 = 0.5;
/// Fewer rows than this may be a slower rate's.
const ROWS_MIN: usize = 20;
/// What moves half as much as elsewhere has not come to rest.
const MOVES: f64 = 0.5;
/// A log in which something changes from row to row but for so many of them has noise in it.
const NOISE_ROWS: usize = 5;

/// Everything that stands still where it can't.
pub(super) fn contradictions(log: &Log, columns: &Columns<'_>) -> Vec<Contradiction> {
    if let Some(all) = everything(log) {
        return vec![all];
    }
    let pairs = Axis::ALL[..2].iter().flat_map(|axis| {
        let (angle, rate) = (Quantity::Angle(*axis), Quantity::Rate(*axis));
        [(rate, angle), (angle, rate), (rate, Quantity::Command(*axis))]
    });
    pairs.filter_map(|(stuck, moving)| one(log, stuck, moving, columns)).chain(motor(log, columns)).collect()
}

/// A motor's command that never changes while those of all the others do: no controller of a vehicle does that, and on
/// a bench of one axis two motors rest.
fn motor(log: &Log, columns: &Columns<'_>) -> Option<Contradiction> {
    let motors = log.motors()?;
    let still: Vec<usize> = (0..4).filter(|motor| is_still(motors[*motor])).collect();
    let [stuck] = still[..] else { return None };
    Some(Contradiction {
        seen: format!(
            "{} stays at {} in all the log while the other motors' commands change",
            columns.called(Quantity::Motor(stuck)),
            rounded(motors[stuck][0])
        ),
        likely:
            "its command was likely not logged, another column is it, or it was at its limit all the time, as in a \
                 vehicle that tips over"
                .to_owned(),
        ..Contradiction::default()
    })
}

/// As many digits as a reader compares.
fn rounded(value: f64) -> f64 {
    (1e4 * value).round() / 1e4
}

/// Do all values stay at the first one?
pub(super) fn is_still(values: &[f64]) -> bool {
    values.iter().all(|value| *value == values[0])
}

/// A quantity that stands still while another one moves.
fn one(log: &Log, stuck: Quantity, moving: Quantity, columns: &Columns<'_>) -> Option<Contradiction> {
    let (values, other) = (log.column(stuck)?, log.column(moving)?);
    let runs = runs(log.rows(), |row| values[row] == values[row - 1]);
    let longest = runs.iter().max_by_key(|run| run.len())?.clone();
    let usual = runs.iter().filter(|run| **run != longest).map(Range::len).max().unwrap_or(1);
    let long_s = log.time_s[longest.end - 1] - log.time_s[longest.start];
    // a channel that is written at a slower rate repeats itself all the time
    if long_s < STRETCH_MIN_S || longest.len() < ROWS_MIN.max(4 * usual) {
        return None;
    }
    let is_whole = longest.len() == log.rows();
    let inside = variance(other[longest.clone()].iter().copied()).sqrt();
    let outside = variance(other[..longest.start].iter().chain(&other[longest.end..]).copied()).sqrt();
    let moves = inside > 0.0 && (is_whole || inside > MOVES * outside);
    moves.then(|| Contradiction {
        seen: format!(
            "{} stays at {} from {:.2} s to {:.2} s while {} moves",
            columns.called(stuck),
            rounded(values[longest.start]),
            log.time_s[longest.start],
            log.time_s[longest.end - 1],
            columns.called(moving)
        ),
        likely: if is_whole {
            "no such reading was likely logged: leave the column out (a map without it)".to_owned()
        } else {
            "the sensor or its logging likely stopped: cut the log there (--from, --to)".to_owned()
        },
        leave_out: if is_whole { vec![stuck] } else { Vec::new() },
        ..Contradiction::default()
    })
}

/// A log of noisy readings none of which changes any more.
fn everything(log: &Log) -> Option<Contradiction> {
    let is_measured = |quantity: &&Quantity| {
        matches!(quantity, Quantity::Angle(_) | Quantity::Rate(_) | Quantity::Accel(_) | Quantity::Rpm(_))
    };
    let measured: Vec<&[f64]> =
        Quantity::ALL.iter().filter(is_measured).filter_map(|quantity| log.column(*quantity)).collect();
    let runs = runs(log.rows(), |row| measured.iter().all(|values| values[row] == values[row - 1]));
    let longest = runs.iter().max_by_key(|run| run.len())?.clone();
    let (from_s, to_s) = (log.time_s[longest.start], log.time_s[longest.end - 1]);
    let is_whole = longest.len() == log.rows();
    let is_noisy = runs.iter().filter(|run| **run != longest).all(|run| run.len() <= NOISE_ROWS);
    if measured.is_empty() || !is_whole && (!is_noisy || to_s - from_s < STRETCH_MIN_S || longest.len() < ROWS_MIN) {
        return None;
    }
    Some(Contradiction {
        seen: format!("no angle, rate or acceleration changes from {from_s:.2} s to {to_s:.2} s"),
        likely: "the log likely froze: cut it there (--from, --to)".to_owned(),
        ..Contradiction::default()
    })
}
