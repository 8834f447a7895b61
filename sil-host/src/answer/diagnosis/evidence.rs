//! The page's evidence: where the error arises, what remains of it, and what the log cannot show.

use crate::diagnosis::{ChannelStatistics, Condition, Diagnosis, ModelStatistics};
use crate::log::Log;
use crate::report::{Cell, Chart, Section, Table};
use crate::statistics::decimals;

use super::page::Beside;
use crate::answer::plain_words::{capitalised, quantity, unit};

/// Conditions drawn per axis: the strongest ones.
const DRAWN_PER_AXIS: usize = 2;

/// Under which conditions the errors arise.
pub fn where_it_arises(answer: &Diagnosis) -> Section {
    let mut section = Section::new("Where it arises").paragraph(
        "From the measured state in each row the rate is predicted 40 ms ahead. The difference between measured and \
         predicted rate is an angular acceleration that the model lacks. It is drawn here over the vehicle's angle, \
         rate, command and so on. A right model gives a flat line at zero; a spring gives a slope over the angle, \
         friction a slope over the rate, a constant moment an offset.",
    );
    for of_axis in answer.conditions.chunk_by(|a, b| a.axis == b.axis) {
        let axis = capitalised(of_axis[0].axis);
        let significant: Vec<&Condition> = of_axis.iter().filter(|condition| condition.is_significant()).collect();
        if significant.is_empty() {
            section = section.paragraph(format!("{axis}: no missing acceleration beyond what chance explains."));
            continue;
        }
        let shapes = significant.iter().filter(|condition| condition.nominal_bins.len() > 1);
        // a constant alone is a level over whatever it is drawn over
        let angle = of_axis.iter().filter(|condition| condition.condition == "angle");
        let mut drawn: Vec<&Condition> = shapes.copied().take(DRAWN_PER_AXIS).collect();
        if drawn.is_empty() {
            drawn.extend(angle);
        }
        section = section.side_by_side(axis, drawn.into_iter().map(|condition| condition_chart(condition, answer)));
    }
    let mut table = Table::new(
        "Share of the missing acceleration's variance that a condition explains (for constant: share of its mean \
         square)",
        &["axis", "condition", "nominal model, %", "with the findings, %", "reached by chance, %"],
    );
    for condition in &answer.conditions {
        table = table.row([
            Cell::from(condition.axis),
            Cell::from(condition.condition),
            Cell::number(condition.nominal_pct, 1),
            Cell::number(condition.extended_pct, 1),
            Cell::number(condition.chance_pct, 1),
        ]);
    }
    section.table(table)
}

fn condition_chart(condition: &Condition, answer: &Diagnosis) -> Chart {
    let unit = if condition.unit.is_empty() { String::new() } else { format!(", {}", condition.unit) };
    let chart = Chart::over(
        format!("{}{unit}", condition.condition),
        format!("missing, over {}", condition.condition),
        "deg/s²",
    );
    let curves = [("nominal model", &condition.nominal_bins), ("with the findings", &condition.extended_bins)];
    let shown = if answer.findings.is_empty() { &curves[..1] } else { &curves[..] };
    shown.iter().fold(chart, |chart, (name, bins)| {
        let (at, means): (Vec<f64>, Vec<f64>) = bins.iter().map(|bin| (bin.condition, bin.mean)).unzip();
        chart.series(*name, &at, &means)
    })
}

/// What remains with the findings in the model.
pub fn unexplained(log: &Log, answer: &Diagnosis) -> Section {
    let left = &answer.unexplained;
    let mut section = Section::new("What remains unexplained").paragraph(format!(
        "{:.1} % of the nominal model's squared error on the held-out windows, noise aside, remains; the residuals are \
         {}.",
        left.variance_pct,
        if left.white { "white, as noise is" } else { "not white: something is still missing" }
    ));
    if !left.signature.is_empty() {
        section = section.note(left.signature.clone());
    }
    let spectra: Vec<Chart> = answer
        .spectra
        .iter()
        .map(|spectrum| {
            let title = format!("{}, missing acceleration", capitalised(spectrum.axis));
            let chart = Chart::over("frequency, Hz", title, "deg/s²");
            let chart = chart.series("nominal model", &spectrum.frequency_hz, &spectrum.nominal_deg_s2);
            if answer.findings.is_empty() {
                chart
            } else {
                chart.series("with the findings", &spectrum.frequency_hz, &spectrum.extended_deg_s2)
            }
        })
        .collect();
    if !spectra.is_empty() {
        section = section.small_multiples(
            "Spectrum of the missing acceleration: amplitude over frequency. The gyro's noise alone gives a smooth \
             curve that rises slowly; a peak is a vibration or a periodic disturbance, a rise at the left end a slow \
             change.",
            spectra,
        );
    }
    section = section
        .table(sizes(answer))
        .paragraph(
            "Fit: 100 % is perfect, 0 % no better than the mean of the measurement. Theil's U: 0 is perfect, 1 \
             unrelated; its shares say whether the error is an offset (bias), a wrong size of the motion (variance) or \
             neither (covariance).",
        )
        .table(structures(answer))
        .paragraph(
            "A right model leaves white noise that is uncorrelated with the command. Chance exceeds the bounds in one \
             case of a hundred; a residual well above them has a structure that the model lacks.",
        );
    section.list(log.notes.iter().cloned())
}

