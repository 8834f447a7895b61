//! How a map makes a quantity of a file's columns.

use super::quantity::Quantity;
use super::quaternions::euler_angle;

/// How columns of the file become a quantity: the sum of each times its scale, and the offset.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MappedColumn {
    pub(super) quantity: Quantity,
    /// At least one.
    pub(super) terms: Vec<Term>,
    pub(super) offset: f64,
    pub(super) made: Made,
}

/// What becomes of the columns of a quantity, each times its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Made {
    /// They are added.
    Sum,
    /// How fast the only one changes.
    RateOf,
    /// They are a quaternion, w, x, y, z, whose Euler angle is the quantity, times this.
    EulerOf {
        /// Of the angle in radians.
        scale: f64,
    },
}

/// A column of the file and its share in a quantity.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Term {
    pub(super) column: String,
    pub(super) scale: f64,
}

impl MappedColumn {
    /// The column, or all of several, for messages.
    pub(super) fn called(&self) -> String {
        let between = if let Made::EulerOf { .. } = self.made { ", " } else { " + " };
        self.terms.iter().map(|term| term.column.as_str()).collect::<Vec<_>>().join(between)
    }

    /// The quantity row by row, of its columns each times its scale.
    pub(super) fn of_parts(&self, parts: &[Vec<f64>], rows: usize) -> Vec<f64> {
        let part = |place: usize, row: usize| parts.get(place).map_or(f64::NAN, |part| part[row]);
        let value = |row: usize| match self.made {
            Made::EulerOf { scale } => scale * euler_angle(self.quantity, [0, 1, 2, 3].map(|place| part(place, row))),
            Made::Sum | Made::RateOf => parts.iter().map(|part| part[row]).sum(),
        };
        (0..rows).map(|row| self.offset + value(row)).collect()
    }

    /// What a map says of the columns, without scale and sign.
    pub(super) fn source(&self) -> String {
        let called = self.called();
        match self.made {
            Made::Sum => format!("column = \"{called}\""),
            Made::RateOf => format!("rate_of = \"{called}\""),
            Made::EulerOf { .. } => format!("euler_of = [\"{}\"]", called.replace(", ", "\", \"")),
        }
    }
}
