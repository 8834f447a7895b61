//! How a map makes a quantity of a file's columns.

use std::convert::Infallible;

use super::quantity::Quantity;
use super::quaternions::euler_angle;
use super::rate_of_change::rate_of_change;

/// How columns of the file become a quantity: what is made of them, times the scale, and the offset.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MappedColumn {
    pub(super) quantity: Quantity,
    /// At least one.
    pub(super) terms: Vec<Term>,
    /// Into the unit and frame of a [`super::Log`], sign included.
    pub(super) scale: f64,
    pub(super) offset: f64,
    pub(super) made: Made,
}

/// What is made of the columns of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Made {
    /// They are added, each times its share.
    Sum,
    /// How fast the only one changes.
    RateOf,
    /// They are a quaternion, w, x, y, z, whose Euler angle is the quantity.
    EulerOf,
}

/// A column of the file and its share in a quantity.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Term {
    pub(super) column: String,
    pub(super) share: f64,
}

impl MappedColumn {
    /// A quantity that is a column of the file, times a scale.
    pub(super) fn of_one(quantity: Quantity, column: &str, scale: f64) -> MappedColumn {
        let terms = vec![Term { column: column.to_owned(), share: 1.0 }];
        MappedColumn { quantity, terms, scale, offset: 0.0, made: Made::Sum }
    }

    /// The column, or all of several, for messages: `a + b` of a sum, `qw, qx, qy, qz` of a quaternion.
    pub(super) fn called(&self) -> String {
        let between = if self.made == Made::EulerOf { ", " } else { " + " };
        self.terms.iter().map(|term| term.column.as_str()).collect::<Vec<_>>().join(between)
    }

    /// The quantity of one row, of what its columns hold there, which is asked for by their places among the terms; of
    /// a rate what changes. NaN where one of them is, and where a quaternion is none.
    ///
    /// # Errors
    /// The first that a column has.
    pub(super) fn of_row<E>(&self, mut reading: impl FnMut(usize) -> Result<f64, E>) -> Result<f64, E> {
        if self.made == Made::EulerOf {
            let mut quaternion = [f64::NAN; 4];
            for (place, own) in quaternion.iter_mut().enumerate().take(self.terms.len()) {
                *own = reading(place)?;
            }
            return Ok(self.offset + self.scale * euler_angle(self.quantity, quaternion));
        }
        let mut terms = self.terms.iter().enumerate();
        terms.try_fold(self.offset, |sum, (place, term)| Ok(sum + self.scale * term.share * reading(place)?))
    }

    /// The same of all rows, of its columns, which are equally long.
    pub(super) fn of_columns(&self, columns: &[&[f64]]) -> Vec<f64> {
        let rows = columns.first().map_or(0, |column| column.len());
        let of_row = |row: usize| {
            let Ok(value) = self.of_row(|place| Ok::<f64, Infallible>(columns[place][row]));
            value
        };
        (0..rows).map(of_row).collect()
    }

    /// What becomes of the rows once their times, s, are known.
    pub(super) fn over_time(&self, time_s: &[f64], values: Vec<f64>) -> Vec<f64> {
        if self.made == Made::RateOf { rate_of_change(time_s, &values) } else { values }
    }

    /// What a map says of the columns, without scale and sign.
    pub(super) fn source(&self) -> String {
        let each = |say: &dyn Fn(&Term) -> String| self.terms.iter().map(say).collect::<Vec<_>>().join(", ");
        let quoted = |term: &Term| format!("\"{}\"", term.column);
        match (self.made, self.terms.as_slice()) {
            (Made::Sum, [_]) => format!("column = {}", each(&quoted)),
            (Made::Sum, _) => {
                format!("columns = {{ {} }}", each(&|term| format!("{} = {}", quoted(term), term.share)))
            }
            (Made::RateOf, _) => format!("rate_of = {}", each(&quoted)),
            (Made::EulerOf, _) => format!("euler_of = [{}]", each(&quoted)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;

    fn mapped(quantity: Quantity, columns: &[(&str, f64)], made: Made) -> MappedColumn {
        let term = |(column, share): &(&str, f64)| Term { column: (*column).to_owned(), share: *share };
        MappedColumn { quantity, terms: columns.iter().map(term).collect(), scale: 2.0, offset: 0.5, made }
    }

    #[test]
    fn a_sum_has_each_column_times_its_share_and_says_so() {
        let sum = mapped(Quantity::Thrust, &[("left", 0.25), ("right", -0.5)], Made::Sum);
        assert_eq!(sum.of_columns(&[&[1.0, 2.0, f64::NAN], &[3.0, 0.0, 1.0]])[..2], [0.5 + 0.5 - 3.0, 0.5 + 1.0]);
        assert!(sum.of_columns(&[&[f64::NAN], &[1.0]])[0].is_nan());
        assert_eq!(sum.called(), "left + right");
        assert_eq!(sum.source(), "columns = { \"left\" = 0.25, \"right\" = -0.5 }");
        let one = mapped(Quantity::Thrust, &[("left", 1.0)], Made::Sum);
        assert_eq!((one.called(), one.source()), ("left".to_owned(), "column = \"left\"".to_owned()));
    }

    #[test]
    fn a_quaternion_gives_an_angle_and_is_no_sum() {
        let columns = [("w", 1.0), ("x", 1.0), ("y", 1.0), ("z", 1.0)];
        let roll = mapped(Quantity::Angle(Axis::Roll), &columns, Made::EulerOf);
        let (w, x) = (libm::cos(0.15), libm::sin(0.15));
        assert!((roll.of_columns(&[&[w], &[x], &[0.0], &[0.0]])[0] - (0.5 + 2.0 * 0.3)).abs() < 1e-12);
        assert!(roll.of_columns(&[&[w], &[w], &[w], &[w]])[0].is_nan());
        assert_eq!(roll.called(), "w, x, y, z");
        assert_eq!(roll.source(), "euler_of = [\"w\", \"x\", \"y\", \"z\"]");
    }

    #[test]
    fn the_first_error_of_a_column_is_the_rows() {
        let sum = mapped(Quantity::Thrust, &[("a", 1.0), ("b", 1.0), ("c", 1.0)], Made::Sum);
        assert_eq!(sum.of_row(|place| if place > 0 { Err(place) } else { Ok(1.0) }), Err(1));
    }
}
