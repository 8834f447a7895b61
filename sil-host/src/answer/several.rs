//! Several logs, each with an answer of its own: one table on the terminal, one page with the table and each log's
//! card, one JSON.

use std::path::Path;

use serde::Serialize;

use super::Answered;
use super::diagnosis::first_screen::{card, headline, lead, picture, shown};
use super::plain_words::{cause, is_doubtful, main_parameter, quantity, unit, with_unit};
use super::text_table::TextTable;
use crate::diagnosis::{Diagnosis, Verdict};
use crate::report::{Card, Cell, Page, Section, Table, Tone};

/// Columns of the table.
const COLUMNS: [&str; 7] = ["log", "verdict", "cause", "size", "misses", "as it was", "with the findings (exact)"];

/// One log.
pub struct Row {
    path: String,
    outcome: Result<Box<Answered>, String>,
}

/// The JSON of several logs.
#[derive(Serialize)]
pub struct SeveralJson<'a> {
    logs: Vec<RowJson<'a>>,
}

#[derive(Serialize)]
struct RowJson<'a> {
    path: &'a str,
    /// What it was held against, where nobody said it.
    held_against: Option<&'a str>,
    /// As `sil diagnose` gives it of one log.
    diagnosis: Option<&'a Diagnosis>,
    error: Option<&'a str>,
}

impl Row {
    /// A log with its answer, or why there is none.
    pub fn of(path: &Path, outcome: Result<Answered, String>) -> Row {
        Row { path: path.display().to_string(), outcome: outcome.map(Box::new) }
    }

    /// The verdict; none where there is no answer.
    pub fn verdict(&self) -> Option<Verdict> {
        self.outcome.as_ref().ok().map(|answered| answered.diagnosis.verdict)
    }

    /// The cells of the table, the log's name first; of a log without an answer the reason, in place of a cause.
    fn cells(&self) -> Vec<String> {
        let answered = match &self.outcome {
            Ok(answered) => answered,
            Err(why) => {
                let first_line = why.lines().next().unwrap_or_default().to_owned();
                return vec![self.path.clone(), "no answer".to_owned(), first_line];
            }
        };
        let answer = &answered.diagnosis;
        // what no model holds together is no cause
        let first = answer.findings.first().filter(|_| answer.verdict.has_a_model());
        let size = first.and_then(main_parameter).map(|(_, size)| size.exact());
        let error = shown(answer).map(|(error, _)| {
            let unit = unit(error.unit);
            let exact = with_unit(error.noise_floor, &unit);
            let after = first.map(|_| format!("{} ({exact})", with_unit(error.extended, &unit)));
            [
                quantity(error.quantity).to_owned(),
                with_unit(error.nominal, &unit),
                after.unwrap_or_else(|| format!("- ({exact})")),
            ]
        });
        let [what, before, after] = error.unwrap_or_default();
        let cause = first.map(|of| cause(of) + if is_doubtful(of) { "?" } else { "" }).unwrap_or_default();
        let verdict = verdict(answer.verdict).to_owned();
        vec![self.path.clone(), verdict, cause, size.unwrap_or_default(), what, before, after]
    }
}

/// In two words, for a cell.
fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoDiscrepancy => "agrees",
        Verdict::Explained => "explained",
        Verdict::PartlyExplained => "partly explained",
        Verdict::UnknownEffect => "unknown effect",
        Verdict::NotAModel => "not a model",
        Verdict::NotShown => "not shown",
    }
}

/// The table on a terminal; below it what each log was held against and what no cell has room for.
pub fn several_text(rows: &[Row]) -> String {
    let mut table = TextTable::new(COLUMNS);
    for row in rows {
        // the whole of a reason stands below
        let shown = if row.outcome.is_ok() { COLUMNS.len() } else { 2 };
        table.row(row.cells().into_iter().take(shown));
    }
    let mut text = format!("{table}\n{}.\n", title(&verdicts(rows)));
    for row in rows {
        match &row.outcome {
            Ok(answered) if answered.against.said.is_empty() => {}
            Ok(answered) => text.push_str(&format!("{}: {}\n", row.path, answered.against.said)),
            Err(why) => text.push_str(&format!("{why}\n")),
        }
    }
    text
}

