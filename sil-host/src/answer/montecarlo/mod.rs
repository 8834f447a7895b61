//! The answer to a Monte Carlo study: distributions of the figures, the worst vehicles each with the command that flies
//! it again, and which tolerance a figure comes from; as text, page and JSON.

mod json;
mod page;
mod text;

use std::collections::BTreeMap;

use crate::montecarlo::{About, Column, Kind, Sample, Sensitivity, Summary};
use crate::statistics::decimals;

pub use json::{StudyJson, Work};
pub use page::page;
pub use text::{drawn_text, text};

/// A study with what follows from its rows.
pub struct StudyAnswer {
    /// What was studied.
    pub about: About,
    /// Its rows.
    pub summary: Summary,
    /// Of each figure, in the order of its columns.
    sensitivities: Vec<Option<Sensitivity>>,
}

/// A figure of a study.
pub(crate) struct StudyFigure<'a> {
    pub(crate) name: &'a str,
    pub(crate) sample: &'a Sample,
    pub(crate) nominal: Option<f64>,
    pub(crate) sensitivity: Option<&'a Sensitivity>,
}

/// Flights that were lost under a controller.
pub(crate) struct Lost<'a> {
    pub(crate) controller: &'a str,
    pub(crate) count: u64,
    /// 95 % interval of the share.
    pub(crate) interval: [f64; 2],
    /// The first of them.
    pub(crate) runs: Vec<u64>,
}

impl StudyAnswer {
    /// Of a study's rows.
    pub fn new(about: About, summary: Summary) -> Self {
        let figures: Vec<&str> = summary.of_kind(Kind::Figure).map(|(column, _)| column.name.as_str()).collect();
        let sensitivities = Sensitivity::of(&summary, &figures);
        Self { about, summary, sensitivities }
    }

    fn nominal(&self, column: &Column) -> Option<f64> {
        self.about.columns.iter().find(|about| about.name == column.name).and_then(|about| about.nominal)
    }

    pub(crate) fn figures(&self) -> impl Iterator<Item = StudyFigure<'_>> {
        let figures = self.summary.of_kind(Kind::Figure).zip(&self.sensitivities);
        figures.map(|((column, sample), sensitivity)| StudyFigure {
            name: &column.name,
            sample,
            nominal: self.nominal(column),
            sensitivity: sensitivity.as_ref(),
        })
    }

    pub(crate) fn lost(&self) -> impl Iterator<Item = Lost<'_>> {
        self.summary.of_kind(Kind::Lost).map(|(column, sample)| {
            let count = (sample.mean * sample.count as f64).round() as u64;
            let is_lost = |worst: &&crate::montecarlo::Extreme| worst.value == Some(1.0);
            Lost {
                controller: column.name.trim_end_matches(".lost"),
                count,
                interval: share_interval(count, sample.count),
                runs: sample.worst.iter().filter(is_lost).map(|worst| worst.run).collect(),
            }
        })
    }

    /// The worst run of each figure that differs from run to run, with the figures that it is worst in.
    pub(crate) fn worst(&self) -> BTreeMap<u64, Vec<(StudyFigure<'_>, Option<f64>)>> {
        let mut by_run: BTreeMap<u64, Vec<(StudyFigure<'_>, Option<f64>)>> = BTreeMap::new();
        for figure in self.figures().filter(|figure| figure.sample.min < figure.sample.max || figure.sample.missing > 0)
        {
            if let Some(worst) = figure.sample.worst.first() {
                by_run.entry(worst.run).or_default().push((figure, worst.value));
            }
        }
        by_run
    }

    /// "F450, 1000 vehicles of 12 tolerances".
    pub(crate) fn title(&self) -> String {
        let drawn = self.summary.of_kind(Kind::Drawn).count();
        let About { model, scenario, seed, .. } = &self.about;
        format!("{model}: {} vehicles, {drawn} numbers drawn of each, seed {seed}; {scenario}", self.summary.rows())
    }

    /// What a reader of its quantiles must know.
    pub(crate) fn sampling(&self) -> Option<String> {
        let (rows, kept) = (self.summary.rows(), self.summary.kept());
        (kept as u64 != rows).then(|| {
            format!(
                "Quantiles and sensitivities are of {kept} of the {rows} vehicles, evenly chosen; extremes are of all."
            )
        })
    }
}

/// Wilson's 95 % interval of a share (Wilson, Journal of the American Statistical Association 22, 1927).
fn share_interval(count: u64, of: u64) -> [f64; 2] {
    const NORMAL_95: f64 = 1.959_964;
    let (of, square) = (of.max(1) as f64, NORMAL_95 * NORMAL_95);
    let share = count as f64 / of;
    let middle = (share + 0.5 * square / of) / (1.0 + square / of);
    let half = NORMAL_95 * (share * (1.0 - share) / of + 0.25 * square / (of * of)).sqrt() / (1.0 + square / of);
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

/// Four significant digits; a dash for a figure that a flight does not have.
fn shown(value: Option<f64>) -> String {
    match value.filter(|value| value.is_finite()) {
        Some(value) => format!("{value:.*}", decimals(value, 4, 6)),
        None => "-".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wilson's interval of 0 of 1000 and of 10 of 100, computed by hand from his formula.
    #[test]
    fn shares_have_wilsons_interval() {
        let [low, high] = share_interval(0, 1000);
        assert!(low < 1e-12 && (high - 0.003_827).abs() < 1e-6, "{high}");
        let [low, high] = share_interval(10, 100);
        assert!((low - 0.055_23).abs() < 1e-5 && (high - 0.174_37).abs() < 1e-5, "{low} {high}");
    }

    #[test]
    fn figures_are_shown_with_four_digits() {
        let values = [Some(0.012_345_6), Some(5.432_11), Some(123.456), Some(0.0), Some(1e-9), None];
        assert_eq!(values.map(shown), ["0.01235", "5.432", "123.5", "0", "0.000000", "-"]);
    }
}
