//! A component as its measurements: points with straight lines between them (thesis section 6.3).

use crate::document::{Admissible, ModelError, Section, Table};

/// As many points as a table has at most: enough for a sweep in steps of 5 %, and few enough to be copied.
pub const POINTS_MAX: usize = 24;

/// Points in ascending order; beyond its ends a table goes on as its first and last line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookUpTable {
    points: [(f64, f64); POINTS_MAX],
    count: usize,
}

impl LookUpTable {
    /// A table of these points; none unless there are 2 to [`POINTS_MAX`] finite ones that ascend.
    pub fn new(points: &[(f64, f64)]) -> Option<Self> {
        let is_finite = points.iter().all(|(x, y)| x.is_finite() && y.is_finite());
        let ascends = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if !(2..=POINTS_MAX).contains(&points.len()) || !is_finite || !ascends {
            return None;
        }
        let mut table = Self { points: [(0.0, 0.0); POINTS_MAX], count: points.len() };
        table.points[..points.len()].copy_from_slice(points);
        Some(table)
    }

    /// Its points.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points[..self.count]
    }

    /// The value at `x`.
    pub fn value(&self, x: f64) -> f64 {
        let points = self.points();
        let above = points.partition_point(|(at, _)| *at <= x).clamp(1, points.len() - 1);
        let ((x0, y0), (x1, y1)) = (points[above - 1], points[above]);
        y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    }

    /// Reads two lists of one length.
    pub(super) fn read(
        section: &Section<'_>,
        (x_key, x_range): (&'static str, Admissible),
        (y_key, y_range): (&'static str, Admissible),
    ) -> Result<Self, ModelError> {
        let (x, y) = (section.numbers(x_key, x_range)?, section.numbers(y_key, y_range)?);
        let points: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).collect();
        let table = Self::new(&points).filter(|_| x.len() == y.len());
        table.ok_or_else(|| {
            section.impossible(format!(
                "`{x_key}` and `{y_key}` are no table: expected lists of one length, 2 to {POINTS_MAX} numbers, \
                 `{x_key}` ascending"
            ))
        })
    }

    pub(super) fn write(&self, table: &mut Table, x_key: &str, y_key: &str) {
        let (x, y): (Vec<f64>, Vec<f64>) = self.points().iter().copied().unzip();
        table.numbers(x_key, &x);
        table.numbers(y_key, &y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_points_and_beyond_them_runs_a_line() {
        let table = LookUpTable::new(&[(0.0, 1.0), (1.0, 3.0), (3.0, 3.5)]).unwrap();
        for (x, value) in [(0.0, 1.0), (0.5, 2.0), (1.0, 3.0), (2.0, 3.25), (3.0, 3.5), (5.0, 4.0), (-1.0, -1.0)] {
            assert_eq!(table.value(x), value, "{x}");
        }
    }

    #[test]
    fn what_is_no_function_is_no_table() {
        assert_eq!(LookUpTable::new(&[(0.0, 1.0)]), None);
        assert_eq!(LookUpTable::new(&[(0.0, 1.0), (0.0, 2.0)]), None);
        assert_eq!(LookUpTable::new(&[(0.0, 1.0), (1.0, f64::NAN)]), None);
        assert_eq!(LookUpTable::new(&[(0.0, 1.0); POINTS_MAX + 1]), None);
    }
}