/// A table with a row per channel and model.
fn statistics<const N: usize>(
    answer: &Diagnosis,
    caption: &str,
    header: [&str; N],
    cells: impl Fn(&ModelStatistics) -> [Cell; N],
) -> Table {
    let header: Vec<&str> = ["", "model"].into_iter().chain(header).collect();
    let mut table = Table::new(caption, &header);
    for channel in &answer.statistics {
        let name = format!("{}, {}", quantity(channel.quantity), unit(channel.unit));
        table = table.row([Cell::from(name), "nominal".into()].into_iter().chain(cells(&channel.nominal)));
        if let Some(beside) = Beside::of(answer) {
            let model = if beside == Beside::Findings { "findings" } else { "base" };
            table = table.row([Cell::from(""), model.into()].into_iter().chain(cells(beside.figures(channel))));
        }
    }
    table
}

fn number(value: Option<f64>, decimals: usize) -> Cell {
    Cell::number(value.unwrap_or(f64::NAN), decimals)
}

fn sizes(answer: &Diagnosis) -> Table {
    let header = ["mean |error|", "fit, %", "Theil's U", "bias, %", "variance, %", "covariance, %"];
    statistics(answer, "Size of the error over the held-out windows", header, |of| {
        let split = of.agreement.theil_split;
        let percent = |share: Option<f64>| number(share.map(|share| 100.0 * share), 0);
        [
            Cell::number(of.agreement.mean_abs, 3),
            number(of.agreement.fit_pct, 1),
            number(of.agreement.theil, 3),
            percent(split.map(|split| split.bias)),
            percent(split.map(|split| split.variance)),
            percent(split.map(|split| split.covariance)),
        ]
    })
}

fn structures(answer: &Diagnosis) -> Table {
    let header = ["Ljung and Box's Q", "bound", "correlation with the command", "bound"];
    statistics(
        answer,
        "Structure of the residuals in the held-out windows, each started from its best-fitting state",
        header,
        |of| {
            [
                number(of.ljung_box.map(|test| test.statistic), 0),
                number(of.ljung_box.map(|test| test.bound), 0),
                number(of.input_correlation.map(|with| with.correlation), 2),
                number(of.input_correlation.map(|with| with.bound), 2),
            ]
        },
    )
}

/// Effects that the log cannot separate, what it does not excite, and the flight that would help.
pub fn what_cannot_be_shown(answer: &Diagnosis) -> Section {
    let mut section = Section::new("What this log cannot show");
    let doubts = answer.findings.iter().filter(|finding| !finding.confounded_with.is_empty());
    let doubts: Vec<String> = doubts
        .map(|finding| {
            format!("{} cannot be separated from {} by this log.", finding.effect, finding.confounded_with.join(" or "))
        })
        .chain(answer.excitation.weaknesses.iter().cloned())
        .collect();
    section = if doubts.is_empty() {
        section.paragraph("Nothing is in doubt: no other effect fits as well, and the log excites every axis enough.")
    } else {
        section.list(doubts)
    };
    if !answer.separating_experiment.is_empty() {
        section = section.note(answer.separating_experiment.clone());
    }
    if let Some(scenario) = answer.experiment.as_ref().and_then(|experiment| experiment.scenario.as_ref()) {
        section = section.paragraph("As a script for sil fly --script:").code(scenario.to_script());
    }
    let number = answer.excitation.condition_number.map_or("none".to_owned(), |number| format!("{number:.1}"));
    section
        .paragraph(format!(
            "How accurately this log could determine the basic parameters of each axis. The condition number of their \
             information matrix is {number}: at 1 each parameter has an effect of its own, above 1000 some can hardly \
             be separated."
        ))
        .table(excitation(answer))
}

fn excitation(answer: &Diagnosis) -> Table {
    let mut table = Table::new(
        "Standard deviations that the log's noise allows",
        &["effect", "parameter", "if the others are known", "if all are fitted together"],
    );
    for of in &answer.excitation.parameters {
        let effect = of.axis.map_or_else(|| of.effect.to_owned(), |axis| format!("{}, {axis}", of.effect));
        table = table.row([effect.into(), of.parameter.into(), deviation(of.std_alone), deviation(of.std_together)]);
    }
    table
}

/// Two digits.
fn deviation(std: Option<f64>) -> Cell {
    let decimals = std.map_or(0, |std| decimals(std, 2, 9));
    Cell::number(std.unwrap_or(f64::NAN), decimals)
}

/// Of what moves: how well a model could fit it, and how well this one does.
pub(super) fn what_commands_explain(answer: &Diagnosis) -> Option<String> {
    let of = |channel: &ChannelStatistics| {
        let in_words = |fit: Option<f64>| match fit {
            Some(fit) if fit >= 0.5 => format!("{fit:.0} %"),
            Some(_) => "not at all".to_owned(),
            None => "-".to_owned(),
        };
        let [best, own] = [channel.commands_fit_pct, channel.extended.agreement.fit_pct].map(in_words);
        format!("{} {best} (this model {own})", quantity(channel.quantity))
    };
    let moved: Vec<String> = answer
        .statistics
        .iter()
        .filter(|channel| channel.moved && channel.commands_fit_pct.is_some())
        .map(of)
        .collect();
    (!moved.is_empty()).then(|| {
        format!(
            "Over {} s the best linear response to the axis' command, whatever the vehicle, fits {}. Where \
             neither does, something beside the commands moved it.",
            answer.prediction_error.window_s,
            moved.join(", ")
        )
    })
}
