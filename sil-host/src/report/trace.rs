//! From samples to the path of one curve, with no more points than a screen can show.
//!
//! A pixel column shows no more of a curve than where it enters, its least and greatest value, and where it leaves:
//! these four samples of every column are kept, which draws the same pixels as all of them (Jugel et al., "M4: a
//! visualization-oriented time series data aggregation", VLDB 2014). A gap narrower than a column can't be seen either.

use super::axis::{Axis, is_plottable};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Columns of a chart: about the pixels of its width on a desktop screen.
const COLUMNS: i32 = 1000;
const UNITS_PER_COLUMN: i32 = 10;
/// Width and height of the grid on which paths are drawn; it is stretched to the chart's box.
pub(super) const WIDTH: i32 = COLUMNS * UNITS_PER_COLUMN;
pub(super) const HEIGHT: i32 = 4000;

/// How a curve goes from one sample to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Interpolation {
    Linear,
    /// The value holds until the next sample.
    Hold,
    /// Each sample stands alone.
    None,
}

type GridPoint = (i32, i32);

/// SVG path data of a curve: its strokes, and the samples that stand alone between gaps.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Trace {
    pub(super) line: String,
    pub(super) dots: String,
}

impl Trace {
    pub(super) fn new(samples: &[(f64, f64)], interpolation: Interpolation, x: &Axis, y: &Axis) -> Self {
        let mut trace = Self::default();
        if interpolation == Interpolation::None {
            alone(samples, x, y).into_iter().for_each(|point| trace.push(&[point]));
            return trace;
        }
        for stroke in strokes(samples, interpolation, x, y) {
            trace.push(&without_redundant(&stroke));
        }
        trace
    }

    fn push(&mut self, stroke: &[GridPoint]) {
        let Some((&(mut x, mut y), rest)) = stroke.split_first() else { return };
        // Writing to a String can't fail.
        if rest.is_empty() {
            let _ = write!(self.dots, "M{x} {y}h0");
            return;
        }
        let _ = write!(self.line, "M{x} {y}l");
        for (index, &(next_x, next_y)) in rest.iter().enumerate() {
            let (dx, dy) = (next_x - x, next_y - y);
            let before_x = if index == 0 || dx < 0 { "" } else { " " };
            let before_y = if dy < 0 { "" } else { " " };
            let _ = write!(self.line, "{before_x}{dx}{before_y}{dy}");
            (x, y) = (next_x, next_y);
        }
    }
}

/// The curve's unbroken strokes on the grid, thinned to at most four points per column and stroke.
fn strokes(samples: &[(f64, f64)], interpolation: Interpolation, x: &Axis, y: &Axis) -> Vec<Vec<GridPoint>> {
    let mut strokes = vec![Vec::new()];
    let mut column: Vec<GridPoint> = Vec::new();
    let mut gap = false;
    let mut broken_column = None;
    for &(time, value) in samples {
        if !(is_plottable(time) && is_plottable(value)) {
            gap = true;
            continue;
        }
        let point = grid_point(x.fraction(time), y.fraction(value));
        let previous = column.last().copied();
        let same_column = previous.is_some_and(|previous| column_of(previous) == column_of(point));
        // a column is broken once at most, or a dense series with many gaps would keep all its points
        let broken = gap && !(same_column && broken_column == Some(column_of(point)));
        if broken || !same_column {
            append_column(&mut strokes, &mut column);
        }
        if broken {
            strokes.push(Vec::new());
            broken_column = Some(column_of(point));
        }
        if let (Some((_, held_y)), Interpolation::Hold) = (previous, interpolation)
            && !gap
        {
            column.push((point.0, held_y));
        }
        column.push(point);
        gap = false;
    }
    append_column(&mut strokes, &mut column);
    strokes.retain(|stroke| !stroke.is_empty());
    strokes
}

/// The grid points of the samples, each once, from left to right.
fn alone(samples: &[(f64, f64)], x: &Axis, y: &Axis) -> BTreeSet<GridPoint> {
    let plotted = samples.iter().filter(|(at, value)| is_plottable(*at) && is_plottable(*value));
    plotted.map(|(at, value)| grid_point(x.fraction(*at), y.fraction(*value))).collect()
}

fn grid_point(x_fraction: f64, y_fraction: f64) -> GridPoint {
    ((x_fraction * f64::from(WIDTH)).round() as i32, ((1.0 - y_fraction) * f64::from(HEIGHT)).round() as i32)
}

fn column_of((x, _): GridPoint) -> i32 {
    x / UNITS_PER_COLUMN
}

/// Adds first, least, greatest and last point of the column, in their order, to the last stroke; empties the column.
fn append_column(strokes: &mut [Vec<GridPoint>], column: &mut Vec<GridPoint>) {
    let height_at = |&index: &usize| column[index].1;
    let least = (0..column.len()).min_by_key(height_at);
    let greatest = (0..column.len()).max_by_key(height_at);
    if let (Some(stroke), Some(least), Some(greatest)) = (strokes.last_mut(), least, greatest) {
        let mut kept = [0, least, greatest, column.len() - 1];
        kept.sort_unstable();
        for (position, &index) in kept.iter().enumerate() {
            if position == 0 || kept[position - 1] != index {
                stroke.push(column[index]);
            }
        }
    }
    column.clear();
}

