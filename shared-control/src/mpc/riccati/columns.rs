//! What the held bounds on the angle do to the plan: a column per bound, and the small system of their multipliers.
//!
//! A multiplier is a linear term of the cost, so that each input's law gets an offset in proportion to it: a column of
//! offsets. The angles at the bounds then follow from the multipliers by a symmetric matrix J (the Schur complement of
//! the equality problem), and J nu = (angles without multipliers) - (bounds).
//!
//! Angles one step apart move almost alike. So a bound next to held ones is taken as its difference from them, first or
//! second, without which J would be singular to single precision; the multipliers of the angles are put together again
//! from those of the differences.

use super::rows::Rows;
use super::working_set::set;
use crate::mpc::HORIZON;

/// A column whose share that is independent of the ones before it is smaller counts as dependent.
const DEPENDENCE: f32 = 2e-5;

/// A sum of angles, and what it depends on.
#[derive(Clone, Copy)]
pub(super) struct Column<const S: usize, const M: usize> {
    /// The latest of the angles it is made of.
    pub(super) row: usize,
    /// Weights of this angle, the one before, and the one before that.
    pub(super) weights: [f32; 3],
    /// The sum without multipliers.
    pub(super) value: f32,
    /// The same less what it is to be, with the bounds given up.
    pub(super) excess: f32,
    /// Effect of each free input on it, the later ones following their laws.
    pub(super) effects: [f32; M],
    /// Offset of each stage's law per multiplier.
    pub(super) offsets: [f32; M],
    /// Row of L in J = L D L'.
    factor: [f32; M],
    pivot: f32,
    pub(super) multiplier: f32,
}

/// All of them, in the order in which they came, so that a new one leaves the factors of the others as they are. Of M +
/// 1 one depends on the others; no more are ever held.
pub(super) type Columns<const S: usize, const M: usize> = heapless::Vec<Column<S, M>, { HORIZON + 1 }>;

impl<const S: usize, const M: usize> Column<S, M> {
    pub(super) fn new(row: usize, weights: [f32; 3]) -> Self {
        Self {
            row,
            weights,
            value: 0.0,
            excess: 0.0,
            effects: [0.0; M],
            offsets: [0.0; M],
            factor: [0.0; M],
            pivot: 0.0,
            multiplier: 0.0,
        }
    }

    /// Effect and offset of a stage.
    #[inline(always)]
    pub(super) fn at(&mut self, stage: usize) -> Option<(&mut f32, &mut f32)> {
        Some((self.effects.get_mut(stage)?, self.offsets.get_mut(stage)?))
    }

    /// Whether it is more than one angle.
    #[inline(always)]
    pub(super) fn is_difference(&self) -> bool {
        let [_, before, _] = self.weights;
        before != 0.0
    }

    /// How the sum moves with the multiplier of `other`.
    #[inline(always)]
    pub(super) fn coupling(&self, other: &Self) -> f32 {
        let common = if self.row < other.row { self.row } else { other.row };
        let products = self.effects.iter().zip(&other.offsets).take(common + 1);
        products.fold(0.0, |sum, (effect, offset)| sum + effect * offset)
    }

    /// Its row of the factor and its pivot, 0 if it depends on the `earlier` ones.
    fn factor_after(&mut self, earlier: &[Self]) {
        let whole = -self.coupling(self);
        let mut rest = whole;
        let mut scaled = [0.0; M];
        for (index, other) in earlier.iter().enumerate() {
            let known = other.factor.iter().zip(&scaled).take(index);
            let entry = known.fold(-self.coupling(other), |sum, (factor, scaled)| sum - factor * scaled);
            let factor = entry / other.pivot;
            set(&mut self.factor, index, factor);
            set(&mut scaled, index, entry);
            rest -= entry * factor;
        }
        self.pivot = if rest > DEPENDENCE * whole { rest } else { 0.0 };
    }
}

