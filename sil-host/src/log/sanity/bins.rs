//! A log in short steps of time: means over its rows, none across a gap, so that logs of any rate are examined alike.

use std::f64::consts::TAU;
use std::ops::Range;

use super::super::Log;
use super::held::Span;
use crate::statistics::wrapped;

/// Means are taken over this or, in slower logs, are the rows: the motion of a vehicle with motors lies below 50 Hz.
const STEP_S: f64 = 0.01;
/// A stretch is at least so long: longer than a vehicle remembers a disturbance, so that stretches are independent.
const STRETCH_MIN_S: f64 = 1.0;
/// More stretches tell no more of the scatter.
const STRETCHES_MAX: usize = 40;
/// Scatter can't be told from fewer.
const STRETCHES_MIN: usize = 6;

/// Rows in groups.
pub(super) struct Bins {
    rows: Vec<Range<usize>>,
    /// Mean time of each group, s.
    time_s: Vec<f64>,
    /// The number of the piece between two gaps that each group lies in.
    piece: Vec<usize>,
    /// The rows of each piece.
    pieces: Vec<Range<usize>>,
    /// Usual time from group to group, s.
    step_s: f64,
    /// A stretch is at least so long, s.
    stretch_s: f64,
}

impl Bins {
    pub(super) fn of(log: &Log) -> Bins {
        let longest_s = log.longest_regular_step_s();
        let (mut rows, mut piece, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
        let (mut from, mut piece_from) = (0, 0);
        for row in 1..=log.rows() {
            let is_gap = row < log.rows() && log.time_s[row] - log.time_s[row - 1] > longest_s;
            // a hundredth of the step for stamps that are rounded
            let is_full = row < log.rows() && log.time_s[row] - log.time_s[from] >= 0.99 * STEP_S;
            if is_gap || is_full || row == log.rows() {
                rows.push(from..row);
                piece.push(pieces.len());
                from = row;
                if is_gap || row == log.rows() {
                    pieces.push(piece_from..row);
                    piece_from = row;
                }
            }
        }
        let step_s = log.mean_regular_step_s().max(STEP_S);
        let mut bins = Bins { rows, time_s: Vec::new(), piece, pieces, step_s, stretch_s: STRETCH_MIN_S };
        bins.time_s = bins.means(&log.time_s);
        let within = (1..bins.rows.len()).filter(|at| bins.piece[*at] == bins.piece[at - 1]);
        let steps_s: Vec<f64> = within.map(|at| bins.time_s[at] - bins.time_s[at - 1]).collect();
        if !steps_s.is_empty() {
            // three rows of 4 ms make a group of 12
            bins.step_s = steps_s.iter().sum::<f64>() / steps_s.len() as f64;
        }
        bins
    }

    /// The same in stretches of half the length: of two records of one flight disturbances drop out, however long a
    /// vehicle remembers them.
    pub(super) fn of_record(log: &Log) -> Bins {
        Bins { stretch_s: 0.5 * STRETCH_MIN_S, ..Bins::of(log) }
    }

    /// Mean of a column in each group.
    pub(super) fn means(&self, column: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|rows| column[rows.clone()].iter().sum::<f64>() / rows.len() as f64).collect()
    }

    /// The same of an angle, which may jump by a whole turn, rad; without its jumps.
    pub(super) fn means_of_angle(&self, angle_rad: &[f64]) -> Vec<f64> {
        let mut turned_rad = 0.0;
        let mut whole = Vec::with_capacity(angle_rad.len());
        for (row, now_rad) in angle_rad.iter().enumerate() {
            let step_rad = if row > 0 { now_rad - angle_rad[row - 1] } else { 0.0 };
            turned_rad += if step_rad.abs() > 0.5 * TAU { wrapped(step_rad) - step_rad } else { 0.0 };
            whole.push(now_rad + turned_rad);
        }
        self.means(&whole)
    }

    /// Which groups consist of rows for all of which something holds.
    pub(super) fn all(&self, holds: &[bool]) -> Vec<bool> {
        self.rows.iter().map(|rows| holds[rows.clone()].iter().all(|holds| *holds)).collect()
    }

