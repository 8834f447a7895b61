//! The page of several comparisons: logs over each other from their first rows on, and one log under several
//! controllers.

use super::compared::{Entry, Named, deviations, error_cells, error_columns, named};
use super::page::{by_window, lead, picture};
use crate::answer::flight::page::degrees;
use crate::answer::plain_words::{capitalised, quantity, unit, with_unit};
use crate::comparison::ChannelError;
use crate::log::Log;
use crate::prediction::Channel;
use crate::report::{Card, Cell, Chart, Page, Section, Table, Tone};

/// More curves than there are line styles can't be told apart.
const OVERLAID_MAX: usize = 6;
/// The headline names so many; of more it gives least and greatest.
const NAMED_MAX: usize = 3;

/// The page.
pub fn several_page(entries: &[Entry], command: &str) -> Page {
    let runs = named(entries);
    let mut all = Section::new("All of them").table(error_table(&runs));
    if let Some(table) = deviation_table(&runs) {
        all = all.table(table);
    }
    let page = Page::new(headline(&runs)).about("Measured against simulated, several in one").section(all);
    let overlaid = &runs[..runs.len().min(OVERLAID_MAX)];
    let sections = [angles(entries, overlaid), errors(overlaid)].into_iter().flatten();
    let sections = sections.map(|section| match runs.len() > OVERLAID_MAX {
        true => section.note(format!("The first {OVERLAID_MAX} of {} are drawn.", runs.len())),
        false => section,
    });
    let page = sections.chain(entries.iter().map(each)).fold(page, Page::section);
    page.provenance("Command", command).provenance("Version", env!("CARGO_PKG_VERSION"))
}

fn times_floor(error: &ChannelError) -> f64 {
    error.nominal / error.noise_floor
}

/// By how much each misses the channel that any of them misses most.
fn headline(runs: &[Named<'_>]) -> String {
    let of = |run: &Named<'_>| run.run.comparison.prediction_error();
    let all = runs.iter().flat_map(|run| of(run).channels);
    let Some(worst) = all.max_by(|a, b| times_floor(a).total_cmp(&times_floor(b))) else {
        return "None of these logs can be compared".to_owned();
    };
    let name = quantity(worst.quantity);
    let deviating: Vec<(&str, [f64; 2])> = deviations(runs).collect();
    let is_one_log = runs.iter().all(|run| std::ptr::eq(run.compared, runs[0].compared));
    let (what, unit, mut misses) = if is_one_log && deviating.len() > 1 {
        let most = |axis: usize| deviating.iter().map(|(_, of)| of[axis]).fold(0.0, f64::max);
        let (axis, name) = if most(0) > most(1) { (0, "roll") } else { (1, "pitch") };
        let misses = deviating.iter().map(|(name, of)| ((*name).to_owned(), of[axis])).collect();
        (format!("In closed loop the {name} is off on average by "), "deg".to_owned(), misses)
    } else {
        let miss = |run: &Named<'_>| {
            let channels = of(run).channels;
            let error = channels.iter().find(|error| error.quantity == worst.quantity)?;
            Some((run.name.clone(), error.nominal))
        };
        let misses: Vec<(String, f64)> = runs.iter().filter_map(miss).collect();
        (format!("The {name} is missed by "), self::unit(worst.unit), misses)
    };
    if misses.len() <= NAMED_MAX {
        let each = misses.iter().map(|(of, size)| format!("{} ({of})", with_unit(*size, &unit)));
        return what + &each.collect::<Vec<_>>().join(", ");
    }
    misses.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (least, most) = (misses[0].1, misses[misses.len() - 1].1);
    format!("{what}{} to {} in {} comparisons", with_unit(least, &unit), with_unit(most, &unit), misses.len())
}

