//! What of a log a prediction looks at on its way.

use core::cell::Cell;

use super::force_track::ForceTrack;

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
}

impl Scene<'_> {
    pub(super) fn volts_lost(&self, time_s: f64) -> Option<f64> {
        let row = self.time_s.partition_point(|at| *at <= time_s).saturating_sub(1);
        self.volts_lost.get(row).copied()
    }
}

/// How the air passes while a prediction goes on.
pub(super) struct Passing<'s> {
    scene: &'s Scene<'s>,
    /// Where the prediction was last: it goes on from there.
    row: Cell<usize>,
}

impl<'s> Passing<'s> {
    /// From a row on.
    pub(super) fn from(scene: &'s Scene<'s>, row: usize) -> Passing<'s> {
        Passing { scene, row: Cell::new(row) }
    }

    /// Velocity against the air along x and y, m/s, on a line from row to row; none where the log does not say.
    #[inline]
    pub(super) fn airspeed_m_s(&self, time_s: f64) -> [f64; 2] {
        let Scene { time_s: rows_s, airspeed_m_s, .. } = self.scene;
        let mut row = self.row.get();
        while row > 0 && rows_s[row] > time_s {
            row -= 1;
        }
        while row + 2 < rows_s.len() && rows_s[row + 1] <= time_s {
            row += 1;
        }
        self.row.set(row);
        let (Some(from), Some(to)) = (airspeed_m_s.get(row), airspeed_m_s.get(row + 1)) else { return [0.0; 2] };
        let share = (time_s - rows_s[row]) / (rows_s[row + 1] - rows_s[row]);
        core::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]))
    }
}