/// Weights of the held angle of `row`, and of the two before it.
fn weights(rows: &Rows, row: usize) -> [f32; 3] {
    let is_held = |steps: usize| row.checked_sub(steps).is_some_and(|row| rows.is_held(row));
    match (is_held(1), is_held(2)) {
        (true, true) => [1.0, -2.0, 1.0],
        (true, false) => [1.0, -1.0, 0.0],
        (false, _) => [1.0, 0.0, 0.0],
    }
}

/// Chooses the columns for what `rows` holds: keeps those that there are, and has `make` make the others. Returns how
/// many of the first are as they were, or none if there is no room.
pub(super) fn choose<const S: usize, const M: usize>(
    columns: &mut Columns<S, M>,
    rows: &Rows,
    make: impl Fn(&mut Column<S, M>),
) -> Option<usize> {
    let stays = |column: &Column<S, M>| rows.is_held(column.row) && column.weights == weights(rows, column.row);
    let mut unchanged = columns.len();
    if let Some(place) = columns.iter().position(|column| !stays(column)) {
        unchanged = place;
        columns.retain(stays);
    }
    for row in rows.held() {
        if columns.iter().all(|column| column.row != row) {
            // of more than M + 1 it would be the second that depends on the others
            let has_room = columns.len() <= M;
            if !has_room || columns.push(Column::new(row, weights(rows, row))).is_err() {
                return None;
            }
            make(columns.last_mut()?);
        }
    }
    Some(unchanged)
}

/// Factors J, of which the rows of the first `unchanged` columns are factored already, and solves for the multipliers.
/// If a column depends on those before it: the multipliers that together move nothing, and the column's angle.
pub(super) fn solve<const S: usize, const M: usize>(columns: &mut [Column<S, M>], unchanged: usize) -> Option<usize> {
    let mut dependent = None;
    let mut reduced: [f32; HORIZON + 1] = [0.0; HORIZON + 1];
    for index in 0..columns.len() {
        let Some((earlier, [column, ..])) = columns.split_at_mut_checked(index) else { break };
        if index >= unchanged {
            column.factor_after(earlier);
        }
        if column.pivot <= 0.0 {
            dependent = Some((index, column.row));
            for other in earlier {
                other.multiplier = 0.0;
            }
            column.multiplier = 1.0;
            break;
        }
        let known = column.factor.iter().zip(&reduced).take(index);
        let excess = known.fold(column.excess, |sum, (factor, known)| sum - factor * known);
        set(&mut reduced, index, excess);
        column.multiplier = excess / column.pivot;
    }
    // nu = L'^-1 (what stands there now)
    for index in (1..columns.len()).rev() {
        let Some((earlier, [column, ..])) = columns.split_at_mut_checked(index) else { continue };
        if dependent.is_some_and(|(place, _)| index > place) {
            column.multiplier = 0.0;
            continue;
        }
        for (other, factor) in earlier.iter_mut().zip(&column.factor) {
            other.multiplier -= factor * column.multiplier;
        }
    }
    dependent.map(|(_, row)| row)
}

/// Multipliers of the held bounds on the angle.
pub(super) fn row_multipliers<const S: usize, const M: usize>(
    columns: &[Column<S, M>],
    rows: &Rows,
    multipliers: &mut [f32; HORIZON],
) {
    for column in columns {
        set(multipliers, column.row, column.multiplier);
    }
    for column in columns.iter().filter(|column| column.is_difference()) {
        let [_, before, second] = column.weights;
        for (back, weight) in [(1, before), (2, second)] {
            // of an angle that is not held the weight is 0
            if let Some(sum) = multipliers.get_mut(column.row.wrapping_sub(back)) {
                *sum += weight * column.multiplier;
            }
        }
    }
    for column in columns {
        if let Some(multiplier) = multipliers.get_mut(column.row) {
            *multiplier = rows.get(column.row).multiplier(*multiplier);
        }
    }
}
