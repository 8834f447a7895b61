//! A diagnosis on the terminal.

use crate::diagnosis::{ClosedLoops, Condition, Diagnosis, Horizon, ModelStatistics, NO_CONTROLLER, Rejected};
use crate::log::Log;

use super::evidence::what_commands_explain;
use super::page::{Beside, base_lines, compares_more_than_turning, error_rows, fact_text, headline, interval_text};
use crate::answer::Emphasis;
use crate::answer::text_table::{TextTable, error_table, number};

/// Everything that `sil diagnose` prints of the answer.
pub fn answer_text(log: &Log, answer: &Diagnosis, emphasised: Emphasis) -> String {
    let mut text = format!("{}: {} rows, {:.2} s, {:.1} Hz\n", log.path, log.rows(), log.duration_s(), log.rate_hz());
    for note in &log.notes {
        text.push_str(&format!("  {note}\n"));
    }
    text.push_str(&verdict_text(answer, emphasised));
    text.push_str(&format!("{}\n", horizons_table(answer)));
    text.push_str(&format!("{}\n", statistics_table(answer)));
    for condition in strongest_conditions(answer) {
        text.push_str(&format!("{}\n", condition_text(condition)));
    }
    text.push_str(&excitation_text(answer));
    if !answer.separating_experiment.is_empty() {
        text.push_str(&format!("{}\n", answer.separating_experiment));
    }
    text + "\n"
}

/// What was found, and how much better the model predicts with it.
pub fn verdict_text(answer: &Diagnosis, emphasised: Emphasis) -> String {
    let mut text = format!("\n{}\n", emphasised(&headline(answer)));
    if !answer.verdict.has_a_model() && !answer.findings.is_empty() {
        text.push_str("  the best of what was tried, not a cause:\n");
    }
    for (finding, interval) in answer.findings.iter().zip(&answer.gain.findings_interval_pct) {
        let interval = interval.map(|interval| format!(" ({})", interval_text(interval))).unwrap_or_default();
        text.push_str(&format!("  {:5.1} %{interval}  {}\n", finding.gain_pct, finding.statement));
    }
    if !answer.verdict.has_a_model() {
        text.extend(what_commands_explain(answer).map(|sentence| format!("  {sentence}\n")));
    }
    if !answer.unexplained.signature.is_empty() {
        text.push_str(&format!("  unexplained: {}\n", answer.unexplained.signature));
    }
    let known: Vec<String> = answer.known.iter().map(fact_text).collect();
    if !known.is_empty() {
        text.push_str(&format!("  known, and held: {}\n", known.join(", ")));
    }
    if !answer.base.is_empty() {
        text.push_str("  fitted along with the above (the base model):\n");
        let lines = base_lines(answer).chain(answer.warnings.iter().cloned());
        text.extend(lines.map(|line| format!("    {line}\n")));
    }
    let of_controller =
        |rejected: &&Rejected| rejected.effect == "controller_mismatch" && rejected.reason != NO_CONTROLLER;
    for rejected in answer.rejected.iter().filter(of_controller) {
        text.push_str(&format!("  controller: {}\n", rejected.reason));
    }
    let errors = &answer.prediction_error;
    let title = format!("open-loop prediction over {} s, held-out windows, RMSE", errors.window_s);
    text.push('\n');
    if !compares_more_than_turning(answer) {
        text.push_str(&format!("{}\n", error_table(&title, error_rows(errors))));
    }
    text.extend(answer.closed_loop.as_ref().map(|closed_loop| format!("{}\n", closed_loop_table(closed_loop))));
    text
}

fn closed_loop_table(closed_loop: &ClosedLoops) -> TextTable {
    let mut table = TextTable::new(["closed loop, mean |simulated - measured|", "roll, deg", "pitch, deg"]);
    for (name, deviation) in [("nominal model", closed_loop.nominal), ("with the findings", closed_loop.extended)] {
        table.row([name.into(), number(deviation.roll_mean_abs_deg, 2), number(deviation.pitch_mean_abs_deg, 2)]);
    }
    table
}

