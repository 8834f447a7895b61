//! From a [`Recording`] of several rates to a [`Log`] of rows, by the rules of `recording.rs`.

mod readings;
mod repeats;
#[cfg(test)]
mod tests;

use self::readings::{Between, Readings, put_in_order};
pub(super) use self::repeats::has_repeats;
use super::error::{LogError, LogErrorKind, ROWS_MIN, held};
use super::map::{Map, Threshold};
use super::quantity::Quantity;
use super::recording::{Recording, Stream};
use super::{Log, note_gaps, outside};
use crate::axis::Axis;

/// A quantity that the rows need not have is left out if it covers less of them than this.
const COVERS_MIN: f64 = 0.9;

/// The log of a recording; `file` is for messages. A map says more of the axes, where one was given.
///
/// # Errors
/// A stream's time runs back, most of a quantity's readings are impossible, there are no rates or commands, or too few
/// instants at which all is there.
pub(super) fn log_of(file: &str, recording: Recording, map: Option<&Map>) -> Result<Log, LogError> {
    let fail = |column: Option<&str>, kind| LogError {
        file: file.to_owned(),
        line: None,
        column: column.map(str::to_owned),
        kind,
    };
    let Recording { flight_controller, mut streams, facts, notes, unknown_fields, frame_turn_deg } = recording;
    let mut log =
        Log { path: file.to_owned(), flight_controller: Some(flight_controller), facts, notes, ..Log::default() };
    for stream in &mut streams {
        let gone = put_in_order(stream).map_err(|kind| fail(Some(&stream.name), kind))?;
        if gone > 0 {
            let name = &stream.name;
            log.notes.push(format!("{name}: {gone} readings replaced by the next one, whose time is not later"));
        }
        outside::settle(stream, &mut log.notes);
        repeats::take_out(stream, &mut log.notes);
    }
    let recording = Recording { streams, ..Recording::default() };
    let has_motors = (0..4).all(|motor| recording.find(Quantity::Motor(motor)).is_some());
    let mut all = Vec::new();
    for (stream, column) in Quantity::ALL.into_iter().filter_map(|quantity| recording.find(quantity)) {
        match Readings::of(stream, column, &mut log.notes) {
            Ok(readings) => all.extend(readings),
            // beside motors nobody needs them
            Err(_) if has_motors && matches!(column.quantity, Quantity::Command(_)) => {}
            Err(kind) => return Err(fail(Some(&column.source), kind)),
        }
    }
    let quantities = Quantities::of(all, &unknown_fields).map_err(|kind| fail(None, kind))?;
    let (quantities, rows_s) = quantities.covering_rows(&mut log.notes);
    fill(&mut log, &quantities, &rows_s);
    if log.rows() < ROWS_MIN {
        let kind = LogErrorKind::TooFewRowsInCommon { rows: log.rows(), streams: quantities.in_words(true) };
        return Err(fail(None, kind));
    }
    log.sent_commands = quantities.sent_beside(&log.time_s).map(Box::new);
    describe(&mut log, &quantities, rows_s.len(), map);
    log.turned(frame_turn_deg)
}

/// A log of rows some of whose values are missing, or no readings: each column has its own. What a map said is in
/// `log`.
///
/// # Errors
/// As [`log_of`].
pub(super) fn log_of_rows(file: &str, stream: Stream, log: Log) -> Result<Log, LogError> {
    let recording = Recording { streams: vec![stream], ..Recording::default() };
    let merged = log_of(file, recording, None)?;
    Ok(Log {
        comments: log.comments,
        notes: log.notes.into_iter().chain(merged.notes).collect(),
        axes: log.axes,
        active_when: log.active_when,
        motor_per_axis_command: log.motor_per_axis_command,
        rig: log.rig,
        flight_controller: None,
        ..merged
    })
}

/// The rows at which every quantity is there.
fn fill(log: &mut Log, quantities: &Quantities<'_>, rows_s: &[f64]) {
    let of = &quantities.of;
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(rows_s.len()); of.len()];
    let mut values = Vec::with_capacity(of.len());
    for time_s in rows_s {
        values.clear();
        values.extend(of.iter().map_while(|readings| readings.at(*time_s)));
        if values.len() == of.len() {
            log.time_s.push(*time_s);
            columns.iter_mut().zip(&values).for_each(|(column, value)| column.push(*value));
        }
    }
    for (readings, column) in of.iter().zip(columns) {
        log.set_column(readings.quantity, column);
    }
}

