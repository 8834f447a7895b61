//! What a chart shows: curves over time or over another quantity, and shaded spans of it.

use super::axis::{Axis, extent, is_plottable};
use super::palette::{Key, Mark};
use super::trace::Interpolation;

/// About as many ticks are set on an axis.
const TIME_TICKS: u32 = 6;
const VALUE_TICKS: u32 = 5;

/// A chart of one quantity over another, mostly time.
#[derive(Clone, Debug)]
pub struct Chart {
    pub(super) title: String,
    pub(super) unit: String,
    /// What runs to the right, with its unit.
    pub(super) over: String,
    pub(super) caption: String,
    pub(super) series: Vec<Series>,
    pub(super) spans: Vec<Span>,
    value_range: Option<(f64, f64)>,
}

#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) name: String,
    /// Time in seconds, value.
    pub(super) samples: Vec<(f64, f64)>,
    pub(super) interpolation: Interpolation,
}

#[derive(Clone, Debug)]
pub(super) struct Span {
    pub(super) start_s: f64,
    pub(super) end_s: f64,
    pub(super) label: String,
}

impl Chart {
    /// A chart without curves; `unit` is the unit of the values ("" for none). Time is in seconds.
    pub fn time_series(title: impl Into<String>, unit: impl Into<String>) -> Self {
        Self::over("time, s", title, unit)
    }

    /// The same over another quantity than time, named with its unit: "angle, deg".
    pub fn over(quantity: impl Into<String>, title: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            unit: unit.into(),
            over: quantity.into(),
            caption: String::new(),
            series: Vec::new(),
            spans: Vec::new(),
            value_range: None,
        }
    }

    /// Adds a curve through the samples; a sample whose time or value isn't finite is a gap. Times ascend; of slices of
    /// different lengths the longer one's rest is left out. A name keeps its colour in the whole page.
    pub fn series(self, name: impl Into<String>, time_s: &[f64], values: &[f64]) -> Self {
        self.with_series(name.into(), time_s, values, Interpolation::Linear)
    }

    /// Adds a curve whose values hold until the next sample, such as a reference; drawn in grey.
    pub fn step_series(self, name: impl Into<String>, time_s: &[f64], values: &[f64]) -> Self {
        self.with_series(name.into(), time_s, values, Interpolation::Hold)
    }

    /// Adds readings that no curve joins, in any order.
    pub fn points(self, name: impl Into<String>, x: &[f64], values: &[f64]) -> Self {
        self.with_series(name.into(), x, values, Interpolation::None)
    }

    fn with_series(mut self, name: String, time_s: &[f64], values: &[f64], interpolation: Interpolation) -> Self {
        let samples = time_s.iter().copied().zip(values.iter().copied()).collect();
        self.series.push(Series { name, samples, interpolation });
        self
    }

    /// Shades a span of time; spans of the same label share a shade and a legend entry. What lies beyond the curves'
    /// time, or isn't finite, is not drawn.
    pub fn span(mut self, start_s: f64, end_s: f64, label: impl Into<String>) -> Self {
        self.spans.push(Span { start_s, end_s, label: label.into() });
        self
    }

    /// Shows the values from `low` to `high` whatever the curves reach, which are cut at the edge: 0 to 1 for motor
    /// commands. Ignored unless both are finite.
    pub fn value_range(mut self, low: f64, high: f64) -> Self {
        self.value_range = extent([low, high]).filter(|_| is_plottable(low) && is_plottable(high));
        self
    }

    pub(super) fn has_chosen_range(&self) -> bool {
        self.value_range.is_some()
    }

    /// Sentences below the title: what is to be seen here.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }
}

/// The axes that show all curves of these charts, or `None` without a sample to show.
pub(super) fn shared_axes(charts: &[Chart]) -> Option<(Axis, Axis)> {
    let samples = || charts.iter().flat_map(|chart| &chart.series).flat_map(|series| series.samples.iter().copied());
    let drawn = || samples().filter(|&(time_s, value)| is_plottable(time_s) && is_plottable(value));
    let time = Axis::new(extent(drawn().map(|(time_s, _)| time_s))?, TIME_TICKS);
    let chosen = extent(charts.iter().filter_map(|chart| chart.value_range).flat_map(|(low, high)| [low, high]));
    let value = match chosen {
        Some(range) => Axis::new(range, VALUE_TICKS),
        None => Axis::with_margin(extent(drawn().map(|(_, value)| value))?, VALUE_TICKS),
    };
    Some((time, value))
}

/// Everything that these charts' legend has to name, once each: curves, then spans.
pub(super) fn legend_keys(charts: &[Chart]) -> Vec<Key<'_>> {
    let curves = charts.iter().flat_map(|chart| &chart.series).map(|series| (series.mark(), series.name.as_str()));
    let spans = charts.iter().flat_map(|chart| &chart.spans).map(|span| (Mark::Shade, span.label.as_str()));
    let mut keys = Vec::new();
    for key in curves.chain(spans) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

impl Series {
    pub(super) fn mark(&self) -> Mark {
        match self.interpolation {
            Interpolation::Linear | Interpolation::None => Mark::Line,
            Interpolation::Hold => Mark::Held,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_cover_all_charts_and_only_what_is_drawn() {
        let charts = [
            Chart::time_series("a", "").series("x", &[0.0, 10.0], &[1.0, 2.0]),
            // The sample at 99 s has no value, the third time no partner: neither is drawn.
            Chart::time_series("b", "").series("x", &[5.0, 99.0, 77.0], &[-3.0, f64::NAN]),
        ];
        let (time, value) = shared_axes(&charts).expect("there are samples");
        assert_eq!(time.range(), 0.0..=10.0);
        // From -3 to 2 and a margin of 5 % of that at both ends.
        assert_eq!(value.range(), -3.25..=2.25);
    }

    #[test]
    fn a_chosen_range_of_values_is_taken_as_it_is() {
        let chart = || Chart::time_series("a", "").series("x", &[0.0, 1.0], &[0.4, 0.6]);
        let range = |chart: Chart| shared_axes(&[chart]).map(|(_, value)| value.range());
        assert_eq!(range(chart().value_range(0.0, 1.0)), Some(0.0..=1.0));
        assert_eq!(range(chart().value_range(1.0, 0.0)), Some(0.0..=1.0));
        assert_eq!(range(chart().value_range(0.0, f64::NAN)), range(chart()));
    }

    #[test]
    fn the_legend_names_everything_once() {
        let chart = |name: &str| {
            Chart::time_series(name, "")
                .step_series("reference", &[0.0], &[0.0])
                .series("PID", &[0.0], &[0.0])
                .span(0.0, 1.0, "held out")
                .span(2.0, 3.0, "held out")
        };
        let charts = [chart("roll"), chart("pitch")];
        let expected = [(Mark::Held, "reference"), (Mark::Line, "PID"), (Mark::Shade, "held out")];
        assert_eq!(legend_keys(&charts), expected);
    }
}
