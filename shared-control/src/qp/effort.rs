//! What a solve may cost and has cost, counted before each part of it begins: no solve costs more than it may.
//!
//! One unit is an entry of a row multiplied and added: two loads, two operations and their share of the loop, some
//! seven instructions of a Cortex-M4F. What a part costs follows from sizes alone; the numbers below stand for the
//! heads of loops, divisions, roots and copies, so that a unit is about the same whatever it is spent on
//! (`docs/solver.md`).

use super::{Settings, Status};

/// Head of a loop over a row's entries, and what it does with the sum.
const ROW: usize = 5;
/// A part's own arrays, cleared and copied at their full size, for each entry that there is room for.
const COPIES: usize = 2;
/// A constraint's search in the working set, for four that are held.
const HELD_IN_FOUR: usize = 3;
/// A rotation: a root and two divisions.
const ROTATION: usize = 10;

/// What is left of a solve's limits.
pub(super) struct Effort {
    /// Working sets examined.
    pub(super) iterations: u16,
    /// Units spent.
    pub(super) work: u32,
    iteration_limit: u16,
    work_limit: u32,
}

impl Effort {
    pub(super) fn new(settings: &Settings) -> Self {
        let Settings { iteration_limit, work_limit, .. } = *settings;
        Self { iterations: 0, work: 0, iteration_limit, work_limit }
    }

    /// Counts one more working set.
    pub(super) fn examine(&mut self) -> Result<(), Status> {
        if self.iterations >= self.iteration_limit {
            return Err(Status::IterationLimit);
        }
        self.iterations += 1;
        Ok(())
    }

    /// Counts a part that is about to begin.
    pub(super) fn spend(&mut self, units: u32) -> Result<(), Status> {
        if self.spend_of(self.work_limit, units) { Ok(()) } else { Err(Status::WorkLimit) }
    }

    /// The same of a part for which no more than `part` of the whole limit may have been spent in the end; false if
    /// it is not to begin.
    pub(super) fn spend_within(&mut self, part: u32, units: u32) -> bool {
        self.spend_of(self.work_limit / part, units)
    }

    fn spend_of(&mut self, limit: u32, units: u32) -> bool {
        let spent = self.work.saturating_add(units);
        let within = spent <= limit;
        if within {
            self.work = spent;
        }
        within
    }
}

/// Sizes of a program, of which the costs are made.
#[derive(Clone, Copy)]
pub(super) struct Size {
    /// Variables in use.
    pub(super) variables: usize,
    /// General rows in use.
    pub(super) rows: usize,
    /// Variables that there is room for.
    pub(super) room: usize,
}

impl Size {
    /// One more row behind `held` ones: two passes of Gram and Schmidt, and, should it depend on them, of which
    /// combination.
    pub(super) fn appending(self, held: usize) -> u32 {
        units(self.two_passes(held) + 4 * self.variables + self.triangle(held) + COPIES * self.room)
    }

    /// The nearest point and its multipliers: two triangular systems about two passes; and the multipliers' way there.
    pub(super) fn projecting(self, held: usize) -> u32 {
        units(self.two_passes(held) + 2 * self.triangle(held) + 4 * held + COPIES * self.room)
    }

    /// The most violated of the bounds, whose rows are triangular, and of the general rows.
    pub(super) fn comparing(self, held: usize) -> u32 {
        let constraints = self.variables + self.rows;
        units(
            self.triangle(self.variables) + self.rows * (self.variables + ROW) + constraints * held * HELD_IN_FOUR / 4,
        )
    }

    /// The row at `position` of `held` ones: for each that follows a rotation of two rows and two columns, and a move
    /// in memory by one place.
    pub(super) fn removing(self, position: usize, held: usize) -> u32 {
        let later = held.saturating_sub(position + 1);
        let rotations = later * (ROTATION + 2 * self.variables + self.room / 2) + later * (later + 1);
        units(rotations + COPIES * self.room)
    }

    /// Twice over the rows held: a product with each, and that much of it taken off.
    fn two_passes(self, held: usize) -> usize {
        2 * held * (2 * self.variables + 2 * ROW)
    }

    /// A triangular system.
    fn triangle(self, held: usize) -> usize {
        held * (held + 1) / 2 + ROW * held
    }
}

/// No program has so many rows that it fails.
fn units(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
