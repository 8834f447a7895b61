//! A flight against normal flights, on the terminal and as a page.

use crate::diagnosis::{AtVoltage, BaselineDiagnosis, BetweenFlights, Compared, Difference, Verdict};
use crate::report::{Card, Cell, Page, Section, Table, Tone};

use super::diagnosis::page::fact_text;
use super::plain_words::on_a_page;
use super::text_table::{TextTable, number};

/// Columns of the table of numbers.
const COLUMNS: [&str; 6] = ["number", "unit", "normal flights", "spread", "this flight", "z"];

/// The answer in a sentence; causes follow.
fn headline(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoDiscrepancy => "A normal flight: it differs from the others by no more than these differ by.",
        Verdict::Explained => "How this flight differs from normal ones (nothing beyond chance remains):",
        Verdict::PartlyExplained => "How this flight differs from normal ones (more differs than this explains):",
        // no model is judged here
        Verdict::UnknownEffect | Verdict::NotAModel | Verdict::NotShown => {
            "This flight differs from normal ones, and no single cause of the catalogue explains it."
        }
    }
}

/// What is said of a cause, its alternatives behind it.
fn lines(difference: &Difference) -> Vec<String> {
    let mut lines = vec![difference.statement.clone()];
    lines.extend(difference.one_of.iter().map(|other| format!("or: {}", other.statement)));
    if !difference.told_apart_by.is_empty() {
        lines.push(difference.told_apart_by.clone());
    }
    lines
}

/// How much the spread rests on these flights, and what was tried.
fn basis(answer: &BaselineDiagnosis) -> String {
    let baseline = &answer.baseline;
    let flights = baseline.logs.len();
    let alone = if flights == 1 { " One flight alone shows no spread." } else { "" };
    let chance = chance_text(baseline.chance);
    if baseline.between == BetweenFlights::SameFlight {
        return format!(
            "{} is a record of the same flight: gusts and manoeuvres are in both, and only what was recorded \
             differently is compared, stretch by stretch. {} causes were tried. The chance of such departures between \
             equal records, all numbers together: {chance}.",
            baseline.logs.join(", "),
            baseline.looks
        );
    }
    let usual = baseline.usual_spread_as_flights;
    let between = match baseline.between {
        BetweenFlights::Untouched => "of a vehicle that nobody touched between flights",
        _ => "of a vehicle whose propellers were changed or seated anew between flights",
    };
    format!(
        "Normal flights: {flights}.{alone} {}Their spread is estimated from them and from a usual one, {between}, \
         which counts as much as {usual:.0} flights. {}{} causes were tried. The chance of such departures in a normal \
         flight, all numbers together: {chance}.",
        not_steady_text(&baseline.not_steady),
        baseline.at_voltage.as_ref().map_or_else(String::new, voltage_text),
        baseline.looks
    )
}

/// Which logs show no steady flight.
fn not_steady_text(logs: &[String]) -> String {
    if logs.is_empty() {
        return String::new();
    }
    format!(
        "In {} the motors' mean command strays by more than a tenth, or stands still, for more than a third of the \
         time (run-ups on the ground, idling, hops, acrobatics), so that neither trims nor collective are taken from \
         it. ",
        logs.join(", ")
    )
}

/// At which voltage normal flights are held.
fn voltage_text(at: &AtVoltage) -> String {
    let AtVoltage { battery_v, normal_battery_v, follows } = at;
    format!(
        "They flew at {normal_battery_v:.2} V and are given as at the {battery_v:.2} V of this flight: steady commands \
         go as the voltage to the power of {} ± {}. ",
        number(-follows.value, 1),
        number(follows.std, 1)
    )
}

fn chance_text(chance: f64) -> String {
    if chance < 1e-3 { format!("{chance:.0e}") } else { format!("{chance:.3}") }
}

/// With the chance that all looks leave.
fn with_chance(difference: &Difference) -> Vec<String> {
    let mut lines = lines(difference);
    if let Some(chance) = difference.chance {
        lines[0] += &format!("; chance in a normal flight {}", chance_text(chance));
    }
    lines
}

fn nearest_text(difference: &Difference) -> String {
    let chance = difference.chance.map_or_else(String::new, chance_text);
    format!(
        "Nothing is reported. If anything has changed, it is most likely this, but a normal flight shows as much \
         with a chance of {chance}: {}.",
        lines(difference).join("; ").trim_end_matches('.')
    )
}

