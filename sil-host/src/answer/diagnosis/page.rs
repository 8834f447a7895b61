//! The page about a diagnosis, behind its first screen (`first_screen`): the ranking and the sizes, before and
//! after, what was rejected.

use crate::diagnosis::{
    BaseTerm, ChannelResiduals, ChannelStatistics, ClosedLoops, Diagnosis, Estimate, Fact, Finding, Holding,
    ModelStatistics, PredictionErrors, Verdict,
};
use crate::log::Log;
use crate::prediction::ChannelErrors;
use crate::report::{Bars, Cell, Chart, Page, Section, Table};

use super::{evidence, first_screen, without_a_model};
use crate::answer::comparison::page::error_cells;
use crate::answer::plain_words::{self, Size, capitalised, on_a_page, rough};

/// More effects than these with the same reason share one line.
const REJECTED_ALIKE: usize = 3;

/// A page of its own.
pub fn page(log: &Log, answer: &Diagnosis, command: &str) -> Page {
    let about = format!(
        "Diagnosis of {}: {} rows over {:.1} s, {:.0} Hz",
        log.file_name(),
        log.rows(),
        log.duration_s(),
        log.rate_hz()
    );
    let page = Page::new(first_screen::headline(answer)).about(about);
    let page = first_screen::first_screen(page, log, answer);
    let page = sections(log, answer).into_iter().fold(page, Page::section);
    page.provenance("Command", command).provenance("Version", env!("CARGO_PKG_VERSION"))
}

/// The verdict in a sentence, on the terminal; where effects are named, they follow.
pub fn headline(answer: &Diagnosis) -> String {
    let said = match answer.verdict {
        Verdict::NoDiscrepancy => "The simulation agrees with this log: nothing but noise remains.",
        Verdict::Explained => "What the simulation gets wrong in this log (nothing but noise remains):",
        Verdict::PartlyExplained => "What the simulation gets wrong in this log (something else remains unexplained):",
        Verdict::UnknownEffect if !answer.holding.is_empty() => {
            "What the commands do is known; beside them something that no log shows moves this vehicle."
        }
        Verdict::UnknownEffect => {
            "The simulation gets something wrong in this log that no effect of the catalogue explains."
        }
        Verdict::NotAModel => return without_a_model::not_a_model(answer),
        Verdict::NotShown => return without_a_model::not_shown(answer),
    };
    said.to_owned()
}

/// True for the log of a free vehicle in which more is compared than the rotation: the table of horizons has all of it.
pub fn compares_more_than_turning(answer: &Diagnosis) -> bool {
    answer.horizons.iter().flat_map(|horizon| &horizon.errors).any(|error| error.unit.starts_with('m'))
}

/// The models whose errors are shown, by name.
pub fn error_rows(errors: &PredictionErrors) -> [(&'static str, ChannelErrors); 4] {
    [
        ("nominal model", errors.nominal),
        ("base model", errors.base),
        ("with the findings", errors.extended),
        ("an exact model", errors.noise_floor),
    ]
}

/// The model that is shown beside the nominal one.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Beside {
    /// With the findings in it.
    Findings,
    /// The base model, where nothing was found.
    Base,
}

impl Beside {
    /// That of an answer; none where the nominal model is all.
    pub(super) fn of(answer: &Diagnosis) -> Option<Beside> {
        match (answer.findings.is_empty(), answer.base.is_empty()) {
            (false, _) => Some(Beside::Findings),
            (true, false) => Some(Beside::Base),
            (true, true) => None,
        }
    }

    /// What it is called over a curve or a column.
    pub(super) fn name(self) -> &'static str {
        match self {
            Beside::Findings => "with the findings",
            Beside::Base => "base model",
        }
    }

    /// Its figures in a channel.
    pub(super) fn figures(self, channel: &ChannelStatistics) -> &ModelStatistics {
        match self {
            Beside::Findings => &channel.extended,
            Beside::Base => &channel.base,
        }
    }
}

/// "98.2 to 99.6".
pub fn interval_text([low, high]: [f64; 2]) -> String {
    format!("{low:.1} to {high:.1}")
}

/// A number that is held.
pub fn fact_text(fact: &Fact) -> String {
    let Fact { name, value, std } = fact;
    if *std > 0.0 { format!("{name} {value} +- {std}") } else { format!("{name} {value}") }
}

/// A number of the base model, and whether it is a finding too.
fn base_text(term: &BaseTerm) -> String {
    if term.ordinary { term.to_string() } else { format!("{term} (a finding)") }
}

