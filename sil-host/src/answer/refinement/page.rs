//! The page of a refinement: each component's readings with its forms, and what they leave (the thesis' figures C.2 to
//! C.7), the constants, the checks.

use crate::refinement::{Check, Comparison, Fitted, Found, Refined};
use crate::report::{Card, Cell, Chart, Page, Section, Table, Tone};

/// Points of a drawn curve.
const CURVE_POINTS: usize = 200;

/// A page of its own.
pub fn page(refined: &Refined, command: &str) -> Page {
    let impossible = refined.checks.iter().filter(|check| check.found == Found::Impossible).count();
    let headline = match impossible {
        0 => format!("{} constants measured, none that can't be", measured(refined)),
        count => format!("{} constants measured, {count} checks say that something can't be", measured(refined)),
    };
    let tone = if impossible == 0 { Tone::Good } else { Tone::Doubtful };
    let mut card = Card::new(tone);
    for constant in refined.constants.iter().filter(|constant| !constant.key.is_empty()) {
        card = card.line(constant.key, constant.in_words());
    }
    let mut page = Page::new(headline)
        .about(format!("Refined from bench measurements: {}", refined.base))
        .lead(
            "Robust fits: readings far off the curve have no influence. Held-out errors are of readings left out of \
             the fit, one at a time.",
        )
        .card(card);
    page = page.section(about_checks(&refined.checks));
    for comparison in &refined.comparisons {
        page = page.section(component(comparison));
    }
    if !refined.notes.is_empty() {
        page = page.section(Section::new("Notes").list(refined.notes.clone()));
    }
    page.provenance("Command", command).provenance("Version", env!("CARGO_PKG_VERSION"))
}

fn measured(refined: &Refined) -> usize {
    refined.constants.iter().filter(|constant| !constant.key.is_empty()).count()
}

fn about_checks(checks: &[Check]) -> Section {
    let mut table = Table::new("Plausibility", &["check", "result", "why"]);
    for check in checks {
        let result = match check.found {
            Found::Plausible => "plausible",
            Found::Impossible => "can't be",
            Found::NotChecked => "not checked",
        };
        table = table.row([Cell::from(check.name), result.into(), check.says.clone().into()]);
    }
    Section::new("Can it be?").table(table)
}

fn component(comparison: &Comparison) -> Section {
    let [(over, over_unit), (quantity, unit)] = comparison.component.axes();
    let over = if over_unit.is_empty() { over.to_owned() } else { format!("{over}, {over_unit}") };
    let points = &comparison.points;
    let extent = points.x.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    let grid: Vec<f64> =
        (0..=CURVE_POINTS).map(|index| extent.0 + (extent.1 - extent.0) * index as f64 / CURVE_POINTS as f64).collect();
    let mut curves = Chart::over(over.clone(), quantity, unit).points("measured", &points.x, &points.y);
    let mut left = Chart::over(over, "measured less the form", unit);
    let mut table = Table::new(
        "Forms side by side",
        &["form", "numbers", "error when left out", "error on held-out files", "equation and parameters"],
    );
    for (index, candidate) in comparison.candidates.iter().enumerate() {
        let name = candidate.fitted.form().name();
        let values: Vec<f64> = grid.iter().map(|x| candidate.fitted.value(*x)).collect();
        curves = curves.series(name, &grid, &values);
        // a table goes through its readings: what it leaves is nothing
        if let Fitted::Formula(..) = candidate.fitted {
            let residual: Vec<f64> =
                points.x.iter().zip(&points.y).map(|(x, y)| y - candidate.fitted.value(*x)).collect();
            left = left.points(name, &points.x, &residual);
        }
        let held_out = Cell::from(format!("{:.3e} {unit}", candidate.held_out));
        let held_out = if index == comparison.chosen { held_out.better() } else { held_out };
        table = table.row([
            Cell::from(name),
            Cell::number(candidate.fitted.numbers() as f64, 0),
            held_out,
            Cell::from(candidate.unseen.map_or(String::new(), |error| format!("{error:.3e} {unit}"))),
            with_parameters(&candidate.fitted).into(),
        ]);
    }
    let taken = comparison.taken().fitted.form().name();
    let why = if comparison.is_requested { "requested" } else { "the simplest form as good as the best" };
    Section::new(format!("{}: {taken}", comparison.component.name().replace('_', " ")))
        .paragraph(format!("Taken: {taken}, {why}."))
        .chart(curves)
        .chart(left)
        .table(table)
}

fn with_parameters(fitted: &Fitted) -> String {
    match fitted {
        Fitted::Table(table) => format!("{} points", table.points().len()),
        Fitted::Formula(formula, fit) => {
            let named = formula.parameters.iter().zip(fit.parameters.iter().zip(&fit.std));
            let named = named.map(|(name, (value, std))| format!("{name} {value:.4e} \u{b1} {std:.1e}"));
            format!("{}: {}", formula.equation, named.collect::<Vec<_>>().join(", "))
        }
    }
}
