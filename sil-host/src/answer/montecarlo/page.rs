//! The page of a study: who is lost, how the figures are spread, what they come from, the worst vehicles.

use super::{Lost, StudyAnswer, StudyFigure, shown};
use crate::montecarlo::Sample;
use crate::report::{Bars, Card, Cell, Chart, Page, Section, Table, Tone};

/// Points of a drawn distribution.
const CURVE_POINTS: usize = 200;

/// Influences that are drawn of a figure.
const SHOWN: usize = 6;

/// Figures whose distribution and causes are drawn: what follows the controller's name.
const DRAWN: [&str; 6] = [
    "roll.rms_error_deg",
    "pitch.rms_error_deg",
    "roll.overshoot_pct",
    "pitch.overshoot_pct",
    "roll.largest_late_error_deg",
    "pitch.largest_late_error_deg",
];

/// A page of its own.
pub fn page(answer: &StudyAnswer, command: &str) -> Page {
    let lost: Vec<Lost<'_>> = answer.lost().collect();
    let all_fly = lost.iter().all(|lost| lost.count == 0);
    let mut card = Card::new(if all_fly { Tone::Good } else { Tone::Doubtful });
    for lost in &lost {
        card = card.line(format!("{} lost", lost.controller), lost_text(lost, answer.summary.rows()));
    }
    for name in &DRAWN[..2] {
        for figure in answer.figures().filter(|figure| is_of(figure, name)) {
            let quantiles = [0.05, 0.5, 0.95].map(|share| shown(figure.sample.quantile(share)));
            let [low, middle, high] = quantiles;
            card = card.line(figure.name, format!("{middle}, 90 % of the vehicles from {low} to {high}"));
        }
    }
    let mut page = Page::new(headline(&lost, answer.summary.rows()))
        .about(answer.title())
        .lead(
            "Each vehicle has parts of its own, drawn from the tolerances of the model file, and flies under the \
             controller that was made for the nominal one.",
        )
        .card(card)
        .section(spread(answer))
        .section(quantiles(answer))
        .section(causes(answer))
        .section(worst(answer));
    if let Some(sampling) = answer.sampling() {
        page = page.section(Section::new("Sampling").paragraph(sampling));
    }
    page.provenance("Command", command)
        .provenance("Version", env!("CARGO_PKG_VERSION"))
        .provenance("Seed", answer.about.seed.to_string())
}

fn headline(lost: &[Lost<'_>], rows: u64) -> String {
    let of = |lost: &Lost<'_>| match lost.count {
        0 => format!("{} loses none", lost.controller),
        count => format!("{} loses {count}", lost.controller),
    };
    format!("Of {rows} vehicles {}", lost.iter().map(of).collect::<Vec<_>>().join(", "))
}

fn lost_text(lost: &Lost<'_>, rows: u64) -> String {
    let [low, high] = lost.interval.map(|share| 100.0 * share);
    format!("{} of {rows} (95 % interval {low:.2} to {high:.2} %)", lost.count)
}

fn is_of(figure: &StudyFigure<'_>, name: &str) -> bool {
    figure.name.strip_suffix(name).is_some_and(|controller| controller.ends_with('.'))
}

fn spread(answer: &StudyAnswer) -> Section {
    let chart = |name: &&str| {
        let mut chart = Chart::over(*name, "vehicles below", "%");
        for figure in answer.figures().filter(|figure| is_of(figure, name)) {
            let (values, percent) = cumulative(figure.sample);
            chart = chart.series(figure.name.trim_end_matches(name).trim_end_matches('.'), &values, &percent);
        }
        chart.value_range(0.0, 100.0)
    };
    Section::new("How they are spread")
        .paragraph("Share of the vehicles, in percent, that stay below a figure: the steeper, the more alike they fly.")
        .side_by_side("Cumulative distributions", DRAWN.iter().map(chart))
}

/// A distribution as a curve; flights without the figure keep it from reaching 100 %.
fn cumulative(sample: &Sample) -> (Vec<f64>, Vec<f64>) {
    let shares = (0..=CURVE_POINTS).map(|index| index as f64 / CURVE_POINTS as f64);
    shares.filter_map(|share| Some((sample.quantile(share)?, 100.0 * share))).unzip()
}

fn quantiles(answer: &StudyAnswer) -> Section {
    let mut table = Table::new(
        "Figures over all vehicles",
        &["figure", "nominal", "least", "5 %", "median", "95 %", "99 %", "worst", "without"],
    );
    for figure in answer.figures() {
        let worst = figure.sample.worst.first().and_then(|worst| worst.value);
        let least = (figure.sample.count > 0).then_some(figure.sample.min);
        let quantiles = [0.05, 0.5, 0.95, 0.99].map(|share| shown(figure.sample.quantile(share)));
        let cells = [figure.name.to_owned(), shown(figure.nominal), shown(least)].into_iter().chain(quantiles);
        table = table.row(cells.chain([shown(worst), figure.sample.missing.to_string()]).map(Cell::from));
    }
    Section::new("Every figure").table(table).note(
        "A dash, and the last column: flights without the figure, such as one that never settles; they are the worst.",
    )
}

fn causes(answer: &StudyAnswer) -> Section {
    let mut section = Section::new("What it comes from").paragraph(
        "Standardised rank regression: by how many standard deviations of its rank a figure changes with one of a \
         number's rank, in percent, with the 95 % interval; minus where more of the number makes less of the figure. \
         The rest is noise of the sensors, and what is not monotone.",
    );
    let mut is_empty = true;
    for name in DRAWN {
        for figure in answer.figures().filter(|figure| is_of(figure, name)) {
            let Some(sensitivity) = figure.sensitivity else { continue };
            let explained = 100.0 * sensitivity.explained;
            let mut bars = Bars::new(format!("{}: {explained:.0} % explained", figure.name));
            for influence in sensitivity.influences.iter().filter(|influence| influence.is_seen()).take(SHOWN) {
                let sign = if influence.coefficient < 0.0 { "\u{2212}" } else { "+" };
                let size = influence.coefficient.abs();
                let interval = [size - influence.half_interval, size + influence.half_interval];
                let interval = interval.map(|end| 100.0 * end);
                bars = bars.bar(format!("{sign} {}", influence.of), 100.0 * size, Some(interval));
            }
            section = section.bars(bars);
            is_empty = false;
        }
    }
    if is_empty { section.note("It takes more runs than numbers drawn, and figures that differ.") } else { section }
}

fn worst(answer: &StudyAnswer) -> Section {
    let mut table = Table::new("The worst vehicles", &["run", "worst in"]);
    let mut lines = Vec::new();
    for (run, figures) in answer.worst() {
        let named: Vec<String> =
            figures.iter().map(|(figure, value)| format!("{} {}", figure.name, shown(*value))).collect();
        lines.extend(figures.iter().map(|(figure, _)| answer.about.command(run, figure.name)));
        table = table.row([run.to_string(), named.join(", ")].map(Cell::from));
    }
    lines.dedup();
    Section::new("The worst").table(table).paragraph("Flown again, to the bit, by:").code(lines.join("\n"))
}
