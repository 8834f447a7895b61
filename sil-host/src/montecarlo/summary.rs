//! What a study's rows amount to, row by row in bounded memory: extremes of all, and a sample for what needs every
//! value at once.

use std::cmp::Ordering;

use super::study::{Column, Kind, Row};

/// Rows that are kept for quantiles and sensitivity: of more, every second, third and so on. The standard error of a
/// quantile is then below 0.004 of the distribution, and a row has 500 bytes.
const KEPT_MAX: usize = 20_000;

/// Worst runs that are kept of each figure.
const WORST: usize = 3;

/// A run at an end of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// Its number.
    pub run: u64,
    /// Its figure; none for a flight that does not have it, which is worse than any number.
    pub value: Option<f64>,
}

/// One column over all rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Rows that have a number.
    pub count: u64,
    /// Rows without one: a flight that never settles, an axis that never rises.
    pub missing: u64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Mean of those that are numbers.
    pub mean: f64,
    /// The worst first.
    pub worst: Vec<Extreme>,
    /// Values of the rows kept.
    pub kept: Vec<Option<f64>>,
}

/// All columns over all rows.
#[derive(Clone, Debug)]
pub struct Summary {
    columns: Vec<Column>,
    samples: Vec<Sample>,
    rows: u64,
    every: u64,
}

impl Summary {
    /// Of a study's columns, and nothing yet.
    pub fn new(columns: &[Column]) -> Self {
        Self { columns: columns.to_vec(), samples: vec![Sample::default(); columns.len()], rows: 0, every: 1 }
    }

    /// Takes a row; the order of rows decides which are kept.
    pub fn add(&mut self, row: &Row) {
        let is_kept = self.rows.is_multiple_of(self.every);
        self.rows += 1;
        for (sample, value) in self.samples.iter_mut().zip(&row.values) {
            sample.add(row.run, *value, is_kept);
        }
        if self.kept() > KEPT_MAX {
            self.every *= 2;
            for sample in &mut self.samples {
                let mut index = 0;
                sample.kept.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
            }
        }
    }

    #[cfg(test)]
    pub(super) fn columns_mut(&mut self) -> &mut [Column] {
        &mut self.columns
    }

    /// Rows so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Rows kept for quantiles and sensitivity.
    pub fn kept(&self) -> usize {
        self.samples.first().map_or(0, |sample| sample.kept.len())
    }

    /// Columns of a kind with what was seen of them.
    pub fn of_kind(&self, kind: Kind) -> impl Iterator<Item = (&Column, &Sample)> {
        self.columns.iter().zip(&self.samples).filter(move |(column, _)| column.kind == kind)
    }

    /// A column by its name.
    pub fn column(&self, name: &str) -> Option<&Sample> {
        self.columns.iter().zip(&self.samples).find(|(column, _)| column.name == name).map(|(_, sample)| sample)
    }
}

impl Sample {
    fn add(&mut self, run: u64, value: Option<f64>, is_kept: bool) {
        let value = value.filter(|value| value.is_finite());
        match value {
            None => self.missing += 1,
            Some(number) => {
                self.count += 1;
                let is_first = self.count == 1;
                self.min = if is_first { number } else { self.min.min(number) };
                self.max = if is_first { number } else { self.max.max(number) };
                self.mean += (number - self.mean) / self.count as f64;
            }
        }
        if is_kept {
            self.kept.push(value);
        }
        let badness = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
        // of equal ones the lower number, in whatever order the rows come
        let is_better = |other: &Extreme| match badness(other.value).total_cmp(&badness(value)) {
            Ordering::Equal => other.run > run,
            order => order == Ordering::Less,
        };
        let place = self.worst.iter().position(is_better);
        let place = place.unwrap_or(self.worst.len());
        if place < WORST {
            self.worst.insert(place, Extreme { run, value });
            self.worst.truncate(WORST);
        }
    }

    /// The value that a share of the rows stays below, by straight lines between the ordered values; flights without a
    /// number lie above all others. None where the quantile is one of those, or of no rows.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let mut ordered: Vec<f64> = self.kept.iter().map(|value| value.unwrap_or(f64::INFINITY)).collect();
        ordered.sort_by(f64::total_cmp);
        let place = share * ordered.len().checked_sub(1)? as f64;
        let (below, above) = (place.floor() as usize, place.ceil() as usize);
        let (low, high) = (*ordered.get(below)?, *ordered.get(above)?);
        let value = if below == above { low } else { low + (high - low) * (place - below as f64) };
        Some(value).filter(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary_of(count: u64, value: impl Fn(u64) -> Option<f64>) -> Summary {
        let mut summary = Summary::new(&[Column { name: "f".into(), kind: Kind::Figure }]);
        for run in 0..count {
            summary.add(&Row { run, values: vec![value(run)] });
        }
        summary
    }

    #[test]
    fn quantiles_extremes_and_the_worst_are_those_of_the_rows() {
        // 0..1000 in another order; the last ten have no number
        let summary = summary_of(1000, |run| Some((run * 7 % 1000) as f64).filter(|value| *value < 990.0));
        let sample = summary.column("f").unwrap();
        assert_eq!((sample.count, sample.missing, sample.min, sample.max), (990, 10, 0.0, 989.0));
        assert!((sample.mean - 494.5).abs() < 1e-9);
        assert!((sample.quantile(0.5).unwrap() - 499.5).abs() < 1e-9);
        assert_eq!((sample.quantile(0.0), sample.quantile(0.995)), (Some(0.0), None));
        assert_eq!(sample.worst.len(), 3);
        assert!(sample.worst.iter().all(|worst| worst.value.is_none() && worst.run * 7 % 1000 >= 990));
    }

    #[test]
    fn of_many_rows_a_bounded_sample_is_kept_and_all_extremes() {
        let count = 3 * KEPT_MAX as u64;
        let summary = summary_of(count, |run| Some((run * 7919 % count) as f64));
        let sample = summary.column("f").unwrap();
        assert!(summary.kept() <= KEPT_MAX && summary.kept() > KEPT_MAX / 4, "{}", summary.kept());
        assert_eq!((sample.max, sample.worst[0].value), ((count - 1) as f64, Some((count - 1) as f64)));
        // five standard errors of the median's share
        let share = sample.quantile(0.5).unwrap() / count as f64;
        assert!((share - 0.5).abs() < 5.0 * 0.5 / (summary.kept() as f64).sqrt(), "{share}");
    }
}
