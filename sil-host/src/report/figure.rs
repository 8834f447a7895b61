//! Charts as SVG inside the page: one alone, or several small ones with common axes and one legend.
//!
//! Text and lines keep their size whatever the chart's width: labels stand at percentages of the box, and the curves
//! lie in an inner drawing that is stretched to it, its strokes are not. So a phone gets legible labels and a chart as
//! high as a desktop's. Colours and dash patterns are classes of the page's style sheet.

use super::axis::{Axis, extent};
use super::chart::{Chart, Series, Span, legend_keys, shared_axes};
use super::palette::{Key, Mark, Palette};
use super::trace::{HEIGHT, Trace, WIDTH};
use maud::{Markup, html};

/// Shaded spans are at least so wide on the grid: a few pixels.
const LEAST_SHADE_WIDTH: i32 = WIDTH / 250;

/// Classes `dash0`... of the style sheet.
const DASH_PATTERNS: usize = 6;

/// A chart with its caption and legend.
pub(super) fn single(chart: &Chart, palette: &mut Palette) -> Markup {
    let charts = std::slice::from_ref(chart);
    let legend = Legend::new(charts, palette);
    html! {
        figure data-figure="" {
            figcaption {
                (heading(&chart.title, &chart.unit))
                @if !chart.caption.is_empty() { p { (chart.caption) } }
            }
            (legend.render())
            (plot(chart, shared_axes(charts), &legend))
        }
    }
}

/// Several charts side by side where there is room, with the same axes.
pub(super) fn small_multiples(caption: &str, charts: &[Chart], palette: &mut Palette) -> Markup {
    let axes = shared_axes(charts);
    group(caption, charts, |_| axes, palette)
}

/// The same, each with axes of its own.
pub(super) fn side_by_side(caption: &str, charts: &[Chart], palette: &mut Palette) -> Markup {
    group(caption, charts, |chart| shared_axes(std::slice::from_ref(chart)), palette)
}

fn group(
    caption: &str,
    charts: &[Chart],
    axes: impl Fn(&Chart) -> Option<(Axis, Axis)>,
    palette: &mut Palette,
) -> Markup {
    let legend = Legend::new(charts, palette);
    html! {
        figure.group data-figure="" {
            figcaption { p { (caption) } }
            (legend.render())
            div.multiples {
                @for chart in charts {
                    figure {
                        figcaption {
                            (heading(&chart.title, &chart.unit))
                            @if !chart.caption.is_empty() { p { (chart.caption) } }
                        }
                        (plot(chart, axes(chart), &legend))
                    }
                }
            }
        }
    }
}

fn heading(title: &str, unit: &str) -> Markup {
    html! {
        strong { (title) }
        @if !unit.is_empty() { ", " (unit) }
    }
}

/// What a figure names, each with its classes: a colour, the same in the whole page, and a dash pattern, which
/// separates the figure's curves in grey; the first is solid.
struct Legend<'a> {
    entries: Vec<(Key<'a>, String)>,
}

impl<'a> Legend<'a> {
    fn new(charts: &'a [Chart], palette: &mut Palette) -> Self {
        let keys = legend_keys(charts);
        let colours = palette.classes(&keys);
        let ordinal = |index: usize| keys[..index].iter().filter(|key| key.0 == keys[index].0).count();
        let class = |(index, colour): (usize, String)| match keys[index].0 {
            Mark::Shade => colour,
            Mark::Line | Mark::Held => format!("{colour} dash{}", ordinal(index) % DASH_PATTERNS),
        };
        let classes: Vec<String> = colours.into_iter().enumerate().map(class).collect();
        Self { entries: keys.into_iter().zip(classes).collect() }
    }

    fn class(&self, mark: Mark, name: &str) -> &str {
        self.entries.iter().find(|(key, _)| *key == (mark, name)).map_or("", |(_, class)| class)
    }

    fn render(&self) -> Markup {
        html! {
            @if !self.entries.is_empty() {
                ul.legend aria-label="Legend" {
                    @for ((mark, name), class) in &self.entries {
                        li data-name=[(*mark != Mark::Shade).then_some(name)] {
                            svg width="32" height="12" aria-hidden="true" {
                                @let shape = if *mark == Mark::Shade { "M0 0H32V12H0z" } else { "M0 6H32" };
                                path class=(class) d=(shape) {}
                            }
                            (name)
                        }
                    }
                }
            }
        }
    }
}