fn error_table(runs: &[Named<'_>]) -> Table {
    let columns = error_columns(runs);
    let heads: Vec<&str> = [""].into_iter().chain(columns.iter().map(|(_, head)| head.as_str())).collect();
    let caption = "Error of the open-loop prediction (in brackets an exact model's), RMSE at the held-out windows";
    runs.iter().fold(Table::new(caption, &heads), |table, run| {
        let cells = error_cells(run, &columns).into_iter().map(Cell::from);
        table.row([Cell::from(run.name.as_str())].into_iter().chain(cells))
    })
}

fn deviation_table(runs: &[Named<'_>]) -> Option<Table> {
    let caption = "Closed loop: mean absolute deviation, simulated against measured";
    let rows: Vec<_> = deviations(runs).collect();
    let table = Table::new(caption, &["", "roll, degrees", "pitch, degrees"]);
    (!rows.is_empty()).then(|| {
        rows.into_iter().fold(table, |table, (name, [roll, pitch])| {
            table.row([Cell::from(name), Cell::number(roll, 2), Cell::number(pitch, 2)])
        })
    })
}

/// Time from the first row on, so that flights of other hours lie over each other.
fn from_start(log: &Log, time_s: &[f64]) -> Vec<f64> {
    let start_s = log.time_s.first().copied().unwrap_or(0.0);
    time_s.iter().map(|time_s| time_s - start_s).collect()
}

/// Roll and pitch of all logs, and where a controller was named what the simulation makes of their references.
fn angles(entries: &[Entry], runs: &[Named<'_>]) -> Option<Section> {
    let logs: Vec<_> = entries.iter().filter_map(|entry| Some((entry.path(), entry.outcome().ok()?))).collect();
    let mut section = Section::new("Angles, one over the other").paragraph(
        "Time runs from the first compared row of each log. Measured as in the log; simulated in closed loop on the \
         log's references, from its first attitude.",
    );
    let mut is_drawn = false;
    for (axis, name) in [(0, "Roll"), (1, "Pitch")] {
        let mut chart = Chart::time_series(format!("{name} angle"), "deg");
        for (path, compared) in logs.iter().take(OVERLAID_MAX) {
            let log = &compared.log;
            let time_s = from_start(log, &log.time_s);
            // one reference: those of several logs would hide each other
            if let (Some(reference), 1) = (&log.reference_rad[axis], logs.len()) {
                chart = chart.step_series("reference", &time_s, &degrees(reference));
            }
            if let Some(measured) = &log.angle_rad[axis] {
                let label = if logs.len() == 1 { "measured".to_owned() } else { format!("{path}, measured") };
                chart = chart.series(label, &time_s, &degrees(measured));
                is_drawn = true;
            }
        }
        for run in runs {
            if let Some(closed_loop) = &run.run.comparison.closed_loop {
                let log = &run.compared.log;
                let time_s = from_start(log, &log.time_s);
                let label = format!("{}, simulated", run.name);
                chart = chart.series(label, &time_s, &degrees(&closed_loop.simulated_rad[axis]));
            }
        }
        section = section.chart(chart);
    }
    is_drawn.then_some(section)
}

/// Errors of angles and rates, a curve for each log: a controller changes nothing in the open-loop prediction.
fn errors(runs: &[Named<'_>]) -> Option<Section> {
    let first_of_a_log = |(place, run): &(usize, &Named<'_>)| {
        runs[..*place].iter().all(|earlier| !std::ptr::eq(earlier.compared, run.compared))
    };
    let logs: Vec<&Named<'_>> = runs.iter().enumerate().filter(first_of_a_log).map(|(_, run)| run).collect();
    if logs.len() < 2 {
        return None;
    }
    let mut section = Section::new("Errors of the prediction, one over the other");
    for channel in Channel::ALL.into_iter().filter(|channel| matches!(channel, Channel::Angle(_) | Channel::Rate(_))) {
        let title = capitalised(&format!("{}, measured less simulated", quantity(channel.name())));
        let mut chart = Chart::time_series(title, unit(channel.unit()));
        let mut is_drawn = false;
        for one in &logs {
            let predicted = &one.run.comparison.prediction.predicted;
            if !predicted.channels().any(|of| of == channel) {
                continue;
            }
            let (time_s, errors) = by_window(&predicted.samples(channel), |sample| channel.in_unit(sample.error));
            chart = chart.series(&one.name, &from_start(&one.compared.log, &time_s), &errors);
            is_drawn = true;
        }
        if is_drawn {
            section = section.chart(chart);
        }
    }
    Some(section.folded())
}

/// What one log alone says.
fn each(entry: &Entry) -> Section {
    let section = Section::new(entry.path());
    let compared = match entry.outcome() {
        Ok(compared) => compared,
        Err(why) => return section.card(Card::new(Tone::Bad).line("No answer", why)),
    };
    let Some(run) = compared.runs.first() else { return section };
    let said = &compared.against.said;
    let section = if said.is_empty() { section } else { section.paragraph(said) };
    let section = section.paragraph(lead(&run.comparison, &compared.against.subject()));
    let section = match picture(&compared.log, &run.comparison) {
        Some(picture) => section.chart(picture),
        None => section,
    };
    let notes = compared.log.notes.iter().chain(compared.runs.iter().flat_map(|run| &run.comparison.notes));
    let mut notes: Vec<String> = notes.cloned().collect();
    notes.dedup();
    section.list(notes)
}