fn horizons_table(answer: &Diagnosis) -> TextTable {
    let horizons = &answer.horizons;
    let beside = Beside::of(answer).unwrap_or(Beside::Findings);
    let title = format!("RMSE over: nominal > {} (exact)", beside.name());
    let mut table =
        TextTable::new(std::iter::once(title).chain(horizons.iter().map(|horizon| format!("{} s", horizon.horizon_s))));
    let Some(first) = horizons.first() else { return table };
    for error in &first.errors {
        let cell = |horizon: &Horizon| {
            let found = horizon.errors.iter().find(|other| other.quantity == error.quantity);
            found.map_or("-".to_owned(), |e| format!("{:.2} > {:.2} ({:.2})", e.nominal, e.extended, e.noise_floor))
        };
        let name = format!("{}, {}", error.quantity, error.unit);
        table.row(std::iter::once(name).chain(horizons.iter().map(cell)));
    }
    table
}

fn statistics_table(answer: &Diagnosis) -> TextTable {
    let mut table = TextTable::new([
        "held-out windows",
        "mean |error|",
        "fit, %",
        "Theil's U",
        "bias/var/cov, %",
        "Ljung-Box (bound)",
        "correlation with command (bound)",
    ]);
    for channel in &answer.statistics {
        let mut row = |name: &str, model: &ModelStatistics| {
            table.row(statistics_row(format!("{}, {}: {name}", channel.quantity, channel.unit), model));
        };
        row("nominal", &channel.nominal);
        if let Some(beside) = Beside::of(answer) {
            row(if beside == Beside::Findings { "extended" } else { "base" }, beside.figures(channel));
        }
    }
    table
}

fn statistics_row(name: String, model: &ModelStatistics) -> [String; 7] {
    let agreement = &model.agreement;
    let split = agreement.theil_split.map_or("-".to_owned(), |split| {
        format!("{:.0}/{:.0}/{:.0}", 100.0 * split.bias, 100.0 * split.variance, 100.0 * split.covariance)
    });
    let whiteness = model.ljung_box.map_or("-".to_owned(), |test| format!("{:.0} ({:.0})", test.statistic, test.bound));
    let correlation =
        model.input_correlation.map_or("-".to_owned(), |with| format!("{:.2} ({:.2})", with.correlation, with.bound));
    [
        name,
        number(agreement.mean_abs, 3),
        number(agreement.fit_pct, 1),
        number(agreement.theil, 3),
        split,
        whiteness,
        correlation,
    ]
}

/// For each axis the condition that explains most of the missing acceleration, where chance does not explain it.
fn strongest_conditions(answer: &Diagnosis) -> impl Iterator<Item = &Condition> {
    let by_axis = answer.conditions.chunk_by(|a, b| a.axis == b.axis);
    by_axis.filter_map(|of_axis| of_axis.first()).filter(|condition| condition.is_significant())
}

fn condition_text(condition: &Condition) -> String {
    let of = if condition.condition == "constant" { "mean square" } else { "variance" };
    let shares = format!(
        "{:.0} % of its {of}, {:.0} % with the findings in the model; chance reaches {:.0} %",
        condition.nominal_pct, condition.extended_pct, condition.chance_pct
    );
    match condition.condition {
        "constant" => {
            format!("{}: the acceleration that the nominal model lacks is mostly constant ({shares})", condition.axis)
        }
        with => format!(
            "{}: the acceleration that the nominal model lacks depends most on the {with} ({shares})",
            condition.axis
        ),
    }
}

fn excitation_text(answer: &Diagnosis) -> String {
    let excitation = &answer.excitation;
    let mut text = String::new();
    if let Some(number) = excitation.condition_number {
        text.push_str(&format!("excitation: condition number {number:.1} (1 to 1000 is usable)"));
        if let Some(number) = excitation.findings_condition_number {
            text.push_str(&format!("; of the findings' parameters {number:.1}"));
        }
        text.push('\n');
    }
    for weakness in &excitation.weaknesses {
        text.push_str(&format!("  {weakness}\n"));
    }
    text
}