/// Leaves out repeated points and the inner points of horizontal stretches.
fn without_redundant(stroke: &[GridPoint]) -> Vec<GridPoint> {
    let mut kept: Vec<GridPoint> = Vec::with_capacity(stroke.len());
    for &point in stroke {
        match kept[..] {
            [.., last] if last == point => continue,
            [.., before, last]
                if before.1 == last.1 && last.1 == point.1 && before.0 <= last.0 && last.0 <= point.0 =>
            {
                kept.pop();
            }
            _ => {}
        }
        kept.push(point);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit_axis() -> Axis {
        Axis::new((0.0, 1.0), 5)
    }

    #[test]
    fn readings_that_stand_alone_are_dots() {
        let trace = Trace::new(&[(1.0, 0.25), (0.0, 0.0), (0.0, 0.0)], Interpolation::None, &unit_axis(), &unit_axis());
        assert_eq!(trace, Trace { line: String::new(), dots: "M0 4000h0M10000 3000h0".into() });
    }

    fn linear_strokes(samples: &[(f64, f64)]) -> Vec<Vec<GridPoint>> {
        strokes(samples, Interpolation::Linear, &unit_axis(), &unit_axis())
    }

    #[test]
    fn few_samples_are_all_drawn() {
        let trace =
            Trace::new(&[(0.0, 0.0), (0.5, 1.0), (1.0, 0.25)], Interpolation::Linear, &unit_axis(), &unit_axis());
        assert_eq!(trace, Trace { line: "M0 4000l5000-4000 5000 3000".into(), dots: String::new() });
    }

    #[test]
    fn a_held_value_turns_at_right_angles() {
        let trace = Trace::new(&[(0.0, 0.0), (0.5, 1.0), (1.0, 1.0)], Interpolation::Hold, &unit_axis(), &unit_axis());
        assert_eq!(trace.line, "M0 4000l5000 0 0-4000 5000 0");
    }

    #[test]
    fn non_finite_samples_are_gaps_and_lone_samples_are_dots() {
        let samples = [
            (0.0, 0.5),
            (0.1, 0.5),
            (0.2, f64::NAN),
            (0.3, 0.5),
            (0.4, f64::INFINITY),
            (f64::NAN, 0.5),
            (0.6, 0.5),
            (0.7, 0.5),
        ];
        for interpolation in [Interpolation::Linear, Interpolation::Hold] {
            let trace = Trace::new(&samples, interpolation, &unit_axis(), &unit_axis());
            assert_eq!(trace, Trace { line: "M0 2000l1000 0M6000 2000l1000 0".into(), dots: "M3000 2000h0".into() });
        }
    }

    #[test]
    fn nothing_to_draw_gives_an_empty_path() {
        for samples in [&[][..], &[(f64::NAN, 1.0)], &[(0.5, f64::NEG_INFINITY)]] {
            assert_eq!(Trace::new(samples, Interpolation::Hold, &unit_axis(), &unit_axis()), Trace::default());
        }
    }

    #[test]
    fn a_spike_of_one_sample_survives_thinning() {
        let mut samples: Vec<_> = (0..100_000).map(|index| (f64::from(index) / 1e5, 0.5)).collect();
        samples[54_321].1 = 1.0;
        samples[54_329].1 = 0.0;
        let thinned = linear_strokes(&samples).concat();
        assert!(thinned.contains(&(5432, 0)) && thinned.contains(&(5433, 4000)));
        assert!(without_redundant(&thinned).len() < 10, "the flat parts need no points");
    }

    #[test]
    fn gaps_in_every_second_sample_of_a_dense_series_cost_no_space() {
        let samples: Vec<_> =
            (0..200_000).map(|index| (f64::from(index) / 2e5, if index % 2 == 0 { f64::NAN } else { 0.5 })).collect();
        let points: usize = linear_strokes(&samples).iter().map(Vec::len).sum();
        // each column's four points, twice for the one break in it
        assert!(points <= 8 * (COLUMNS as usize + 1), "{points}");
    }

    proptest! {
        /// In every pixel column the thinned curve enters, leaves, and reaches up and down where the full one does.
        #[test]
        fn thinning_keeps_the_envelope_of_every_column(
            values in prop::collection::vec(prop_oneof![9 => 0.0..1.0_f64, 1 => Just(f64::NAN)], 1..6000),
        ) {
            let count = values.len() as f64;
            let samples: Vec<_> =
                values.iter().enumerate().map(|(index, &value)| (index as f64 / count, value)).collect();
            let all: Vec<GridPoint> = samples
                .iter()
                .filter(|(_, value)| value.is_finite())
                .map(|&(time, value)| grid_point(time, unit_axis().fraction(value)))
                .collect();
            prop_assert_eq!(column_shapes(&linear_strokes(&samples).concat()), column_shapes(&all));
        }
    }

    /// First, least, greatest and last height in each column that has points.
    fn column_shapes(points: &[GridPoint]) -> Vec<[i32; 5]> {
        points
            .chunk_by(|&a, &b| column_of(a) == column_of(b))
            .map(|column| {
                let heights = || column.iter().map(|point| point.1);
                let (least, greatest) = (heights().min().unwrap_or(0), heights().max().unwrap_or(0));
                [column_of(column[0]), column[0].1, least, greatest, column[column.len() - 1].1]
            })
            .collect()
    }
}