/// Commands per second below which a log says little about a vehicle whose motors follow within 30 to 60 ms.
pub(crate) const SLOW_HZ: f64 = 30.0;

/// What the log is about, when its motors run, and what its reader should know.
fn describe(log: &mut Log, quantities: &Quantities<'_>, rows_tried: usize, map: Option<&Map>) {
    let has = |quantity| quantities.find(quantity).is_some();
    log.axes = Axis::ALL.map(|axis| has(Quantity::Rate(axis)) || has(Quantity::Angle(axis)));
    // a controller stops its motors by 0
    let running = [Quantity::Motor(0), Quantity::Thrust].into_iter().find(|quantity| has(*quantity));
    log.active_when = running.map(|quantity| Threshold { quantity, above: 0.0 });
    if let Some(map) = map {
        log.axes = core::array::from_fn(|axis| log.axes[axis] && map.axes[axis]);
        log.active_when = map.active_when.or(log.active_when);
        map.tell(log);
    }
    log.notes.push(format!("readings per second: {}", quantities.in_words(false)));
    log.notes.extend(quantities.slow_commands());
    let assumed: Vec<String> = log.facts.iter().filter(|fact| fact.is_assumed).map(|fact| fact.to_string()).collect();
    if !assumed.is_empty() {
        log.notes.push(format!("assumed: {}", assumed.join("; ")));
    }
    if log.rows() < rows_tried {
        let left_out = rows_tried - log.rows();
        log.notes.push(format!("{left_out} rows left out, at which another stream has a gap"));
    }
    note_gaps(log);
}

/// The quantities that a log is made of.
struct Quantities<'a> {
    of: Vec<Readings<'a>>,
    /// Place of the one whose times are the rows'.
    rows: usize,
}

impl<'a> Quantities<'a> {
    /// Of all that were recorded: motors if there are four, else axis commands.
    fn of(mut all: Vec<Readings<'a>>, unknown: &[String]) -> Result<Quantities<'a>, LogErrorKind> {
        let is_motor = |quantity: Quantity| matches!(quantity, Quantity::Motor(_));
        let is_axis_command = |quantity: Quantity| matches!(quantity, Quantity::Command(_));
        let motors = all.iter().filter(|readings| is_motor(readings.quantity)).count();
        all.retain(
            |readings| !if motors == 4 { is_axis_command(readings.quantity) } else { is_motor(readings.quantity) },
        );
        let here: Vec<String> = all.iter().map(|readings| readings.quantity.name()).collect();
        let missing = |wanted| LogErrorKind::NoReadings { wanted, here: held(&here, unknown) };
        let rates = all.iter().position(|readings| matches!(readings.quantity, Quantity::Rate(_)));
        let angles = all.iter().position(|readings| matches!(readings.quantity, Quantity::Angle(_)));
        let Some(rows) = rates.or(angles) else { return Err(missing("body rates or angles")) };
        if !all.iter().any(|readings| is_motor(readings.quantity) || is_axis_command(readings.quantity)) {
            return Err(missing("outputs of four motors, or axis commands"));
        }
        Ok(Quantities { of: all, rows })
    }

    fn find(&self, quantity: Quantity) -> Option<&Readings<'a>> {
        self.of.iter().find(|readings| readings.quantity == quantity)
    }

    /// The times at which all that is needed can be there, and the quantities that cover them.
    fn covering_rows(mut self, notes: &mut Vec<String>) -> (Quantities<'a>, Vec<f64>) {
        let is_there = |time_s: &&f64| {
            self.of
                .iter()
                .filter(|readings| is_needed(readings.quantity))
                .all(|readings| readings.at(**time_s).is_some())
        };
        let rows_s: Vec<f64> = self.of[self.rows].time_s.iter().filter(is_there).copied().collect();
        let name_of_rows = self.of[self.rows].quantity;
        self.of.retain(|readings| {
            let covered = rows_s.iter().filter(|time_s| readings.at(**time_s).is_some()).count() as f64;
            let is_kept = is_needed(readings.quantity) || covered >= COVERS_MIN * rows_s.len() as f64;
            if !is_kept {
                let share_pct = 100.0 * covered / rows_s.len() as f64;
                notes.push(format!("{} left out: it is there in {share_pct:.0} % of the rows", readings.source));
            }
            is_kept
        });
        self.rows = self.of.iter().position(|readings| readings.quantity == name_of_rows).unwrap_or_default();
        let all_s = self.of[self.rows].time_s.clone();
        let ends = [rows_s.first(), rows_s.last()].map(|time_s| time_s.copied().unwrap_or(f64::NAN));
        let within = all_s.into_iter().filter(|time_s| (ends[0]..=ends[1]).contains(time_s)).collect();
        (self, within)
    }

