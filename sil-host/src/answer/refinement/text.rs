//! A refinement on the terminal: constants, forms side by side, what can't be.

use super::cost::evaluation_ns;
use crate::answer::text_table::TextTable;
use crate::refinement::{Check, Comparison, Constant, Found, Refined};

/// All of it.
pub fn text(refined: &Refined) -> String {
    let mut text = String::new();
    for note in &refined.notes {
        text.push_str(&format!("{note}\n"));
    }
    text.push_str(&format!("\n{}", constants(&refined.constants)));
    let runs = runs(&refined.constants);
    if !runs.is_empty() {
        text.push_str(&format!("\n{runs}"));
    }
    text.push_str(&format!("\n{}", forms(&refined.comparisons)));
    text.push_str(
        "Errors are mean absolute ones. A formula's parameters can be varied in a study, as a propeller that lifts a \
         fifth more; a table stands for the one component that was measured.\n",
    );
    text.push_str(&format!("\n{}", checks_text(&refined.checks)));
    text
}

fn constants(constants: &[Constant]) -> TextTable {
    let mut table = TextTable::new(["constant", "value", "95 % interval", "unit", "form", "readings", "outliers"]);
    for one in constants {
        table.row([
            named(one),
            one.rounded(one.value),
            format!("{} to {}", one.rounded(one.interval[0]), one.rounded(one.interval[1])),
            one.unit.to_owned(),
            one.form.to_owned(),
            one.readings.to_string(),
            one.outliers.to_string(),
        ]);
    }
    table
}

/// What a number of the stand itself is called.
fn named(constant: &Constant) -> String {
    match constant.key {
        "" => format!("(offset of the stand: {})", constant.component.name()),
        key => key.to_owned(),
    }
}

fn runs(constants: &[Constant]) -> String {
    let shown: Vec<&Constant> = constants.iter().filter(|one| !one.key.is_empty() && !one.runs.is_empty()).collect();
    if shown.is_empty() {
        return String::new();
    }
    let mut table = TextTable::new(["by file", "value", "95 % interval", "file"]);
    for one in shown {
        for run in &one.runs {
            table.row([
                one.key.to_owned(),
                one.rounded(run.value),
                format!("{} to {}", one.rounded(run.interval[0]), one.rounded(run.interval[1])),
                run.source.clone(),
            ]);
        }
    }
    table.to_string()
}

fn forms(comparisons: &[Comparison]) -> TextTable {
    let mut table = TextTable::new([
        "component",
        "form",
        "error when left out",
        "on held-out files",
        "unit",
        "numbers",
        "ns a value",
        "",
    ]);
    for comparison in comparisons {
        for (index, candidate) in comparison.candidates.iter().enumerate() {
            let taken = match (index == comparison.chosen, comparison.is_requested) {
                (true, true) => "taken (--form)",
                (true, false) => "taken",
                _ => comparison.component.not_by_itself(candidate.fitted.form()).unwrap_or_default(),
            };
            table.row([
                comparison.component.name().to_owned(),
                candidate.fitted.form().name().to_owned(),
                format!("{:.3e}", candidate.held_out),
                candidate.unseen.map_or("-".to_owned(), |error| format!("{error:.3e}")),
                comparison.component.axes()[1].1.to_owned(),
                candidate.fitted.numbers().to_string(),
                format!("{:.0}", evaluation_ns(&candidate.fitted, &comparison.points.x)),
                taken.to_owned(),
            ]);
        }
    }
    table
}

/// What can't be first, then what passed, then what was not checked.
pub fn checks_text(checks: &[Check]) -> String {
    let mut text = String::new();
    for (found, head) in
        [(Found::Impossible, "CAN'T BE"), (Found::Plausible, "plausible"), (Found::NotChecked, "not checked")]
    {
        for check in checks.iter().filter(|check| check.found == found) {
            text.push_str(&format!("{head}: {}: {}\n", check.name, check.says));
        }
    }
    text
}