fn plot(chart: &Chart, axes: Option<(Axis, Axis)>, legend: &Legend<'_>) -> Markup {
    let Some((time, value)) = axes else {
        return html! { p.empty { "No data." } };
    };
    let label_width = value.ticks().into_iter().map(|tick| value.label(tick).chars().count()).max();
    // No less than four characters, so that the time axes of most charts are in line.
    let margin = format!("--label-width:{}ch", label_width.unwrap_or(0).max(4));
    let view_box = format!("0 0 {WIDTH} {HEIGHT}");
    // for plots.js, which reads the samples back from the paths
    let ends = |axis: &Axis| format!("{} {}", axis.range().start(), axis.range().end());
    let fixed = chart.has_chosen_range().then_some("");
    html! {
        div.chart data-x=(ends(&time)) data-y=(ends(&value)) data-over=(chart.over) data-unit=(chart.unit)
            data-fixed=[fixed] {
            svg.plot role="img" aria-label=(description(chart, &time, &value)) style=(margin) {
                (ticks(&chart.over, &time, &value))
                svg width="100%" height="100%" viewBox=(view_box) preserveAspectRatio="none" {
                    (shades(chart, &time, legend))
                    @for series in &chart.series {
                        (curve(series, &time, &value, legend.class(series.mark(), &series.name)))
                    }
                }
            }
        }
    }
}

fn shades(chart: &Chart, time: &Axis, legend: &Legend<'_>) -> Markup {
    html! {
        @for ((mark, label), class) in &legend.entries {
            @if *mark == Mark::Shade {
                @let spans = chart.spans.iter().filter(|span| span.label == *label);
                path class=(class) data-shade="" d=(shade_path(spans, time)) {}
            }
        }
    }
}

/// What the chart shows, in words.
fn description(chart: &Chart, time: &Axis, value: &Axis) -> String {
    let range = |axis: &Axis, low: f64, high: f64| {
        let axis = axis.finer();
        format!("{} to {}", axis.label(low), axis.label(high))
    };
    let time_range = range(time, *time.range().start(), *time.range().end());
    let (quantity, unit) = chart.over.split_once(", ").unwrap_or((&chart.over, ""));
    let mut text =
        format!("{}: line chart over {quantity}, {}.", chart.title, format!("{time_range} {unit}").trim_end());
    for series in &chart.series {
        let values = match extent(series.samples.iter().map(|&(_, value)| value)) {
            Some((low, high)) => format!("{} {}", range(value, low, high), chart.unit),
            None => "no data".to_owned(),
        };
        text.push_str(&format!(" {}: {}.", series.name, values.trim_end()));
    }
    text
}

/// Grid lines and labels of both axes.
fn ticks(over: &str, time: &Axis, value: &Axis) -> Markup {
    let percent = |fraction: f64| format!("{:.2}%", 100.0 * fraction);
    html! {
        g aria-hidden="true" {
            @for tick in value.ticks() {
                @let y = percent(1.0 - value.fraction(tick));
                line.zero[tick == 0.0] x1="0" x2="100%" y1=(y) y2=(y) {}
                text.value x="0" y=(y) dx="-0.6em" dy="0.35em" { (value.label(tick)) }
            }
            @for tick in time.ticks() {
                @let x = percent(time.fraction(tick));
                line x1=(x) x2=(x) y1="0" y2="100%" {}
                text.time x=(x) y="100%" dy="1.5em" { (time.label(tick)) }
            }
            text.time x="50%" y="100%" dy="2.8em" { (over) }
        }
    }
}

fn curve(series: &Series, time: &Axis, value: &Axis, class: &str) -> Markup {
    let trace = Trace::new(&series.samples, series.interpolation, time, value);
    html! {
        @if !trace.line.is_empty() { path class=(class) data-name=(series.name) d=(trace.line) {} }
        @if !trace.dots.is_empty() { path class=(format!("dots {class}")) data-name=(series.name) d=(trace.dots) {} }
    }
}