/// The sections, for a page of its own and for the demonstration's.
pub fn sections(log: &Log, answer: &Diagnosis) -> Vec<Section> {
    let mut sections = vec![causes(log, answer)];
    let details = base_model(answer)
        .into_iter()
        .chain([before_and_after(answer)])
        .chain(answer.closed_loop.as_ref().map(closed_loop))
        .chain([
            rejected(answer),
            evidence::where_it_arises(answer),
            evidence::unexplained(log, answer),
            evidence::what_cannot_be_shown(answer),
        ]);
    sections.extend(details.map(Section::folded));
    sections
}

/// What is fitted along with the findings; none where the nominal model leaves nothing open.
fn base_model(answer: &Diagnosis) -> Option<Section> {
    let section = Section::new("The base model").paragraph(
        "What is ordinary about a vehicle is fitted along with the findings: how hard it answers to commands, how \
         late, and what holds it level.",
    );
    let listed = || section.list(base_lines(answer).map(|line| on_a_page(&line)));
    (!answer.base.is_empty()).then(|| answer.warnings.iter().fold(listed(), Section::warning))
}

/// The base model's numbers and what stands beside them, a line each.
pub(super) fn base_lines(answer: &Diagnosis) -> impl Iterator<Item = String> {
    let terms = answer.base.iter().map(base_text);
    let together = answer.lateness_s.map(|together| format!("lag and delay together: {together} s"));
    let by_reference = answer.by_reference.iter().map(|of| format!("input gain of {of} alone"));
    let lasting = answer.lasting_gains.iter().map(|of| format!("input gain of {of} if what disturbs lasts"));
    let holding = answer.holding.iter().map(Holding::to_string);
    terms.chain(together).chain(by_reference).chain(lasting).chain(holding)
}

fn causes(log: &Log, answer: &Diagnosis) -> Section {
    let mut section = Section::new("The cause");
    if log.comments.iter().any(|comment| comment.contains("SYNTHETIC")) {
        section = section.warning("This log is synthetic: it was simulated, not measured.");
    }
    if !answer.known.is_empty() {
        let known: Vec<String> = answer.known.iter().map(fact_text).collect();
        section = section.paragraph(format!("Known beside the log, and held: {}.", known.join(", ")));
    }
    if let Some(warning) = without_a_model::warning(answer) {
        section = section.warning(warning);
    }
    if !answer.verdict.has_a_model() {
        section = evidence::what_commands_explain(answer).into_iter().fold(section, Section::paragraph);
    }
    if answer.findings.is_empty() {
        return section.paragraph(if answer.base.is_empty() {
            "No effect of the catalogue lowers the error by more than chance would."
        } else {
            "Beside the base model no effect of the catalogue lowers the error by more than chance would."
        });
    }
    let gain = &answer.gain;
    let left = answer.unexplained.variance_pct;
    let caption = "How much of the improvement is lost without each effect, with its 95 % interval";
    let ranked = answer.findings.iter().zip(&gain.findings_interval_pct);
    let bars = ranked.fold(Bars::new(caption), |bars, (finding, interval)| {
        bars.bar(plain_words::sentence(finding), finding.gain_pct, *interval)
    });
    let mut table =
        Table::new("Sizes, each with one standard deviation", &["effect", "parameter", "size", "name in a model file"]);
    for finding in &answer.findings {
        for (index, (name, estimate)) in finding.parameters.iter().enumerate() {
            table = table.row(parameter_row(finding, name, *estimate, index == 0));
        }
    }
    let shown = |interval: &[f64; 2]| format!("{:.1}", interval[0]) != format!("{:.1}", interval[1]);
    let between = gain.total_interval_pct.filter(shown).map(|interval| format!(" ({} %)", interval_text(interval)));
    section
        .bars(bars.rest("What remains unexplained", left))
        .table(table)
        .list(
            answer
                .findings
                .iter()
                .filter(|finding| plain_words::is_doubtful(finding))
                .map(|of| on_a_page(&of.statement)),
        )
        .paragraph(format!(
            "Effects were fitted to half of the log's windows, chosen by a quarter, and are judged by the rest, held \
             out. There the findings together remove {:.1} %{} of the squared error. Where effects can replace each \
             other, gains do not add up to 100 %.",
            gain.total_pct,
            between.unwrap_or_default()
        ))
}

