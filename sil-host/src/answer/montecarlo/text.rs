//! A study on the terminal.

use super::{StudyAnswer, shown};
use crate::answer::text_table::TextTable;
use crate::montecarlo::{Draw, DrawnVehicle, Influence, Lot};

/// Influences that are shown of a figure.
const SHOWN: usize = 2;

/// Numbers of a drawn vehicle that are named.
const FURTHEST: usize = 4;

/// What is particular about a drawn vehicle.
pub fn drawn_text(lot: &Lot, draw: Draw, vehicle: &DrawnVehicle) -> String {
    let nominal = lot.nominal_values();
    // of a value of 0 the deviation has no share
    let share =
        |(value, nominal): (f64, f64)| if nominal == 0.0 { 0.0 } else { 100.0 * (value - nominal) / nominal.abs() };
    let shares = vehicle.values.iter().copied().zip(nominal).map(share);
    let mut named: Vec<(String, f64)> = lot.columns().into_iter().zip(shares).collect();
    named.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let furthest: Vec<String> =
        named.iter().take(FURTHEST).map(|(name, share)| format!("{name} {share:+.1} %")).collect();
    format!("drawn vehicle {draw}, furthest from the model's numbers: {}\n", furthest.join(", "))
}

/// All of it.
pub fn text(answer: &StudyAnswer) -> String {
    let mut text = format!("{}\n\n{}", answer.title(), quantiles(answer));
    text.push_str("\"-\" and \"without\": flights that do not have the figure, such as those that never settle.\n");
    if let Some(sampling) = answer.sampling() {
        text.push_str(&format!("{sampling}\n"));
    }
    text.push('\n');
    for lost in answer.lost() {
        let (rows, percent) = (answer.summary.rows(), lost.interval.map(|share| 100.0 * share));
        text.push_str(&format!(
            "{}: {} of {rows} flights lost (95 % interval {:.2} to {:.2} %)\n",
            lost.controller, lost.count, percent[0], percent[1]
        ));
        for run in lost.runs {
            text.push_str(&format!("  {}\n", answer.about.command(run, &format!("{}.", lost.controller))));
        }
    }
    text.push_str(&format!("\n{}", causes(answer)));
    text.push_str(&format!("\n{}", worst(answer)));
    text
}

fn quantiles(answer: &StudyAnswer) -> TextTable {
    let mut table =
        TextTable::new(["figure", "nominal", "least", "5 %", "median", "95 %", "99 %", "worst", "in run", "without"]);
    for figure in answer.figures() {
        let quantile = |share: f64| shown(figure.sample.quantile(share));
        let worst = figure.sample.worst.first();
        table.row([
            figure.name.to_owned(),
            shown(figure.nominal),
            shown((figure.sample.count > 0).then_some(figure.sample.min)),
            quantile(0.05),
            quantile(0.5),
            quantile(0.95),
            quantile(0.99),
            shown(worst.and_then(|worst| worst.value)),
            worst.map_or_else(String::new, |worst| worst.run.to_string()),
            figure.sample.missing.to_string(),
        ]);
    }
    table
}

fn causes(answer: &StudyAnswer) -> String {
    let mut text = String::new();
    for figure in answer.figures() {
        let Some(sensitivity) = figure.sensitivity else { continue };
        let seen = sensitivity.influences.iter().filter(|influence| influence.is_seen());
        let seen: Vec<String> = seen.take(SHOWN).map(influence_text).collect();
        let explained = 100.0 * sensitivity.explained;
        text.push_str(&format!("{:<32} {explained:>3.0} %  {}\n", figure.name, seen.join("; ")));
    }
    if text.is_empty() {
        return "Which tolerance a figure comes from takes more runs than numbers drawn, and figures that differ.\n"
            .into();
    }
    format!(
        "What the figures come from: explained share, then the largest influences\n{text}Standardised rank regression: \
         standard deviations of the figure's rank per one of the number's, with the 95 %\ninterval. What is not \
         explained is noise of the sensors, and what is not monotone.\n"
    )
}

/// `+0.41 +-0.03 propulsion.rotor.lift_n_s2.motor1`.
fn influence_text(influence: &Influence) -> String {
    format!("{:+.2} +-{:.2} {}", influence.coefficient, influence.half_interval, influence.of)
}

fn worst(answer: &StudyAnswer) -> String {
    let mut text = "The worst vehicles, and the command that flies each again\n".to_owned();
    for (run, figures) in answer.worst() {
        let named: Vec<String> =
            figures.iter().map(|(figure, value)| format!("{} {}", figure.name, shown(*value))).collect();
        let mut commands: Vec<String> =
            figures.iter().map(|(figure, _)| answer.about.command(run, figure.name)).collect();
        commands.dedup();
        text.push_str(&format!("  run {run}: {}\n", named.join(", ")));
        for command in commands {
            text.push_str(&format!("    {command}\n"));
        }
    }
    text
}