fn cells(compared: &Compared) -> ([String; 2], [f64; 4]) {
    let (factor, unit) = compared.of.shown();
    let values = [factor * compared.normal, factor * compared.spread, factor * compared.value, compared.z];
    ([compared.of.to_string(), unit.to_owned()], values)
}

/// What is printed.
pub fn text(answer: &BaselineDiagnosis) -> String {
    let mut text = format!("{}: {} rows, {:.2} s\n", answer.log.path, answer.log.rows, answer.log.duration_s);
    text.extend(answer.baseline.logs.iter().map(|log| format!("  normal: {log}\n")));
    text.push_str(&format!("\n{}\n", headline(answer.verdict)));
    for difference in &answer.findings {
        text.extend(with_chance(difference).iter().map(|line| format!("  {line}\n")));
    }
    text.extend(answer.nearest.as_ref().map(|nearest| format!("  {}\n", nearest_text(nearest))));
    text.extend(answer.known.iter().map(|fact| format!("  known: {}\n", fact_text(fact))));
    let mut table = TextTable::new(COLUMNS);
    for compared in &answer.baseline.numbers {
        let (names, values) = cells(compared);
        table.row(names.into_iter().chain(values.map(|value| number(value, 2))));
    }
    format!("{text}\n{table}\n{}\n", basis(answer))
}

fn card(answer: &BaselineDiagnosis) -> Card {
    let (tone, verdict) = match answer.verdict {
        Verdict::NoDiscrepancy => (Tone::Good, "A normal flight"),
        Verdict::Explained => (Tone::Doubtful, "Different, and explained"),
        Verdict::PartlyExplained => (Tone::Bad, "Different, for more than this reason"),
        Verdict::UnknownEffect | Verdict::NotAModel | Verdict::NotShown => {
            (Tone::Bad, "Different, and no single cause explains it")
        }
    };
    let others: Vec<&str> =
        answer.findings.iter().flat_map(|of| &of.one_of).map(|other| other.statement.as_str()).collect();
    Card::new(tone)
        .line("Verdict", verdict)
        .line("Or", on_a_page(&others.join("; ")))
        .line("Chance of as much in a normal flight", chance_text(answer.baseline.chance))
}

/// A page of its own.
pub fn page(answer: &BaselineDiagnosis, command: &str) -> Page {
    let mut causes = Section::new("The difference");
    for difference in &answer.findings {
        causes = causes.list(with_chance(difference).iter().map(|line| on_a_page(line)));
    }
    if let Some(nearest) = &answer.nearest {
        causes = causes.paragraph(nearest_text(nearest));
    }
    if !answer.known.is_empty() {
        let known: Vec<String> = answer.known.iter().map(fact_text).collect();
        causes = causes.paragraph(format!("Known, and held: {}.", known.join(", ")));
    }
    let caption = "Numbers of this flight beside those of normal ones; z in standard deviations of one more normal \
                   flight from their mean";
    let mut table = Table::new(caption, &COLUMNS);
    for compared in &answer.baseline.numbers {
        let (names, values) = cells(compared);
        table = table.row(names.map(Cell::from).into_iter().chain(values.map(|value| Cell::number(value, 2))));
    }
    let numbers = Section::new("The numbers").table(table).paragraph(
        "A trim is by how much each motor's command is off the mean of all, as that axis needs it in steady flight. \
         The spread is the standard deviation between normal flights.",
    );
    let logs = Section::new("Normal flights").paragraph(basis(answer)).list(answer.baseline.logs.clone());
    let title = match answer.findings.first() {
        // the interval stands below
        Some(first) => on_a_page(first.statement.split(" (95 %").next().unwrap_or_default().trim_end_matches('.')),
        None => headline(answer.verdict).trim_end_matches([':', '.']).to_owned(),
    };
    Page::new(title)
        .about(format!(
            "{}, {:.1} s, against {} normal flights",
            answer.log.path,
            answer.log.duration_s,
            answer.baseline.logs.len()
        ))
        .card(card(answer))
        .section(causes)
        .section(numbers)
        .section(logs.folded())
        .provenance("Command", command)
        .provenance("Version", env!("CARGO_PKG_VERSION"))
}