fn verdicts(rows: &[Row]) -> Vec<Option<Verdict>> {
    rows.iter().map(Row::verdict).collect()
}

/// How many logs say what. Of a flight that no model predicts nothing is known to differ, so that it is not counted
/// among those that do.
fn title(verdicts: &[Option<Verdict>]) -> String {
    let count = |is: fn(Option<Verdict>) -> bool| verdicts.iter().filter(|verdict| is(**verdict)).count();
    let agree = count(|verdict| verdict == Some(Verdict::NoDiscrepancy));
    let not_modelled = count(|verdict| verdict.is_some_and(|verdict| !verdict.has_a_model()));
    let none = count(|verdict| verdict.is_none());
    let differ = verdicts.len() - agree - not_modelled - none;
    let counts = [
        (differ, "differs from the simulation", "differ from the simulation"),
        (agree, "agrees with it", "agree with it"),
        (not_modelled, "is of a flight that no model predicts yet", "are of flights that no model predicts yet"),
        (none, "has no answer", "have no answer"),
    ];
    let all: Vec<String> = counts
        .into_iter()
        .enumerate()
        // the first says what the others refer to, zero or not
        .filter(|(place, (count, ..))| *place == 0 || *count > 0)
        .map(|(_, (count, one, several))| format!("{count} {}", if count == 1 { one } else { several }))
        .collect();
    format!("Of {} logs {}", verdicts.len(), all.join(", "))
}

/// The page: the table, then each log's headline, picture and card.
pub fn several_page(rows: &[Row], command: &str) -> Page {
    let heads = Table::new("Each log with what explains most of its error", &COLUMNS);
    let table = rows.iter().enumerate().fold(heads, |table, (index, row)| {
        // the first section is the table itself
        let name = Cell::to_section(&row.path, index + 2);
        table.row([name].into_iter().chain(row.cells().into_iter().skip(1).map(Cell::from)))
    });
    let page = Page::new(title(&verdicts(rows))).section(Section::new("All logs").table(table));
    let page = rows.iter().map(section).fold(page, Page::section);
    page.provenance("Command", command).provenance("Version", env!("CARGO_PKG_VERSION"))
}

fn section(row: &Row) -> Section {
    let section = Section::new(&row.path);
    let answered = match &row.outcome {
        Ok(answered) => answered,
        Err(why) => return section.card(Card::new(Tone::Bad).line("No answer", why)),
    };
    let Answered { log, against, diagnosis } = answered.as_ref();
    let said = against.taken().map(str::to_owned);
    let texts = [headline(diagnosis)].into_iter().chain(lead(log, diagnosis)).chain(said);
    let section = texts.fold(section, Section::paragraph);
    let section = match picture(log, diagnosis) {
        Some(picture) => section.chart(picture),
        None => section,
    };
    section.card(card(diagnosis))
}

/// What `--json` writes of several logs.
pub fn several_json(rows: &[Row]) -> SeveralJson<'_> {
    fn of(row: &Row) -> RowJson<'_> {
        let answered = row.outcome.as_ref().ok();
        RowJson {
            path: &row.path,
            held_against: answered.and_then(|answered| answered.against.taken()),
            diagnosis: answered.map(|answered| &answered.diagnosis),
            error: row.outcome.as_ref().err().map(String::as_str),
        }
    }
    SeveralJson { logs: rows.iter().map(of).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_counts_no_flight_without_a_model_as_one_that_differs() {
        let verdicts = [
            Some(Verdict::NotAModel),
            Some(Verdict::Explained),
            Some(Verdict::NotShown),
            Some(Verdict::UnknownEffect),
            Some(Verdict::NoDiscrepancy),
            None,
        ];
        let all = "Of 6 logs 2 differ from the simulation, 1 agrees with it, 2 are of flights that no model predicts \
                   yet, 1 has no answer";
        assert_eq!(title(&verdicts), all);
        assert_eq!(
            title(&verdicts[..2]),
            "Of 2 logs 1 differs from the simulation, 1 is of a flight that no model \
                                           predicts yet"
        );
    }
}