fn parameter_row(finding: &Finding, name: &'static str, estimate: Estimate, is_first: bool) -> [Cell; 4] {
    let axis = finding.axis.map(|axis| format!(", {axis}")).unwrap_or_default();
    let effect = if is_first { format!("{}{axis}", finding.effect.replace('_', " ")) } else { String::new() };
    let meaning = plain_words::parameter(finding.effect, name);
    [effect.into(), meaning.into(), Size::new(name, estimate).exact().into(), name.into()]
}

fn before_and_after(answer: &Diagnosis) -> Section {
    let errors = &answer.prediction_error;
    let mut section = Section::new("Before and after").paragraph(format!(
        "In windows of {} s the model starts from the log's state and is driven by the logged commands alone (open \
         loop). The plots show measured minus predicted in the held-out windows, for the model as it was and for the \
         model with the findings.",
        errors.window_s
    ));
    if !compares_more_than_turning(answer) {
        let heads = ["", "roll, deg", "pitch, deg", "roll rate, deg/s", "pitch rate, deg/s"];
        let table = Table::new("RMSE over the held-out windows", &heads);
        section =
            section.table(error_rows(errors).iter().fold(table, |table, (name, of)| table.row(error_cells(name, of))));
    }
    let is_alone = answer.findings.is_empty();
    let of_a_kind = answer.residuals.chunk_by(|a, b| a.kind == b.kind);
    let section = of_a_kind.fold(section, |section, channels| {
        let charts: Vec<Chart> = channels.iter().map(|channel| residual_chart(channel, is_alone)).collect();
        section.small_multiples(channels[0].kind, charts)
    });
    section.table(horizons(answer))
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
    let title = capitalised(&format!("{}, measured minus predicted", plain_words::quantity(channel.name)));
    let chart = Chart::time_series(title, plain_words::unit(channel.unit)).series(
        "nominal model",
        &channel.time_s,
        &channel.nominal,
    );
    if is_alone { chart } else { chart.series("with the findings", &channel.time_s, &channel.extended) }
}

/// RMSE of angles, rates and accelerations after several times.
fn horizons(answer: &Diagnosis) -> Table {
    let header: Vec<String> = answer.horizons.iter().map(|horizon| format!("{} s", horizon.horizon_s)).collect();
    let names: Vec<&str> = std::iter::once("").chain(header.iter().map(String::as_str)).collect();
    let caption = format!(
        "RMSE of predictions over several horizons: nominal → {} (an exact model). Beyond 0.5 s windows contain rows \
         that the fit has used",
        Beside::of(answer).unwrap_or(Beside::Findings).name()
    );
    let mut table = Table::new(caption, &names);
    let Some(first) = answer.horizons.first() else { return table };
    for error in &first.errors {
        let cells = answer.horizons.iter().map(|horizon| {
            let found = horizon.errors.iter().find(|other| other.quantity == error.quantity);
            found.map_or(Cell::from(""), |e| {
                let [nominal, extended, exact] = [e.nominal, e.extended, e.noise_floor].map(rough);
                Cell::from(format!("{nominal} → {extended} ({exact})"))
            })
        });
        let name = Cell::from(format!("{}, {}", plain_words::quantity(error.quantity), plain_words::unit(error.unit)));
        table = table.row(std::iter::once(name).chain(cells));
    }
    table
}

/// The effects that were rejected: with reasons of their own one by one, with the same reason together.
fn rejected(answer: &Diagnosis) -> Section {
    let mut reasons: Vec<(&str, Vec<String>)> = Vec::new();
    for rejected in &answer.rejected {
        let place = if rejected.axis.is_empty() { String::new() } else { format!(" ({})", rejected.axis) };
        let name = format!("{}{place}", rejected.effect);
        match reasons.iter_mut().find(|(reason, _)| *reason == rejected.reason) {
            Some((_, names)) => names.push(name),
            None => reasons.push((&rejected.reason, vec![name])),
        }
    }
    let (alike, single): (Vec<_>, Vec<_>) = reasons.into_iter().partition(|(_, names)| names.len() > REJECTED_ALIKE);
    let mut section = Section::new("What it is not");
    if !single.is_empty() {
        let table = Table::new("Tested and rejected", &["effect", "reason"]);
        section = section.table(
            single.iter().fold(table, |table, (why, names)| table.row([names.join(", ").into(), Cell::from(*why)])),
        );
    }
    section.list(alike.iter().map(|(why, names)| format!("{}: {}.", capitalised(why), names.join(", "))))
}
