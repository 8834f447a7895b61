//! A log with what came out of comparing it, under each controller that was named; several of them in one table and
//! one JSON.

use std::path::Path;

use serde::Serialize;

use crate::answer::plain_words::{quantity, table_decimals, unit};
use crate::answer::text_table::TextTable;
use crate::answer::{HeldAgainst, NotHeldAgainst};
use crate::comparison::{ChannelError, Comparison, ComparisonSummary};
use crate::controller_file::ControllerChoice;
use crate::log::Log;

/// Channels of the table; a free flight has more, which each log's own comparison shows.
const SHOWN: [&str; 6] = ["roll", "pitch", "yaw", "p", "q", "r"];

/// A log and what came out.
pub struct Compared {
    /// The log.
    pub log: Log,
    /// What it was held against.
    pub against: HeldAgainst,
    /// One for each controller; one where none was named.
    pub runs: Vec<Run>,
}

/// What came out under one controller.
pub struct Run {
    /// As it was named; none where none was.
    pub controller: Option<String>,
    /// What came out.
    pub comparison: Comparison,
}

/// One of several logs.
pub struct Entry {
    path: String,
    outcome: Result<Box<Compared>, String>,
}

/// The JSON of several comparisons.
#[derive(Serialize)]
pub struct ComparedJson<'a> {
    runs: Vec<RunJson<'a>>,
}

#[derive(Serialize)]
struct RunJson<'a> {
    path: &'a str,
    controller: Option<&'a str>,
    held_against: Option<&'a str>,
    comparison: Option<ComparisonSummary>,
    error: Option<&'a str>,
}

impl Compared {
    /// Compares a log with the simulation under each controller.
    ///
    /// # Errors
    /// The log or a controller does not allow it.
    pub fn of(
        log: Log,
        mut against: HeldAgainst,
        controllers: &[(String, ControllerChoice)],
    ) -> Result<Compared, NotHeldAgainst> {
        let named: Vec<Option<&(String, ControllerChoice)>> =
            if controllers.is_empty() { vec![None] } else { controllers.iter().map(Some).collect() };
        let mut runs = Vec::new();
        for controller in named {
            against.controller = controller.cloned();
            let comparison = against.compare(&log)?;
            runs.push(Run { controller: controller.map(|(name, _)| name.clone()), comparison });
        }
        Ok(Compared { log, against, runs })
    }
}

impl Entry {
    /// A log with its comparisons, or why there is none.
    pub fn of(path: &Path, outcome: Result<Compared, String>) -> Entry {
        Entry { path: path.display().to_string(), outcome: outcome.map(Box::new) }
    }

    /// As it was given.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// What came out, or why nothing did.
    pub fn outcome(&self) -> Result<&Compared, &str> {
        self.outcome.as_deref().map_err(String::as_str)
    }
}

/// A run of one of the logs, by a name that no other has.
pub(super) struct Named<'a> {
    pub name: String,
    pub compared: &'a Compared,
    pub run: &'a Run,
}

/// All runs; the log's name is left out where there is only one log, the controller's where one is compared.
pub(super) fn named(entries: &[Entry]) -> Vec<Named<'_>> {
    let mut all = Vec::new();
    for entry in entries {
        let Ok(compared) = entry.outcome() else { continue };
        for run in &compared.runs {
            let controller = run.controller.as_deref().filter(|_| compared.runs.len() > 1);
            let name = match controller {
                Some(controller) if entries.len() > 1 => format!("{}, {controller}", entry.path),
                Some(controller) => controller.to_owned(),
                None => entry.path.clone(),
            };
            all.push(Named { name, compared, run });
        }
    }
    all
}

/// Heads of the columns of errors, one for each channel of [`SHOWN`] that any log has.
pub(super) fn error_columns(runs: &[Named<'_>]) -> Vec<(&'static str, String)> {
    let errors: Vec<ChannelError> =
        runs.iter().flat_map(|run| run.run.comparison.prediction_error().channels).collect();
    let head = |name: &&'static str| {
        let error = errors.iter().find(|error| error.quantity == *name)?;
        Some((*name, format!("{}, {}", quantity(name), unit(error.unit))))
    };
    SHOWN.iter().filter_map(head).collect()
}

/// "12.3 (0.4)": this model's error, and an exact one's.
pub(super) fn error_cells(run: &Named<'_>, columns: &[(&'static str, String)]) -> Vec<String> {
    let errors = run.run.comparison.prediction_error().channels;
    let cell = |(name, _): &(&'static str, String)| match errors.iter().find(|error| error.quantity == *name) {
        Some(error) => {
            let decimals = table_decimals(error.nominal);
            format!("{:.decimals$} ({:.*})", error.nominal, table_decimals(error.noise_floor), error.noise_floor)
        }
        None => "-".to_owned(),
    };
    columns.iter().map(cell).collect()
}

/// The closed loop's deviations, of runs that have any.
pub(super) fn deviations<'a>(runs: &'a [Named<'a>]) -> impl Iterator<Item = (&'a str, [f64; 2])> {
    runs.iter().filter_map(|run| {
        let deviation = run.run.comparison.closed_loop.as_ref()?.deviation;
        Some((run.name.as_str(), [deviation.roll_mean_abs_deg, deviation.pitch_mean_abs_deg]))
    })
}

/// What the terminal shows: tables with a row for each, and what each log was held against.
pub fn several_text(entries: &[Entry]) -> String {
    let runs = named(entries);
    let columns = error_columns(&runs);
    let heads = ["open-loop prediction, RMSE (an exact model's)".to_owned()];
    let mut table = TextTable::new(heads.into_iter().chain(columns.iter().map(|(_, head)| head.clone())));
    runs.iter().for_each(|run| table.row([run.name.clone()].into_iter().chain(error_cells(run, &columns))));
    let mut text = if runs.is_empty() { String::new() } else { format!("{table}\n") };
    let mut table = TextTable::new(["closed loop, mean |simulated - measured|", "roll, deg", "pitch, deg"]);
    let mut is_simulated = false;
    for (name, [roll, pitch]) in deviations(&runs) {
        table.row([name.to_owned(), format!("{roll:.2}"), format!("{pitch:.2}")]);
        is_simulated = true;
    }
    if is_simulated {
        text.push_str(&format!("{table}\n"));
    }
    for entry in entries {
        match entry.outcome() {
            Ok(compared) if compared.against.said.is_empty() => {}
            Ok(compared) => text.push_str(&format!("{}: {}\n", entry.path, compared.against.said)),
            Err(why) => text.push_str(&format!("{why}\n")),
        }
    }
    text
}

/// What `--json` writes of several.
pub fn several_json(entries: &[Entry]) -> ComparedJson<'_> {
    let mut runs = Vec::new();
    for entry in entries {
        let none = RunJson { path: &entry.path, controller: None, held_against: None, comparison: None, error: None };
        match entry.outcome() {
            Err(error) => runs.push(RunJson { error: Some(error), ..none }),
            Ok(compared) => runs.extend(compared.runs.iter().map(|run| RunJson {
                controller: run.controller.as_deref(),
                held_against: compared.against.taken(),
                comparison: Some(run.comparison.summary()),
                ..none
            })),
        }
    }
    ComparedJson { runs }
}