/// Rectangles as high as the chart; those that touch are joined.
fn shade_path<'a>(spans: impl Iterator<Item = &'a Span>, time: &Axis) -> String {
    let mut intervals: Vec<(i32, i32)> = spans
        .filter(|span| span.start_s.is_finite() && span.end_s.is_finite())
        .filter(|span| span.end_s >= *time.range().start() && span.start_s <= *time.range().end())
        .map(|span| {
            let grid = |time_s: f64| (time.fraction(time_s) * f64::from(WIDTH)).round() as i32;
            let start = grid(span.start_s).min(WIDTH - LEAST_SHADE_WIDTH);
            (start, grid(span.end_s).max(start + LEAST_SHADE_WIDTH))
        })
        .collect();
    intervals.sort_unstable();
    let mut joined: Vec<(i32, i32)> = Vec::new();
    for (start, end) in intervals {
        match joined.last_mut() {
            Some(last) if start <= last.1 => last.1 = last.1.max(end),
            _ => joined.push((start, end)),
        }
    }
    joined.into_iter().map(|(start, end)| format!("M{start} 0H{end}V{HEIGHT}H{start}z")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn svg_of(chart: &Chart) -> String {
        let svg = single(chart, &mut Palette::default()).into_string();
        // Not finite numbers would show as these words.
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        roxmltree::Document::parse(&svg).expect("well-formed");
        svg
    }

    #[test]
    fn charts_without_a_sample_say_so() {
        let empty = Chart::time_series("Roll", "deg").span(0.0, 1.0, "gap");
        let invisible = empty.clone().series("PID", &[0.0, f64::NAN], &[f64::NAN, 1.0]);
        for chart in [empty.clone(), empty.series("PID", &[], &[]), invisible] {
            assert!(svg_of(&chart).contains("No data."));
        }
    }

    #[test]
    fn odd_series_are_drawn() {
        let chart =
            |time_s: &[f64], values: &[f64]| svg_of(&Chart::time_series("Roll", "").series("PID", time_s, values));
        assert!(chart(&[3.0], &[7.0]).contains(r#"d="M5000 2000h0""#), "a single point, in the middle");
        assert!(chart(&[0.0, 1.0], &[7.0, 7.0]).contains(r#"d="M0 2000l10000 0""#), "a constant");
        assert!(chart(&[2.0, 2.0], &[0.0, 1.0]).contains("M5000"), "two values at one time");
        chart(&[0.0, 1.0, 2.0], &[1e308, -1e308, 0.0]);
        chart(&[0.0, 1e-320], &[0.0, 1e-320]);
        chart(&[2.0, 0.0, 1.0], &[0.0, 1.0, 2.0]);
    }

    #[test]
    fn curves_beyond_the_chosen_range_stay_in_the_chart() {
        let chart = Chart::time_series("Motor 1", "").series("PID", &[0.0, 1.0], &[-5.0, 5.0]).value_range(0.0, 1.0);
        assert!(svg_of(&chart).contains(r#"d="M0 4000l10000-4000""#));
    }

    #[test]
    fn spans_are_clipped_joined_and_never_invisible() {
        let time = Axis::new((0.0, 100.0), 5);
        let path = |spans: &[(f64, f64)]| {
            let spans: Vec<Span> =
                spans.iter().map(|&(start_s, end_s)| Span { start_s, end_s, label: String::new() }).collect();
            shade_path(spans.iter(), &time)
        };
        assert_eq!(path(&[(-5.0, 10.0), (20.0, 30.0), (30.0, 40.0)]), "M0 0H1000V4000H0zM2000 0H4000V4000H2000z");
        assert_eq!(path(&[(50.0, 50.0)]), "M5000 0H5040V4000H5000z");
        assert_eq!(path(&[(100.0, 100.0)]), "M9960 0H10000V4000H9960z");
        assert_eq!(path(&[(101.0, 102.0), (f64::NAN, 5.0), (-2.0, -1.0), (0.0, f64::INFINITY)]), "");
        let many: Vec<(f64, f64)> =
            (0..10_000).map(|index| (f64::from(index) / 100.0, f64::from(index) / 100.0)).collect();
        assert_eq!(path(&many).matches('M').count(), 1);
    }

    #[test]
    fn the_description_tells_the_ranges() {
        let chart =
            Chart::time_series("Roll angle", "deg").series("PID", &[0.0, 30.0], &[-15.2, 14.9]).series("MPC", &[], &[]);
        let (time, value) = shared_axes(std::slice::from_ref(&chart)).expect("samples");
        assert_eq!(
            description(&chart, &time, &value),
            "Roll angle: line chart over time, 0.0 to 30.0 s. PID: −15.2 to 14.9 deg. MPC: no data."
        );
    }
}
