//! The page about a diagnosis: the sentence, the size, the picture before and after, what was denied, what is left.

use sil_host::diagnosis::{ChannelResiduals, ClosedLoops, Diagnosis, Estimate, Finding, Verdict};
use sil_host::log::Log;
use sil_host::report::{Cell, Chart, Page, Section, Table};

use super::flight_report::degrees;

/// A page of its own.
pub fn page(log: &Log, answer: &Diagnosis, command: &str) -> Page {
    let mut page = Page::new("Why does the simulation disagree?").lead(headline(answer.verdict)).lead(format!(
        "{}: {} rows over {:.1} s, {:.0} Hz.",
        log.path,
        log.rows(),
        log.duration_s(),
        log.rate_hz()
    ));
    for section in sections(log, answer) {
        page = page.section(section);
    }
    page.provenance("Command", command).provenance("Version", env!("CARGO_PKG_VERSION"))
}

/// The verdict in a sentence.
pub fn headline(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoDiscrepancy => "The simulation agrees with this log: what is left is noise.",
        Verdict::Explained => "What the simulation gets wrong here is named below, and that is all of it.",
        Verdict::PartlyExplained => "What the simulation gets wrong here is named below, but that is not all of it.",
        Verdict::UnknownEffect => {
            "The simulation misses something in this log that no effect of the catalogue explains."
        }
    }
}

/// The sections, for a page of its own and for the demonstration's.
pub fn sections(log: &Log, answer: &Diagnosis) -> Vec<Section> {
    let mut sections = vec![causes(answer), before_and_after(answer)];
    sections.extend(answer.closed_loop.as_ref().map(closed_loop));
    sections.extend([denied(answer), left_over(log, answer)]);
    sections
}

fn causes(answer: &Diagnosis) -> Section {
    let section = Section::new("The cause");
    if answer.findings.is_empty() {
        return section.paragraph("No effect of the catalogue lowers the error by more than chance would.");
    }
    let section = section.paragraph(
        "Each effect was fitted to every second window of the log and judged on the windows in between, which no fit \
         has seen. The gain is how much of the improvement is lost when this effect alone is taken out again.",
    );
    let section = section.list(answer.findings.iter().map(|finding| finding.statement.clone()));
    let mut table = Table::new("Sizes, with one standard deviation", &["effect", "parameter", "value", "±", "gain, %"]);
    for finding in &answer.findings {
        for (index, (name, estimate)) in finding.parameters.iter().enumerate() {
            table = table.row(parameter_row(finding, name, estimate, index == 0));
        }
    }
    let doubts = answer.findings.iter().filter(|finding| !finding.confounded_with.is_empty());
    doubts.fold(section.table(table), |section, finding| {
        section.note(format!(
            "This log does not tell {} from {}.",
            finding.effect,
            finding.confounded_with.join(" or ")
        ))
    })
}

fn parameter_row(finding: &Finding, name: &str, estimate: &Estimate, is_first: bool) -> [Cell; 5] {
    let axis = finding.axis.map(|axis| format!(", {axis}")).unwrap_or_default();
    let (effect, gain) = if is_first {
        (format!("{}{axis}", finding.effect), Cell::number(finding.gain_pct, 1))
    } else {
        (String::new(), Cell::from(""))
    };
    let decimals = estimate.decimals().unwrap_or(0);
    let spread = if estimate.std > 0.0 { Cell::number(estimate.std, decimals) } else { Cell::number(f64::NAN, 0) };
    [effect.into(), name.into(), Cell::number(estimate.value, decimals), spread, gain]
}

fn before_and_after(answer: &Diagnosis) -> Section {
    let errors = &answer.prediction_error;
    let mut section = Section::new("Before and after").paragraph(format!(
        "In windows of {} s the model starts where the log was and gets the logged commands. What is drawn is measured \
         less predicted: the model as it was, and with the findings in it.",
        errors.window_s
    ));
    for channel in &answer.residuals {
        section = section.chart(residual_chart(channel, answer.findings.is_empty()));
    }
    let mut table =
        Table::new("RMSE over the held-out windows", &["", "roll, deg", "pitch, deg", "p, deg/s", "q, deg/s"]);
    for (name, of) in [
        ("nominal model", errors.nominal),
        ("with the findings", errors.extended),
        ("an exact model: noise floor", errors.noise_floor),
    ] {
        let cells = [of.roll_deg, of.pitch_deg, of.p_deg_s, of.q_deg_s];
        table = table.row(
            std::iter::once(Cell::from(name))
                .chain(cells.into_iter().map(|value| Cell::number(value.unwrap_or(f64::NAN), 3))),
        );
    }
    section.table(table)
}

fn closed_loop(closed_loop: &ClosedLoops) -> Section {
    let mut table = Table::new("Mean |simulated - measured| (the thesis' table 5.1)", &["", "roll, deg", "pitch, deg"]);
    for (name, deviation) in [("nominal model", closed_loop.nominal), ("with the findings", closed_loop.extended)] {
        let cells = [deviation.roll_mean_abs_deg, deviation.pitch_mean_abs_deg];
        table =
            table.row(std::iter::once(Cell::from(name)).chain(cells.into_iter().map(|value| Cell::number(value, 2))));
    }
    Section::new("In closed loop")
        .paragraph("The controller flies the simulated vehicle on the log's references, from the log's first attitude.")
        .table(table)
}

fn residual_chart(channel: &ChannelResiduals, is_alone: bool) -> Chart {
    let (kind, unit) = if channel.is_rate { ("rate", "deg/s") } else { ("angle", "deg") };
    let chart = Chart::time_series(format!("{} {kind}, measured less predicted", channel.name), unit).series(
        "nominal model",
        &channel.time_s,
        &degrees(&channel.nominal),
    );
    if is_alone { chart } else { chart.series("with the findings", &channel.time_s, &degrees(&channel.extended)) }
}

fn denied(answer: &Diagnosis) -> Section {
    let mut table = Table::new("What was asked and denied", &["effect", "axis", "why not"]);
    for rejected in &answer.rejected {
        table = table.row([
            Cell::from(rejected.effect),
            Cell::from(rejected.axis.clone()),
            Cell::from(rejected.reason.clone()),
        ]);
    }
    Section::new("What it is not").table(table)
}

fn left_over(log: &Log, answer: &Diagnosis) -> Section {
    let left = &answer.unexplained;
    let mut section = Section::new("What is left").paragraph(format!(
        "{:.1} % of the nominal model's held-out error beyond the noise remains; the residuals are {}.",
        left.variance_pct,
        if left.white { "white, as noise is" } else { "not white: something is still missing" }
    ));
    if !left.signature.is_empty() {
        section = section.note(left.signature.clone());
    }
    if log.comments.iter().any(|comment| comment.contains("SYNTHETIC")) {
        section = section.warning("This log is synthetic: it was simulated, not measured.");
    }
    section.list(log.notes.iter().cloned())
}