    /// Usual time from group to group, s.
    pub(super) fn step_s(&self) -> f64 {
        self.step_s
    }

    /// How many groups a time is.
    pub(super) fn steps(&self, time_s: f64) -> isize {
        (time_s / self.step_s).round() as isize
    }

    /// The difference quotient over `half` groups to each side; NaN beside a gap.
    pub(super) fn slope(&self, values: &[f64], half: usize) -> Vec<f64> {
        let slope = |at: usize| {
            let (before, after) = (at.checked_sub(half)?, at + half);
            let is_one_piece = self.piece.get(after) == Some(&self.piece[before]);
            is_one_piece.then(|| (values[after] - values[before]) / (self.time_s[after] - self.time_s[before]))
        };
        (0..values.len()).map(|at| slope(at).unwrap_or(f64::NAN)).collect()
    }

    /// What [`Bins::slope`] makes of an integral: the mean over its span, the ends counting half.
    pub(super) fn mean_over(&self, values: &[f64], half: usize) -> Vec<f64> {
        let mut integral = vec![0.0; values.len()];
        for at in 1..values.len() {
            let step_s = self.time_s[at] - self.time_s[at - 1];
            integral[at] = integral[at - 1] + 0.5 * (values[at] + values[at - 1]) * step_s;
        }
        self.slope(&integral, half)
    }

    /// Values without what is slow in them: their mean over `half` groups to each side; NaN where one of these has
    /// none, and beside a gap. [`Bins::mean_over`] is no such mean: its integral ends for good at the first NaN.
    pub(super) fn fast(&self, values: &[f64], half: usize) -> Vec<f64> {
        let (mut sum, mut lacking) = (vec![0.0; values.len() + 1], vec![0; values.len() + 1]);
        for (at, value) in values.iter().enumerate() {
            sum[at + 1] = sum[at] + if value.is_nan() { 0.0 } else { *value };
            lacking[at + 1] = lacking[at] + i32::from(value.is_nan());
        }
        let fast = |at: usize| {
            let (before, after) = (at.checked_sub(half)?, at + half);
            let is_whole = self.piece.get(after) == Some(&self.piece[before]) && lacking[after + 1] == lacking[before];
            is_whole.then(|| values[at] - (sum[after + 1] - sum[before]) / (2 * half + 1) as f64)
        };
        (0..values.len()).map(|at| fast(at).unwrap_or(f64::NAN)).collect()
    }

    /// The time over which [`Bins::slope`] takes the difference at each group, so much earlier; none beside a gap.
    pub(super) fn spans(&self, half: usize, earlier_s: f64) -> impl Iterator<Item = Option<Span>> {
        (0..self.rows.len()).map(move |at| {
            let (before, after) = (at.checked_sub(half)?, at + half);
            let piece = self.piece[before];
            let is_one_piece = self.piece.get(after) == Some(&piece);
            let s = [self.time_s[before] - earlier_s, self.time_s.get(after)? - earlier_s];
            is_one_piece.then(|| Span { s, rows: self.pieces[piece].clone() })
        })
    }

    /// Values of some groups earlier (later where negative); NaN where that is beyond a gap.
    pub(super) fn earlier(&self, values: &[f64], by: isize) -> Vec<f64> {
        let value = |at: usize| {
            let from = at.checked_add_signed(-by)?;
            (self.piece.get(from) == Some(&self.piece[at])).then(|| values[from])
        };
        (0..values.len()).map(|at| value(at).unwrap_or(f64::NAN)).collect()
    }

    /// The usable groups in stretches of equal number; none where there are too few to tell scatter from.
    pub(super) fn stretches(&self, is_usable: &[bool]) -> Vec<Vec<usize>> {
        let usable: Vec<usize> = (0..self.rows.len()).filter(|at| is_usable[*at]).collect();
        let count = (usable.len() as f64 * self.step_s / self.stretch_s) as usize;
        if count < STRETCHES_MIN {
            return Vec::new();
        }
        let count = count.min(STRETCHES_MAX);
        (0..count).map(|k| usable[k * usable.len() / count..(k + 1) * usable.len() / count].to_vec()).collect()
    }
}