    /// The commands at their own times, the first the one in force at the first row; none where these are the rows'.
    /// Where motors are logged nothing else drives the vehicle: stamps of a collective would make them look frequent.
    fn sent_beside(&self, rows_s: &[f64]) -> Option<Log> {
        let is_motor = |readings: &&Readings<'_>| matches!(readings.quantity, Quantity::Motor(_));
        let has_motors = self.of.iter().any(|readings| is_motor(&readings));
        let drives =
            |readings: &&Readings<'_>| readings.between == Between::Held && (!has_motors || is_motor(readings));
        let commands: Vec<&Readings<'_>> = self.of.iter().filter(drives).collect();
        let mut stamps: Vec<f64> = commands.iter().flat_map(|readings| readings.time_s.iter().copied()).collect();
        stamps.sort_by(f64::total_cmp);
        stamps.dedup();
        let in_force = |row_s: Option<&f64>| stamps.partition_point(|stamp| row_s.is_some_and(|row_s| stamp <= row_s));
        let first = in_force(rows_s.first()).saturating_sub(1);
        let stamps = &stamps[first..in_force(rows_s.last()).max(first)];
        if stamps == rows_s {
            return None;
        }
        let mut sent = Log::default();
        let held = |readings: &&Readings<'_>, stamp: f64| {
            let before = readings.time_s.partition_point(|reading_s| *reading_s <= stamp).checked_sub(1)?;
            readings.value.get(before).copied()
        };
        let is_whole = |stamp: &&f64| commands.iter().all(|readings| held(readings, **stamp).is_some());
        sent.time_s = stamps.iter().filter(is_whole).copied().collect();
        for readings in &commands {
            let column = sent.time_s.iter().filter_map(|stamp| held(readings, *stamp)).collect();
            sent.set_column(readings.quantity, column);
        }
        sent.axes = Axis::ALL.map(|axis| sent.axis_command[axis.index()].is_some());
        Some(sent)
    }

    /// What to think of commands that come more seldom than a vehicle answers.
    fn slow_commands(&self) -> Option<String> {
        let is_command = |quantity| matches!(quantity, Quantity::Motor(_) | Quantity::Command(_));
        let slowest = self.of.iter().filter(|readings| is_command(readings.quantity)).map(Readings::rate_hz);
        let rate_hz = slowest.fold(f64::INFINITY, f64::min);
        (rate_hz < SLOW_HZ).then(|| {
            format!(
                "commands were logged {rate_hz:.0} times a second: what they were in between nobody knows, and such a \
                 log hardly shows how late and how much a vehicle answers; {SLOW_HZ:.0} and more would"
            )
        })
    }

    /// Source, readings per second and, if wanted, span of each quantity's readings, equal ones once.
    fn in_words(&self, with_span: bool) -> String {
        let mut words: Vec<String> = Vec::new();
        for readings in &self.of {
            let message = readings.source.split('.').next().unwrap_or(readings.source);
            let [from_s, to_s] = readings.span_s();
            let span = if with_span { format!(" from {from_s:.2} s to {to_s:.2} s") } else { String::new() };
            let word = format!("{message} {:.0}{span}", readings.rate_hz());
            if !words.contains(&word) {
                words.push(word);
            }
        }
        words.join(", ")
    }
}

/// Whether rows without it are no rows.
fn is_needed(quantity: Quantity) -> bool {
    use Quantity::{Angle, Command, Motor, Rate, Thrust};
    matches!(quantity, Rate(_) | Angle(_) | Motor(_) | Command(_) | Thrust)
}
