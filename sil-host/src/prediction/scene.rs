//! What of a log a prediction looks at on its way.

use core::cell::Cell;

use super::force_track::ForceTrack;
use super::one_body::{MeasuredTurn, Turn};
use crate::vehicle::SensorChain;

/// What a log gives to a model: its times, the forces that its commands make, its battery.
pub(crate) struct Scene<'a> {
    pub(crate) time_s: &'a [f64],
    pub(crate) track: &'a ForceTrack,
    /// True where angles are compared.
    pub(crate) shows_attitude: bool,
    /// True where the velocity of a free vehicle is compared.
    pub(crate) shows_velocity: bool,
    /// True where that or its height is.
    pub(crate) shows_travel: bool,
    /// Per row, what the battery has lost against the first second, V; empty where the log has no voltage.
    pub(crate) volts_lost: &'a [f64],
    /// Per row, velocity against the air along x and y, m/s; empty where the log does not say.
    pub(crate) airspeed_m_s: &'a [[f64; 2]],
    /// Per row, how a body turns whose axes are taken one by one; empty of other logs.
    pub(crate) measured_turns: &'a [MeasuredTurn],
}

impl Scene<'_> {
    pub(super) fn volts_lost(&self, time_s: f64) -> Option<f64> {
        let row = self.time_s.partition_point(|at| *at <= time_s).saturating_sub(1);
        self.volts_lost.get(row).copied()
    }
}

/// What was measured while a prediction goes on: how the air passes, how the other axes turn.
pub(super) struct Passing<'s> {
    scene: &'s Scene<'s>,
    /// Where the prediction was last: it goes on from there.
    row: Cell<usize>,
    /// How the body turns at a row and at the next, where that was last asked.
    turns: Cell<Option<(usize, [Turn; 2])>>,
}

impl<'s> Passing<'s> {
    /// From a row on.
    pub(super) fn from(scene: &'s Scene<'s>, row: usize) -> Passing<'s> {
        Passing { scene, row: Cell::new(row), turns: Cell::new(None) }
    }

    /// Velocity against the air along x and y, m/s, on a line from row to row; none where the log does not say.
    #[inline]
    pub(super) fn airspeed_m_s(&self, time_s: f64) -> [f64; 2] {
        let airspeed_m_s = self.scene.airspeed_m_s;
        let (row, share) = self.place(time_s);
        let (Some(from), Some(to)) = (airspeed_m_s.get(row), airspeed_m_s.get(row + 1)) else { return [0.0; 2] };
        core::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]))
    }

    /// How the body turns whose axes are taken one by one, by what a model's sensors have measured; none of other logs.
    #[inline]
    pub(super) fn turn(&self, time_s: f64, sensors: &SensorChain) -> Option<Turn> {
        let measured = self.scene.measured_turns;
        if measured.is_empty() {
            return None;
        }
        let (row, share) = self.place(time_s);
        let [from, to] = match self.turns.get() {
            Some((known, turns)) if known == row => turns,
            Some((known, [_, next])) if known + 1 == row => [next, measured.get(row + 1)?.turn(sensors)],
            _ => [measured.get(row)?.turn(sensors), measured.get(row + 1)?.turn(sensors)],
        };
        self.turns.set(Some((row, [from, to])));
        Some(from.between(&to, share))
    }

    /// The last row that is not after a time, and the share of the way to the next.
    #[inline]
    fn place(&self, time_s: f64) -> (usize, f64) {
        let rows_s = self.scene.time_s;
        let mut row = self.row.get();
        while row > 0 && rows_s[row] > time_s {
            row -= 1;
        }
        while row + 2 < rows_s.len() && rows_s[row + 1] <= time_s {
            row += 1;
        }
        self.row.set(row);
        (row, rows_s.get(row + 1).map_or(0.0, |next_s| (time_s - rows_s[row]) / (next_s - rows_s[row])))
    }
}
